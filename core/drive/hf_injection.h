/* Rotor angle from square-wave voltage injection on the estimated d axis.
 *
 * A voltage of +-u_inj, whose sign changes every period, is added on the d axis of this estimator's
 * own frame. The current responds with (u_inj T_s / 2) L^-1; its q part in that frame is
 *   (u_inj T_s / 2)(1/L_d - 1/L_q) sin(e) cos(e),  e = theta_e - theta_e_hat_hfi.
 * Divided by the magnitude of the response, it has slope 1 - L_d/L_q at e = 0 (doi
 * 10.12177/emca.2025.011, Eqs. 3-7, with incremental inductances and the sign restored).
 *
 * Demodulation: with HFI_ROTATING, each sample is turned into the frame at the angle of its
 * instant, and the second difference x = s (i(k) - 2 i(k-1) + i(k-2)) / 4 removes everything except
 * the alternating part; s is the sign of the voltage that was applied over [k-1, k]. With one
 * period of computation delay, that voltage was computed at k-2: signs wait in a queue, and the
 * parity of k is never used. A correction of the angle turns the frame beyond its speed between two
 * samples. The old sample is turned as far: a d current would answer the correction otherwise, and
 * the loop swing at a quarter of the PWM frequency (docs/theory-injection.md).
 *
 * Magnetic cross-coupling turns the lock point by theta_cross (half the angle of Eq. 16), a
 * function of the torque current; the caller adds it to the angle.
 */
#ifndef SENSORLESS_HF_INJECTION_H
#define SENSORLESS_HF_INJECTION_H

#include "pll.h"
#include "trig.h"
#include "vector.h"

/* How the alternating part of the current is found: hfi_params_t.scheme. */
enum {
    HFI_ROTATING = 0,  /* second difference of samples in the rotating estimated frame */
    HFI_STATIONARY = 1 /* Eq. 9 as published, for comparison: first difference in the stator frame,
                          turned by theta_e_hat(k), half a period late */
};

typedef struct {
    pll_params_t pll;
    float u_inj;      /* amplitude of the injected voltage [V] */
    float i_floor;    /* least magnitude that the error is divided by [A] */
    float n_hold;     /* periods that injection stays on after the last request */
    float lead;       /* turn of the voltage beyond the angle at k+1 [periods]: 0.5; -1: no cure */
    float alpha_rise; /* low-pass on the error for the bandwidth's rise: 1 - exp(-w T_s) */
    float err_rise;   /* low-passed error above which the bandwidth rises [1] */
    float rise;       /* its rise with the error above that [1] */
    float rise_max;   /* its largest rise, as a share of the bandwidth */
    int scheme;       /* HFI_* */
} hfi_params_t;

typedef struct {
    pll_state_t pll; /* lock angle, without compensation of cross-coupling */
    dq_t i_1;        /* sample k-1 in the frame of the scheme [A] */
    dq_t i_2;        /* sample k-2, turned by the jump of the frame from then to k-1 [A] */
    float jump;      /* turn of the frame since k-1 beyond its speed [rad] */
    float sign_1;    /* sign of the injection applied over [k, k+1]: +-1, or 0 when off */
    float sign_2;    /* over [k-1, k] */
    float sign_3;    /* over [k-2, k-1] */
    float hold;      /* periods left before the injection stops */
    float err;       /* last normalised error signal [1] */
    float err_f;     /* low-passed [1] */
    float amplitude; /* last magnitude of the high-frequency current [A] */
    float answer;    /* its part along the injected axis, above 0 at any angle error [A] */
    float valid;     /* 1 when the last error came from a full alternating window */
} hfi_state_t;

/* Demodulates one sample. i_ab: measured current at k [A]; r: direction of the injected axis at
 * k. */
CORE_INLINE void hfi_demodulate(const hfi_params_t *p, hfi_state_t *x, ab_t i_ab, rot_t r) {
    dq_t i = ab_to_dq(i_ab, r);
    dq_t turned = {x->jump * x->i_1.q, -x->jump * x->i_1.d};
    dq_t step = {i.d - 2.0f * x->i_1.d + x->i_2.d - turned.d,
                 i.q - 2.0f * x->i_1.q + x->i_2.q - turned.q};
    float quarter = 0.25f * x->sign_2;
    float answer = quarter * step.d;
    if (SCALAR_ONLY(p->scheme == HFI_STATIONARY)) {
        ab_t bend = {i_ab.a - 2.0f * x->i_1.d + x->i_2.d, i_ab.b - 2.0f * x->i_1.q + x->i_2.q};
        answer = quarter * ab_to_dq(bend, r).d;
        ab_t twice = {2.0f * (i_ab.a - x->i_1.d), 2.0f * (i_ab.b - x->i_1.q)};
        step = ab_to_dq(twice, r);
        i.d = i_ab.a;
        i.q = i_ab.b;
        turned.d = 0.0f;
        turned.q = 0.0f;
    }
    float x_d = quarter * step.d;
    float x_q = quarter * step.q;
    int valid = x->sign_2 * x->sign_3 < 0.0f;
    x->answer = answer;
    x->amplitude = sqrt_f(x_d * x_d + x_q * x_q);
    x->err = valid ? x_q / max_f(x->amplitude, p->i_floor) : 0.0f;
    x->valid = valid ? 1.0f : 0.0f;
    x->i_2.d = x->i_1.d + turned.d;
    x->i_2.q = x->i_1.q + turned.q;
    x->i_1 = i;
}

/* Advances the PLL. A load that comes or goes on little inertia leaves it behind by its torque over
 * inertia and bandwidth squared; where the low-passed error is that large, the bandwidth rises.
 * theta_idle, omega_idle: angle and speed to follow while there is no injection to measure, in this
 * estimator's uncompensated frame at instant k [rad, rad/s]. */
CORE_INLINE void hfi_follow(const hfi_params_t *p, hfi_state_t *x, float theta_idle,
                            float omega_idle, float T_s) {
    int valid = x->valid > 0.0f;
    x->pll.theta = valid ? x->pll.theta : theta_idle;
    x->pll.omega = valid ? x->pll.omega : omega_idle;
    x->err_f = valid ? x->err_f + p->alpha_rise * (x->err - x->err_f) : 0.0f;
    float rise = clamp_f(p->rise * (abs_f(x->err_f) - p->err_rise), 0.0f, p->rise_max);
    pll_step_faster(&p->pll, &x->pll, x->err, 1.0f + rise, T_s);
}

/* Demodulates one sample and advances the PLL. i_ab: measured current at k [A]. */
CORE_INLINE void hfi_observe(const hfi_params_t *p, hfi_state_t *x, ab_t i_ab, float theta_idle,
                             float omega_idle, float T_s) {
    hfi_demodulate(p, x, i_ab, rot_of(x->pll.theta));
    hfi_follow(p, x, theta_idle, omega_idle, T_s);
}

/* Direction of the voltage that is injected over [k+1, k+2], at k after hfi_observe. */
CORE_INLINE rot_t hfi_direction(const hfi_params_t *p, const hfi_state_t *x, float T_s) {
    return rot_of(x->pll.theta + p->lead * T_s * x->pll.omega);
}

/* Ends injection at once: nothing of it waits, no sample is read for its answer, and what signals
 * read of it is 0. */
CORE_INLINE void hfi_quiet(hfi_state_t *x) {
    x->err = 0.0f;
    x->amplitude = 0.0f;
    x->valid = 0.0f;
    x->hold = 0.0f;
    x->sign_1 = 0.0f;
    x->sign_2 = 0.0f;
    x->sign_3 = 0.0f;
}

/* Advances the queue and returns the sign of the injection to apply over [k+1, k+2]. wanted: != 0
 * keeps injection on; it stops n_hold periods after the last request. */
CORE_INLINE float hfi_inject(const hfi_params_t *p, hfi_state_t *x, int wanted) {
    x->hold = wanted ? p->n_hold : max_f(x->hold - 1.0f, 0.0f);
    float next = x->sign_1 > 0.0f ? -1.0f : 1.0f;
    next = x->hold > 0.0f ? next : 0.0f;
    x->sign_3 = x->sign_2;
    x->sign_2 = x->sign_1;
    x->sign_1 = next;
    return next;
}

#endif
