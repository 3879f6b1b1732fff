/* Finds damage to the state: numbers that are not finite, or beyond any that a drive computes.
 *
 * Every period checks the voltage and the numbers through which damage spreads. The whole state is
 * summed up piece by piece, CHECK_WORDS words a period: a sum is finite only if all its words are,
 * and an integer of the state is next to nothing as a float.
 *
 * Those that nothing bounds on their way, once with every test of the lock: what is finite, but more
 * than a drive computes, would act for long. */
#ifndef SENSORLESS_DRIVE_CHECK_H
#define SENSORLESS_DRIVE_CHECK_H

#include "compiler.h"
#include "drive_types.h"

enum { CHECK_WORDS = 8 }; /* words of the state that a period looks at */

typedef float CORE_ALIAS check_word_t; /* any word of the state, whatever it holds */

/* Where the last piece begins. */
#define CHECK_LAST ((int32_t)(sizeof(drive_state_t) / sizeof(check_word_t)) - CHECK_WORDS)
#define CHECK_LIMIT 1.0e15f /* beyond any sum of numbers of a state */

/* Where the next piece begins. */
CORE_INLINE int32_t check_next(int32_t at) {
    int32_t next = at + CHECK_WORDS;
    next = next < CHECK_LAST ? next : CHECK_LAST;
    return at >= 0 && at < CHECK_LAST ? next : 0;
}

/* Whether the voltage u of this period [V] and all that was looked at are sound. */
CORE_INLINE int drive_sound(const guard_params_t *p, const drive_state_t *x, ab_t u) {
    const check_word_t *w = (const check_word_t *)(const void *)x + x->check;
    float sum = x->hfi.amplitude + x->est.theta + x->flux.psi.a + x->coupled.psi.a;
    sum += x->smo.omega_f + x->k_s + x->control.i_int + x->control.u_abs;
    sum += w[0] + w[1] + w[2] + w[3] + w[4] + w[5] + w[6] + w[7]; /* CHECK_WORDS */
    return abs_f(u.a) <= p->u_out && abs_f(u.b) <= p->u_out && abs_f(sum) <= CHECK_LIMIT;
}

/* The voltage u [V], or one that drive_sound refuses. */
CORE_INLINE ab_t drive_unless(int sound, const guard_params_t *p, ab_t u) {
    u.a = sound ? u.a : 2.0f * p->u_out;
    return u;
}

/* Whether phase and counters are such as the start sequence writes, and what its sliding-mode observer
 * goes on from is finite: the observer's bounds hide what is not. */
CORE_INLINE int drive_seek_sound(const drive_state_t *x) {
    const start_state_t *s = &x->start;
    float from = x->u_1.a + x->u_1.b + x->u_2.a + x->u_2.b;
    from += x->smo.i_hat.a + x->smo.i_hat.b + x->smo.z.a + x->smo.z.b;
    return s->phase > START_DONE && s->phase < START_END && s->n >= 0 && s->tries >= 0 &&
           abs_f(from) <= CHECK_LIMIT;
}

/* Whether both estimators' angles, the weight and the torque current's sign are such as a drive
 * computes. */
CORE_INLINE int drive_angles_sound(const drive_state_t *x) {
    float angles = abs_f(x->hfi.pll.theta) + abs_f(x->emf.pll.theta);
    return angles <= 4.0f * PI_F && bits_of(x->k_s) <= BITS_OF_ONE &&
           abs_f(x->coupled.drift.sign) <= 1.0f;
}

/* Whether the trust in the flux and the integrator of the speed control are. */
CORE_INLINE int drive_loops_sound(const drive_params_t *p, const drive_state_t *x) {
    return abs_f(x->control.i_int) <= p->control.i_int_max &&
           bits_of(x->coupled.drift.trust) <= BITS_OF_ONE;
}

#endif
