/* What the voltage model gets wrong, learned from the injection.
 *
 * A wrong voltage lets the flux drift; the observer turns it back, in rad/s of the flux. There are
 * four kinds:
 *
 *   dead   dead time: the error changes its sign with the torque current, whatever its size. It is
 *          taken as voltage that the inverter's legs lose, in the direction of their currents
 *   res    resistance: the error grows with the torque current
 *   ind    inductances: the error grows with the torque current and with the speed
 *   even   all other errors: what is left without torque. Most are injection's own, so without
 *          injection it fades
 *
 * The injection's error tells their sum. The torque current's low-passed sign, which is small
 * without torque and while the current swings about zero, decides between even and the other three,
 * and these share by their variances at the present current and speed. A reversal of torque thus
 * turns all three at once, and a load that goes takes ind and res with it. Learned in the periods
 * that have time for it.
 *
 * Near zero current dead time makes a voltage that no current tells, so the flux is trusted less: the
 * observer follows it with a share of its bandwidth. And a loss that counts as too large there feeds
 * a swing of the current about zero, as one too small does not: so without steady torque it counts
 * as less than what was learned.
 * docs/coupled-learning.md derives it.
 */
#ifndef SENSORLESS_VOLTAGE_DRIFT_H
#define SENSORLESS_VOLTAGE_DRIFT_H

#include "dead_time.h"

/* Share of the learned loss that counts without steady torque: what was learned errs by a tenth. */
#define LOSS_SURE 0.9f

typedef struct {
    float k;          /* from the injection's angle error to the drifts [1/s^2] times T_s */
    float most;       /* bound on dead and even [rad/s] */
    float res_most;   /* bound on res [rad/s] */
    float ind_most;   /* bound on ind [rad/s] */
    float ind_0;      /* ind before anything was learned [rad/s] */
    float alpha;      /* low-pass of the sign: 1 - exp(-w T), T between uses */
    float inv_omega;  /* 1 / speed from which ind grows no more [s/rad] */
    float inv_i_true; /* slope of the inverter's dead-time voltage through zero current [1/A] */
    float inv_i;      /* 1 / rated current [1/A] */
    float dead_share; /* variance of dead over that of dead + res at rated current */
    float res_share;  /* that of res, over the same */
    float ind_share;  /* that of ind from 1 / inv_omega on, over the same */
    float u_dt;       /* dead-time voltage of a leg that the drive compensates [V] */
    float u_dt_i;     /* its slope through zero current [V/A] */
    float to_loss;    /* voltage of a leg over its drift [V s/rad] */
    float from_loss;  /* drift over the voltage of a leg [rad/(s V)] */
    float loss_max;   /* largest voltage that a leg loses [V] */
    float calm;       /* trust without torque current, above 0 to 1 */
    float calm_rise;  /* its rise with the torque current over rated */
} drift_params_t;

typedef struct {
    float dead;  /* drift by dead time at positive torque current [rad/s] */
    float res;   /* drift by resistance at rated torque current [rad/s] */
    float ind;   /* drift by inductances at rated torque current from 1 / inv_omega on [rad/s] */
    float even;  /* [rad/s] */
    float sign;  /* low-passed sign of the torque current */
    float loss;  /* voltage that a leg loses, as it counts [V], from dead and sign */
    float turn;  /* res, ind, and what the loss does not explain of dead [rad/s] */
    float sum;   /* of the injection's angle errors since the last use [rad] */
    float trust; /* share of its bandwidth with which the observer follows the flux */
} drift_state_t;

/* Torque current i_q [A] over rated, -1 to 1. */
CORE_INLINE float drift_load(const drift_params_t *p, float i_q) {
    return clamp_f(i_q * p->inv_i, -1.0f, 1.0f);
}

/* Turn of the flux by the drifts that are not voltage lost [rad/s]; load: of drift_load. */
CORE_INLINE float drift_turn(const drift_state_t *x, float load) {
    return x->even + x->turn * load;
}

/* Learns the drifts, if `now`. k_s: weight of injection; err: its angle error times that [rad],
 * summed until then; i_q: torque current [A]; load: of drift_load; omega: speed, electrical
 * [rad/s]. */
CORE_INLINE void drift_learn(const drift_params_t *p, drift_state_t *x, int now, float k_s,
                             float err, float i_q, float load, float omega) {
    float sum = x->sum + err;
    x->sum = now ? 0.0f : sum;
    if (SHORTCUT(!now)) {
        return;
    }
    float sign = x->sign + p->alpha * (bound_f(i_q * p->inv_i_true, 1.0f) - x->sign);
    x->sign = now ? sign : x->sign;
    float fade = k_s > 0.0f ? 0.0f : p->alpha * x->even;
    float even = bound_f(x->even + (1.0f - sign * sign) * (p->k * sum - fade), p->most);
    x->even = now ? even : x->even;
    float i = abs_f(load);
    float trust = min_f(p->calm + p->calm_rise * i, 1.0f);
    x->trust = now ? trust : x->trust;
    float w = min_f(abs_f(omega) * p->inv_omega, 1.0f);
    float by_res = i * p->res_share; /* weight of res, and of ind */
    float by_ind = i * w * p->ind_share;
    float step = p->k * sign * sum / (p->dead_share + i * (by_res + w * by_ind));
    float res = bound_f(x->res + by_res * step, p->res_most);
    x->res = now ? res : x->res;
    float ind = bound_f(x->ind + by_ind * step, p->ind_most);
    x->ind = now ? ind : x->ind;
    float dead = bound_f(x->dead + p->dead_share * step, p->most);
    x->dead = now ? dead : x->dead;
    float counts = LOSS_SURE + (1.0f - LOSS_SURE) * (sign * sign);
    float loss = clamp_f(counts * (p->u_dt - p->to_loss * dead), 0.0f, p->loss_max);
    x->loss = now ? loss : x->loss;
    x->turn = now ? res + w * ind + dead + p->from_loss * (loss - p->u_dt) : x->turn;
}

/* Nothing learned yet: only what the observer's L_q is too low by on purpose is known. */
CORE_INLINE void drift_clear(const drift_params_t *p, drift_state_t *x) {
    x->dead = 0.0f;
    x->res = 0.0f;
    x->ind = p->ind_0;
    x->even = 0.0f;
    x->sign = 0.0f;
    x->loss = p->u_dt;
    x->turn = 0.0f;
    x->sum = 0.0f;
    x->trust = 1.0f;
}

#endif
