/* Gains of the drive that a schedule may change besides k_s.
 *
 * Each is a value v in [least, most], inside [-1, 1], around the number that the drive was designed
 * with:
 *
 *   gain = static gain * factor,   factor = 1 + v (rise + bend v)
 *
 * so the value 0 is the static gain to the bit. At each decision a value goes the share `pace` of
 * the way to the one wanted, so it changes by at most 2 pace. The gains of a loop follow from its
 * scheduled bandwidth w: k_p = 2 d w and k_i = w^2 of a PLL become factor k_p and factor^2 k_i; so do
 * the bounds on the answer to the injection from its voltage, and lock.L_q_true, which is relative to
 * the observer's inductance. What only bounds or corrects such a
 * loop (coupled.eps_rise and rise, match, drift.alpha, hfi.i_floor), and the unit of the signal
 * SIGNAL_HF_AMPLITUDE, stay those of the static gain. The drive runs on a copy of its parameters in
 * which these gains are replaced; drive_step does not know of it.
 */
#ifndef SENSORLESS_GAINS_H
#define SENSORLESS_GAINS_H

#include "drive_types.h"

/* The gains: indices of the arrays below. */
enum {
    GAIN_OBSERVER = 0, /* bandwidth of the observer: its PLL, or all poles of the coupled one */
    GAIN_INJECTION,    /* bandwidth of the injection estimator, or of injection's correction */
    GAIN_L_Q,          /* apparent q inductance of the observer */
    GAIN_AMPLITUDE,    /* injected voltage */
    GAIN_N
};

typedef struct {
    float rise;  /* slope of the factor at the static gain */
    float bend;  /* its change with the value */
    float least; /* bounds on the value */
    float most;
    float pace; /* share of the way to the wanted value, per decision */
} gain_limits_t;

/* x in the bounds of a gain; NaN counts as 0, the static gain. */
CORE_INLINE float gain_bounded(const gain_limits_t *p, float x) {
    return clamp_f(x == x ? x : 0.0f, p->least, p->most);
}

CORE_INLINE void gain_pll(const pll_params_t *from, pll_params_t *to, float factor) {
    to->k_p = from->k_p * factor;
    to->k_i = from->k_i * factor * factor;
}

CORE_INLINE void gain_observer(const drive_params_t *from, drive_params_t *to, float factor) {
    if (from->estimator == ESTIMATE_COUPLED) {
        float square = factor * factor;
        to->coupled.k_p = from->coupled.k_p * factor;
        to->coupled.k_i = from->coupled.k_i * square;
        to->coupled.k_l = from->coupled.k_l * square * factor;
    } else if (from->estimator == ESTIMATE_FLUX) {
        gain_pll(&from->flux.pll, &to->flux.pll, factor);
    } else {
        gain_pll(&from->smo.pll, &to->smo.pll, factor);
    }
}

CORE_INLINE void gain_injection(const drive_params_t *from, drive_params_t *to, float factor) {
    if (from->estimator == ESTIMATE_COUPLED) {
        to->coupled.k_h = from->coupled.k_h * factor;
        to->coupled.drift.k = from->coupled.drift.k * factor * factor;
    } else {
        gain_pll(&from->hfi.pll, &to->hfi.pll, factor);
    }
}

/* Writes one gain into the copy `to` of the drive's parameters. */
CORE_INLINE void gain_apply(uint32_t which, float factor, const drive_params_t *from,
                            drive_params_t *to) {
    switch (which) {
    case GAIN_OBSERVER:
        gain_observer(from, to, factor);
        break;
    case GAIN_INJECTION:
        gain_injection(from, to, factor);
        break;
    case GAIN_L_Q:
        for (int j = 0; j < CURVE_N; j++) {
            to->L_q.y[j] = from->L_q.y[j] * factor;
        }
        to->lock.L_q_true = from->lock.L_q_true / factor; /* the machine stays what it is */
        break;
    default: /* GAIN_AMPLITUDE */
        to->hfi.u_inj = from->hfi.u_inj * factor;
        lock_bounds(&to->lock, to->hfi.u_inj);
        break;
    }
}

/* Moves the value of one gain towards `wanted`, keeps it in its bounds and applies it. Returns the
 * value in force. */
CORE_INLINE float gain_step(const gain_limits_t *p, uint32_t which, float value, float wanted,
                            const drive_params_t *from, drive_params_t *to) {
    float v = gain_bounded(p, value + p->pace * (wanted - value));
    gain_apply(which, 1.0f + v * (p->rise + p->bend * v), from, to);
    return v;
}

#endif
