/* What the voltage model gets wrong, learned from the injection.
 *
 * A wrong voltage lets the flux drift; the observer turns it back, in rad/s of the flux. There are
 * two kinds:
 *
 *   odd    dead time and resistance: the error changes its sign with the torque current. With the
 *          sign at once, a reversal of torque does not throw the flux. A part of this drift is
 *          taken as voltage that the inverter's legs lose, in the direction of their currents; the
 *          rest turns the flux, in proportion to the torque current up to a limit
 *   even   all other errors: what is left without torque, and at speed, where errors of the
 *          inductances drift faster than those of the voltages
 *
 * The injection's error tells their sum. It goes to one or the other by the torque current's
 * low-passed sign, which is small without torque, at speed, and while the current swings about
 * zero. Learned in the periods that have time for it. docs/coupled-observer.md derives it.
 */
#ifndef SENSORLESS_VOLTAGE_DRIFT_H
#define SENSORLESS_VOLTAGE_DRIFT_H

#include "dead_time.h"

typedef struct {
    float k;          /* from the injection's angle error to both drifts [1/s^2] times T_s */
    float most;       /* bound on each [rad/s] */
    float alpha;      /* low-pass of the sign: 1 - exp(-w T), T between uses */
    float inv_omega;  /* 1 / speed from which there is no odd one [s/rad] */
    float inv_i_true; /* slope of the inverter's dead-time voltage through zero current [1/A] */
    float inv_i_turn; /* slope of the odd drift's rest [1/A] */
    float u_dt;       /* dead-time voltage of a leg that the drive compensates [V] */
    float u_dt_i;     /* its slope through zero current [V/A] */
    float to_loss;    /* voltage of a leg that stands for the odd drift [V s/rad] */
    float from_loss;  /* odd drift that a voltage of a leg stands for [rad/(s V)] */
    float loss_max;   /* largest voltage that a leg loses [V] */
} drift_params_t;

typedef struct {
    float odd;    /* drift at rated positive torque current [rad/s] */
    float even;   /* [rad/s] */
    float sign;   /* low-passed sign of the torque current, 0 at speed */
    float loss;   /* voltage that a leg loses [V], from odd */
    float loss_i; /* its slope through zero current [V/A] */
    float rest;   /* what this does not explain of odd [rad/s] */
    float sum;    /* of the injection's angle errors since the last use [rad] */
} drift_state_t;

/* Turn of the flux by the drifts that are not voltage lost [rad/s]; i_q: torque current [A]. */
CORE_INLINE float drift_turn(const drift_params_t *p, const drift_state_t *x, float i_q) {
    return x->even + x->rest * clamp_f(i_q * p->inv_i_turn, -1.0f, 1.0f);
}

/* Learns both drifts, if `now`. err: angle error by injection times its weight [rad], summed until
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
    float odd = bound_f(x->odd + p->k * sign * sum, p->most);
    float even = bound_f(x->even + p->k * (1.0f - sign * sign) * sum, p->most);
    float loss = clamp_f(p->u_dt - p->to_loss * odd, 0.0f, p->loss_max);
    x->sign = now ? sign : x->sign;
    x->odd = now ? odd : x->odd;
    x->even = now ? even : x->even;
    x->loss = now ? loss : x->loss;
    x->loss_i = now ? p->inv_i_true * loss : x->loss_i;
    x->rest = now ? odd + p->from_loss * (loss - p->u_dt) : x->rest;
}

/* Nothing learned yet. */
CORE_INLINE void drift_clear(const drift_params_t *p, drift_state_t *x) {
    x->odd = 0.0f;
    x->even = 0.0f;
    x->sign = 0.0f;
    x->loss = p->u_dt;
    x->loss_i = p->inv_i_true * p->u_dt;
    x->rest = 0.0f;
    x->sum = 0.0f;
}

#endif
