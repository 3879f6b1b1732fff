/* Magnetic model: currents from flux linkages, derived from an energy function.
 *
 *   i_d = (a_d0 + a_dd |psi_d|^S + a_dq/(V+2) |psi_d|^U |psi_q|^(V+2)) psi_d
 *         + G_b (psi_d - psi_n) - i_f
 *   i_q = (a_q0 + a_qq |psi_q|^T + a_dq/(U+2) |psi_d|^(U+2) |psi_q|^V) psi_q + k_q G_b psi_q
 *   G_b = a_b s^W / (1 + a_bp s^W),  s^2 = (psi_d - psi_n)^2 + k_q psi_q^2
 *
 * (doi 10.1109/TIA.2016.2644624; with the bridge term doi 10.1109/ICEM60801.2024.10700403.) The
 * form is reciprocal: di_d/dpsi_q = di_q/dpsi_d. A linear machine is a_d0 = 1/L_d, a_q0 = 1/L_q,
 * i_f = psi_f/L_d and zeros. What a machine has beyond this form is in flux_correction.h.
 */
#ifndef SENSORLESS_FLUX_MAP_H
#define SENSORLESS_FLUX_MAP_H

#include <stdint.h>

#include "drive/frames.h"
#include "flux_correction.h"

typedef struct {
    double a_d0; /* [1/H] */
    double a_dd; /* [1/(H Vs^S)] */
    double a_q0; /* [1/H] */
    double a_qq; /* [1/(H Vs^T)] */
    double c_d;  /* a_dq / (V + 2) */
    double c_q;  /* a_dq / (U + 2) */
    double i_f;  /* magnet as an equivalent current [A] */
    double a_b;  /* bridge, 0 = none [1/(H Vs^W)] */
    double a_bp; /* [1/Vs^W] */
    double k_q;
    double psi_n;          /* [Vs] */
    int32_t S, T, U, V, W; /* exponents 0 ... 7 */
    uint32_t correction;   /* key of its correction, 0 = none */
} flux_map_t;

/* What a map has beyond saturation. */
enum {
    EXTRA_NONE = 0,
    EXTRA_BRIDGE = 1,
    EXTRA_CORRECTION = 2 /* and a bridge, whose a_b may be 0 */
};

/* x^n for n = 0 ... 7, without a branch. */
CORE_INLINE double pow_n(double x, int32_t n) {
    double x2 = x * x;
    double y = (n & 1) != 0 ? x : 1.0;
    y *= (n & 2) != 0 ? x2 : 1.0;
    y *= (n & 4) != 0 ? x2 * x2 : 1.0;
    return y;
}

/* Currents [A] at flux linkages psi [Vs]. extra: EXTRA_*; if it is constant at a call, machines
 * without a term do not pay for it. */
CORE_INLINE dq64_t flux_map_current(const flux_map_t *p, dq64_t psi, int extra) {
    double ad = psi.d < 0.0 ? -psi.d : psi.d;
    double aq = psi.q < 0.0 ? -psi.q : psi.q;
    double cross = pow_n(ad, p->U) * pow_n(aq, p->V);
    double d2 = psi.d * psi.d;
    double q2 = psi.q * psi.q;
    dq64_t i = {
        (p->a_d0 + p->a_dd * pow_n(ad, p->S) + p->c_d * cross * q2) * psi.d - p->i_f,
        (p->a_q0 + p->a_qq * pow_n(aq, p->T) + p->c_q * cross * d2) * psi.q,
    };
    if (extra != EXTRA_NONE) {
        double n = psi.d - p->psi_n;
        double s_w = pow_n(__builtin_sqrt(n * n + p->k_q * q2), p->W);
        double g = p->a_b * s_w / (1.0 + p->a_bp * s_w);
        i.d += g * n;
        i.q += p->k_q * g * psi.q;
    }
    if (extra == EXTRA_CORRECTION) {
        dq64_t y = flux_correction_of(p->correction, psi);
        i.d += y.d;
        i.q += y.q;
    }
    return i;
}

/* Currents [A] at n flux linkages (psi[2 j], psi[2 j + 1]) [Vs]. */
void flux_map_currents(const flux_map_t *p, int32_t extra, const double *psi, double *i, int32_t n);

#endif
