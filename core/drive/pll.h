/* Second-order phase-locked loop: error signal to angle and speed.
 *
 *   omega(k+1) = omega(k) + T_s k_i err(k),   theta(k+1) = theta(k) + T_s (omega(k+1) + k_p err(k))
 *
 * With an error signal of slope K at lock, k_p = 2 zeta w_n / K and k_i = w_n^2 / K.
 */
#ifndef SENSORLESS_PLL_H
#define SENSORLESS_PLL_H

#include "frames.h"

typedef struct {
    float k_p;       /* [1/s] */
    float k_i;       /* [1/s^2] */
    float omega_max; /* bound on the speed estimate, electrical [rad/s] */
} pll_params_t;

typedef struct {
    float theta; /* prediction for the next sampling instant [rad] */
    float omega; /* electrical [rad/s] */
} pll_state_t;

/* err: angle error signal, truth minus estimate near lock [rad for slope 1]; faster: w_n over that
 * of the gains. T_s [s]. */
CORE_INLINE void pll_step_faster(const pll_params_t *p, pll_state_t *x, float err, float faster,
                                 float T_s) {
    x->omega = bound_f(x->omega + T_s * p->k_i * (faster * faster) * err, p->omega_max);
    x->theta = wrap_pi(x->theta + T_s * (x->omega + p->k_p * faster * err));
}

/* At the natural frequency of the gains. */
CORE_INLINE void pll_step(const pll_params_t *p, pll_state_t *x, float err, float T_s) {
    pll_step_faster(p, x, err, 1.0f, T_s);
}

#endif
