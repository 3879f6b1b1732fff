/* Finds damage to the state: numbers that are not finite, or beyond any that a drive computes.
 *
 * Every period checks the voltage and the numbers through which damage spreads. The whole state is
 * summed up piece by piece, CHECK_WORDS words a period: a sum is finite only if all its words are,
 * and an integer of the state is next to nothing as a float. */
#ifndef SENSORLESS_DRIVE_CHECK_H
#define SENSORLESS_DRIVE_CHECK_H

#include "drive_types.h"

enum { CHECK_WORDS = 8 }; /* words of the state that a period looks at */

/* Where the last piece begins. */
#define CHECK_LAST ((int32_t)(sizeof(drive_state_t) / sizeof(float)) - CHECK_WORDS)
#define CHECK_LIMIT 1.0e15f /* beyond any sum of numbers of a state */

/* Where the next piece begins. */
CORE_INLINE int32_t check_next(int32_t at) {
    int32_t next = at + CHECK_WORDS;
    next = next < CHECK_LAST ? next : CHECK_LAST;
    return at >= 0 && at < CHECK_LAST ? next : 0;
}

/* Whether the voltage u of this period [V] and all that was looked at are sound. */
CORE_INLINE int drive_sound(const guard_params_t *p, const drive_state_t *x, ab_t u) {
    const float *w = (const float *)(const void *)x + x->check;
    float sum = x->hfi.amplitude + x->est.theta + x->flux.psi.a + x->coupled.psi.a;
    sum += x->smo.omega_f + x->k_s + x->control.i_int + x->control.u_abs;
    sum += w[0] + w[1] + w[2] + w[3] + w[4] + w[5] + w[6] + w[7]; /* CHECK_WORDS */
    return abs_f(u.a) <= p->u_out && abs_f(u.b) <= p->u_out && abs_f(sum) <= CHECK_LIMIT;
}

#endif
