/* What a schedule may use: quantities that the firmware knows, filtered and scaled.
 *
 * The same values feed the learned policy on the host and the table on the target. This enumeration
 * fixes their order and scaling. Signed quantities are multiplied by the sign of the filtered
 * speed, so that they are the same for both directions of rotation.
 */
#ifndef SENSORLESS_SIGNALS_H
#define SENSORLESS_SIGNALS_H

#include <stdint.h>

#include "frames.h"

enum {
    SIGNAL_SPEED = 0,      /* |omega_e_hat| / omega_rated */
    SIGNAL_TORQUE_CURRENT, /* i_q in the direction of motion / i_rated: > 0 motoring */
    SIGNAL_DISAGREEMENT,   /* disagreement() in the direction of motion / 30 deg */
    SIGNAL_ACCELERATION,   /* d|omega_e_hat|/dt / (omega_rated per second) */
    SIGNAL_SPEED_ERROR,    /* (omega_ref - omega_e_hat) in the direction of motion / omega_rated */
    SIGNAL_SPEED_REF,      /* omega_ref in the direction of motion / omega_rated */
    SIGNAL_K_S,            /* the weight in force */
    SIGNAL_EMF,            /* |e| / rated no-load EMF */
    SIGNAL_HF_AMPLITUDE,   /* magnitude of the injected current / its no-load value */
    SIGNAL_HFI_RESIDUAL,   /* RMS of the injection error signal / 0.5 */
    SIGNAL_SMO_RESIDUAL,   /* RMS of the EMF error signal / 0.5 */
    SIGNAL_VOLTAGE,        /* wanted voltage / voltage limit */
    SIGNAL_N
};

typedef struct {
    float alpha;       /* low-pass of every signal: 1 - exp(-alpha_per_s T_s) */
    float alpha_per_s; /* its corner [rad/s], for the derivative */
    float inv_omega;   /* 1 / rated electrical speed [s/rad] */
    float inv_i;       /* 1 / rated current, peak [1/A] */
    float inv_e;       /* 1 / (rated speed times magnet flux) [1/V] */
    float inv_i_hf;    /* 1 / (u_inj T_s / (2 L_d)) [1/A] */
} signal_params_t;

typedef struct {
    float omega;     /* filtered speed estimate, electrical [rad/s] */
    float omega_2;   /* filtered again; the difference gives the acceleration [rad/s] */
    float omega_ref; /* reference of this period [rad/s] */
    float i_q;       /* filtered torque current [A] */
    float disagree;  /* filtered disagreement() of theta_hfi and theta_smo [rad] */
    float emf;       /* filtered |e| [V] */
    float hf;        /* filtered magnitude of the high-frequency current [A] */
    float hfi_var;   /* mean square of the injection error signal */
    float smo_var;   /* mean square of the EMF error signal */
    float voltage;   /* filtered ratio of wanted voltage to limit */
    float k_s;       /* weight in force */
} signal_state_t;

/* Difference of angles d in [-pi, pi] as a signal: d up to a quarter turn, from there on falling to
 * 0 at half a turn. While one estimate slips past the other, d itself jumps there from one end of
 * its range to the other, and a schedule with it. */
CORE_INLINE float disagreement(float d) { return 2.0f * bound_f(d, HALF_PI_F) - d; }

/* All signals at rest. */
CORE_INLINE void signals_clear(signal_state_t *x) {
    x->omega = 0.0f;
    x->omega_2 = 0.0f;
    x->omega_ref = 0.0f;
    x->i_q = 0.0f;
    x->disagree = 0.0f;
    x->emf = 0.0f;
    x->hf = 0.0f;
    x->hfi_var = 0.0f;
    x->smo_var = 0.0f;
    x->voltage = 0.0f;
    x->k_s = 0.0f;
}

/* Low-pass filters speed [rad/s], torque current [A] and the difference of the two angles, in
 * [-pi, pi] [rad]. */
CORE_INLINE void signals_filter(const signal_params_t *p, signal_state_t *x, float omega, float i_q,
                                float difference) {
    x->omega += p->alpha * (omega - x->omega);
    x->omega_2 += p->alpha * (x->omega - x->omega_2);
    x->i_q += p->alpha * (i_q - x->i_q);
    x->disagree += p->alpha * (disagreement(difference) - x->disagree);
}

/* Direction of motion: 1 or -1. */
CORE_INLINE float signals_direction(const signal_state_t *x) { return sign_f(x->omega); }

/* The signal SIGNAL_* in `which`; dir: signals_direction. */
CORE_INLINE float signal_at(const signal_params_t *p, const signal_state_t *x, float dir,
                            uint32_t which) {
    switch (which) {
    case SIGNAL_SPEED:
        return abs_f(x->omega) * p->inv_omega;
    case SIGNAL_TORQUE_CURRENT:
        return dir * x->i_q * p->inv_i;
    case SIGNAL_DISAGREEMENT:
        return dir * x->disagree * (6.0f / PI_F);
    case SIGNAL_ACCELERATION:
        return dir * p->alpha_per_s * (x->omega - x->omega_2) * p->inv_omega;
    case SIGNAL_SPEED_ERROR:
        return dir * (x->omega_ref - x->omega) * p->inv_omega;
    case SIGNAL_SPEED_REF:
        return dir * x->omega_ref * p->inv_omega;
    case SIGNAL_K_S:
        return x->k_s;
    case SIGNAL_EMF:
        return x->emf * p->inv_e;
    case SIGNAL_HF_AMPLITUDE:
        return x->hf * p->inv_i_hf;
    case SIGNAL_HFI_RESIDUAL:
        return 2.0f * sqrt_f(x->hfi_var);
    case SIGNAL_SMO_RESIDUAL:
        return 2.0f * sqrt_f(x->smo_var);
    default: /* SIGNAL_VOLTAGE */
        return x->voltage;
    }
}

/* Fills y[SIGNAL_N]. */
CORE_INLINE void signals_read(const signal_params_t *p, const signal_state_t *x, float *y) {
    float dir = signals_direction(x);
    y[SIGNAL_SPEED] = signal_at(p, x, dir, SIGNAL_SPEED);
    y[SIGNAL_TORQUE_CURRENT] = signal_at(p, x, dir, SIGNAL_TORQUE_CURRENT);
    y[SIGNAL_DISAGREEMENT] = signal_at(p, x, dir, SIGNAL_DISAGREEMENT);
    y[SIGNAL_ACCELERATION] = signal_at(p, x, dir, SIGNAL_ACCELERATION);
    y[SIGNAL_SPEED_ERROR] = signal_at(p, x, dir, SIGNAL_SPEED_ERROR);
    y[SIGNAL_SPEED_REF] = signal_at(p, x, dir, SIGNAL_SPEED_REF);
    y[SIGNAL_K_S] = signal_at(p, x, dir, SIGNAL_K_S);
    y[SIGNAL_EMF] = signal_at(p, x, dir, SIGNAL_EMF);
    y[SIGNAL_HF_AMPLITUDE] = signal_at(p, x, dir, SIGNAL_HF_AMPLITUDE);
    y[SIGNAL_HFI_RESIDUAL] = signal_at(p, x, dir, SIGNAL_HFI_RESIDUAL);
    y[SIGNAL_SMO_RESIDUAL] = signal_at(p, x, dir, SIGNAL_SMO_RESIDUAL);
    y[SIGNAL_VOLTAGE] = signal_at(p, x, dir, SIGNAL_VOLTAGE);
}

#endif
