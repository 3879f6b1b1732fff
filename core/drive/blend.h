/* The weighted position estimate, and the rate limit on its weight.
 *
 *   theta = theta_smo + k_s wrap(theta_hfi - theta_smo),   k_s in [0, 1]
 *
 * Eq. 26 of doi 10.12177/emca.2025.011 with the wrap it lacks: the mean of 359 and 1 degree is 0.
 *
 * drive_params_t.estimator chooses this or another way to one estimate. ESTIMATE_ERRORS weights the
 * error signals, not the angles: one loop runs on k_s err_hfi + (1 - k_s) err_smo (after Piippo and
 * Luomi, adaptive observer combined with HF signal injection, IEMDC 2005). A PLL is linear in its
 * error, so stepping two from the same state and blending the results is the same loop.
 * ESTIMATE_COUPLED has one state for both sources, see coupled_observer.h.
 */
#ifndef SENSORLESS_BLEND_H
#define SENSORLESS_BLEND_H

#include "frames.h"

enum {
    ESTIMATE_SMO = 0,       /* the weighted angle above, with the sliding-mode observer */
    ESTIMATE_UNWRAPPED = 1, /* Eq. 26 as printed, for comparison */
    ESTIMATE_ERRORS = 2,    /* weighted error signals in one loop */
    ESTIMATE_FLUX = 3,      /* the weighted angle above, with the flux observer */
    ESTIMATE_COUPLED = 4    /* one observer that injection corrects with the weight */
};

typedef struct {
    float theta; /* electrical angle at k [rad] */
    float omega; /* electrical speed [rad/s] */
} estimate_t;

/* A weight in [0, 1]; NaN counts as 1, because injection needs no speed and so is the safe
 * choice. */
CORE_INLINE float ks_limit(float k_s) {
    float y = k_s <= 1.0f ? k_s : 1.0f;
    return y >= 0.0f ? y : 0.0f;
}

/* k_s moved towards target, in [0, 1], by at most step. */
CORE_INLINE float ks_approach(float k_s, float target, float step) {
    return k_s + bound_f(target - k_s, step);
}

/* The same; a target outside [0, 1] is clipped. */
CORE_INLINE float ks_slew(float k_s, float target, float step) {
    return ks_approach(k_s, ks_limit(target), step);
}

CORE_INLINE estimate_t ks_blend(estimate_t hfi, estimate_t smo, float k_s) {
    estimate_t y = {
        wrap_pi(smo.theta + k_s * wrap_pi(hfi.theta - smo.theta)),
        smo.omega + k_s * (hfi.omega - smo.omega),
    };
    return y;
}

/* Without the wrap: wrong by k_s turns while only one of the two angles has passed +-pi. */
CORE_INLINE estimate_t ks_blend_unwrapped(estimate_t hfi, estimate_t smo, float k_s) {
    estimate_t y = {
        wrap_pi((1.0f - k_s) * smo.theta + k_s * hfi.theta),
        (1.0f - k_s) * smo.omega + k_s * hfi.omega,
    };
    return y;
}

#endif
