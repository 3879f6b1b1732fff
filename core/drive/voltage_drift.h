/* What the voltage model gets wrong, learned from the injection.
 *
 * A wrong voltage lets the flux drift; the observer turns it back, in rad/s of the flux. There are
 * three kinds:
 *
 *   dead   dead time: the error changes its sign with the torque current, whatever its size. It is
 *          taken as voltage that the inverter's legs lose, in the direction of their currents
 *   res    resistance: the error grows with the torque current
 *   even   all other errors: what is left without torque, and at speed, where errors of the
 *          inductances drift faster than those of the voltages
 *
 * The injection's error tells their sum. The torque current's low-passed sign, which is small
 * without torque, at speed, and while the current swings about zero, decides between even and the
 * other two, and these share by their variances at the present current. A reversal of torque thus
 * turns dead and res at once. Learned in the periods that have time for it.
 * docs/coupled-observer.md derives it.
 */
#ifndef SENSORLESS_VOLTAGE_DRIFT_H
#define SENSORLESS_VOLTAGE_DRIFT_H

#include "dead_time.h"

typedef struct {
    float k;          /* from the injection's angle error to the drifts [1/s^2] times T_s */
    float most;       /* bound on dead and even [rad/s] */
    float res_most;   /* bound on res [rad/s] */
    float alpha;      /* low-pass of the sign: 1 - exp(-w T), T between uses */
    float inv_omega;  /* 1 / speed from which all is even [s/rad] */
    float inv_i_true; /* slope of the inverter's dead-time voltage through zero current [1/A] */
    float inv_i;      /* 1 / rated current [1/A] */
    float dead_share; /* variance of dead over that of dead + res at rated current */
    float u_dt;       /* dead-time voltage of a leg that the drive compensates [V] */
    float u_dt_i;     /* its slope through zero current [V/A] */
    float to_loss;    /* voltage of a leg over its drift [V s/rad] */
    float from_loss;  /* drift over the voltage of a leg [rad/(s V)] */
    float loss_max;   /* largest voltage that a leg loses [V] */
} drift_params_t;

typedef struct {
    float dead; /* drift by dead time at positive torque current [rad/s] */
    float res;  /* drift by resistance at rated torque current [rad/s] */
    float even; /* [rad/s] */
    float sign; /* low-passed sign of the torque current, 0 at speed */
    float loss; /* voltage that a leg loses [V], from dead */
    float turn; /* res, and what the loss does not explain of dead [rad/s] */
    float sum;  /* of the injection's angle errors since the last use [rad] */
} drift_state_t;

/* Turn of the flux by the drifts that are not voltage lost [rad/s]; i_q: torque current [A]. */
CORE_INLINE float drift_turn(const drift_params_t *p, const drift_state_t *x, float i_q) {
    return x->even + x->turn * clamp_f(i_q * p->inv_i, -1.0f, 1.0f);
}

/* Learns the drifts, if `now`. err: angle error by injection times its weight [rad], summed until
 * then; i_q: torque current [A]; omega: speed, electrical [rad/s]. */
CORE_INLINE void drift_learn(const drift_params_t *p, drift_state_t *x, int now, float err,
                             float i_q, float omega) {
    float sum = x->sum + err;
    x->sum = now ? 0.0f : sum;
    if (SHORTCUT(!now)) {
        return;
    }
    float slow = max_f(1.0f - p->inv_omega * abs_f(omega), 0.0f);
    float sign = x->sign + p->alpha * (slow * bound_f(i_q * p->inv_i_true, 1.0f) - x->sign);
    float even = bound_f(x->even + p->k * (1.0f - sign * sign) * sum, p->most);
    float i = min_f(abs_f(i_q) * p->inv_i, 1.0f);
    float res_share = i - i * p->dead_share; /* over i */
    float step = p->k * sign * sum / (p->dead_share + i * res_share);
    float dead = bound_f(x->dead + p->dead_share * step, p->most);
    float res = bound_f(x->res + res_share * step, p->res_most);
    float loss = clamp_f(p->u_dt - p->to_loss * dead, 0.0f, p->loss_max);
    x->sign = now ? sign : x->sign;
    x->even = now ? even : x->even;
    x->dead = now ? dead : x->dead;
    x->res = now ? res : x->res;
    x->loss = now ? loss : x->loss;
    x->turn = now ? res + dead + p->from_loss * (loss - p->u_dt) : x->turn;
}

/* Nothing learned yet. */
CORE_INLINE void drift_clear(const drift_params_t *p, drift_state_t *x) {
    x->dead = 0.0f;
    x->res = 0.0f;
    x->even = 0.0f;
    x->sign = 0.0f;
    x->loss = p->u_dt;
    x->turn = 0.0f;
    x->sum = 0.0f;
}

#endif
