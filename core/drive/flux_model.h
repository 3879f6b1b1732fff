/* Flux that the measured currents stand for, as both observers of the flux know it. */
#ifndef SENSORLESS_FLUX_MODEL_H
#define SENSORLESS_FLUX_MODEL_H

#include "curve.h"
#include "vector.h"

/* The machine at the present |i_q|. */
typedef struct {
    float R_s;        /* stator resistance [ohm] */
    float L_d;        /* [H] */
    float L_q;        /* psi_q / i_q [H] */
    float L_qq;       /* d psi_q / d i_q [H] */
    float psi_0;      /* d flux without d current [Vs] */
    float psi_sq_min; /* least square of the auxiliary flux that errors are divided by [(Vs)^2] */
} flux_model_t;

/* In the estimated rotor frame. An angle error delta = theta_e - theta_e_hat moves the flux of the
 * currents by -j delta aux:
 *   aux = psi_d - L_qq i_d + j (psi_q - L_d i_q)
 * (doi 10.1109/TIA.2018.2858753, there without saturation). */
typedef struct {
    dq_t psi;  /* flux of the currents [Vs] */
    dq_t aux;  /* auxiliary flux [Vs] */
    float inv; /* 1 / its square, or the bound on it [1/(Vs)^2] */
} flux_of_current_t;

CORE_INLINE flux_of_current_t flux_of_current(const flux_model_t *m, dq_t i) {
    flux_of_current_t y;
    y.psi.d = m->psi_0 + m->L_d * i.d;
    y.psi.q = m->L_q * i.q;
    y.aux.d = y.psi.d - m->L_qq * i.d;
    y.aux.q = y.psi.q - m->L_d * i.q;
    y.inv = 1.0f / max_f(y.aux.d * y.aux.d + y.aux.q * y.aux.q, m->psi_sq_min);
    return y;
}

/* Part of the error e along the auxiliary flux, over it: a wrong length. */
CORE_INLINE float flux_along(const flux_of_current_t *y, dq_t e) {
    return y->inv * (e.d * y->aux.d + e.q * y->aux.q);
}

/* Part of the error e across the auxiliary flux, over it: a wrong angle [rad], within +-1. */
CORE_INLINE float flux_across(const flux_of_current_t *y, dq_t e) {
    return bound_f(y->inv * (e.d * y->aux.q - e.q * y->aux.d), 1.0f);
}

#endif
