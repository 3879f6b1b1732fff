/* Harmonics of a machine, derived from one energy so that torque and voltage match.
 *
 * Flux linkages x = psi - m, m = (m_d cos 6 theta, m_q sin 6 theta): the magnet's fifth and seventh
 * harmonic are one sixth harmonic in the rotor frame. Field energy over 3/2:
 *   W(psi, theta) = W_0(x) + gamma/2 Re[(x_d - psi_0 + j x_q)^2 e^(-j 6 theta)]
 * with W_0 the energy of flux_map.h and psi_0 its flux of zero current, so that the second saliency
 * alone has no effect without current. Hence, with i_0 the currents of the flux map at x,
 *   i = dW/dpsi = i_0 + gamma (x_d - psi_0 - j x_q) e^(j 6 theta)    in complex numbers d + j q
 *   tau = 3/2 n_p (psi_d i_q - psi_q i_d - dW/dtheta)
 */
#ifndef SENSORLESS_HARMONICS_H
#define SENSORLESS_HARMONICS_H

#include "flux_map.h"

typedef struct {
    double m_d, m_q; /* sixth harmonic of the magnet's flux linkage in the rotor frame [Vs] */
    double gamma;    /* second saliency [1/H] */
    double psi_0;    /* d flux of zero current of the flux map [Vs] */
} harmonics_t;

/* Currents [A] and the torque over 3/2 n_p [Vs A] at flux linkages psi [Vs]. */
typedef struct {
    dq64_t i;
    double tau;
} response_t;

/* (c + j s)^6 */
CORE_INLINE dq64_t sixth_power(double c, double s) {
    double c2 = c * c - s * s;
    double s2 = 2.0 * c * s;
    double c4 = c2 * c2 - s2 * s2;
    double s4 = 2.0 * c2 * s2;
    dq64_t y = {c4 * c2 - s4 * s2, c4 * s2 + s4 * c2};
    return y;
}

/* turn: cos and sin of 6 theta_e */
CORE_INLINE dq64_t magnet_harmonic(const harmonics_t *p, dq64_t turn) {
    dq64_t m = {p->m_d * turn.d, p->m_q * turn.q};
    return m;
}

CORE_INLINE response_t harmonics_response(const harmonics_t *p, const flux_map_t *map, dq64_t psi,
                                          dq64_t turn, int extra) {
    dq64_t m = magnet_harmonic(p, turn);
    dq64_t x = {psi.d - m.d, psi.q - m.q};
    dq64_t i = flux_map_current(map, x, extra);
    double x_d = x.d - p->psi_0;
    i.d += p->gamma * (x_d * turn.d + x.q * turn.q);
    i.q += p->gamma * (x_d * turn.q - x.q * turn.d);
    double slope = 6.0 * (i.d * p->m_d * turn.q - i.q * p->m_q * turn.d) +
                   3.0 * p->gamma * (2.0 * x_d * x.q * turn.d - (x_d * x_d - x.q * x.q) * turn.q);
    response_t y = {i, psi.d * i.q - psi.q * i.d - slope};
    return y;
}

#endif
