/* Finds damage to the state: numbers that are not finite, or beyond any that a drive computes.
 *
 * Every period checks the voltage, and the sum of the words in which damage to any word of the state
 * is after that period: a sum is finite only if all of them are. A word that is not among them is
 * written anew in every period from those that are, or acts on the voltage.
 *
 * Numbers that nothing bounds on their way are looked at once with every test of the lock: what is
 * finite, but more than a drive computes, would act for long. */
#ifndef SENSORLESS_DRIVE_CHECK_H
#define SENSORLESS_DRIVE_CHECK_H

#include "drive_types.h"

#define CHECK_LIMIT 1.0e15f /* beyond any sum of numbers of a state */

#ifdef __cplusplus
extern "C" {
#endif

/* Sum of the words in which damage to a drive in control is after a period, units apart. */
float drive_sum(const drive_state_t *x);

/* Sum of the words in which damage to a drive that seeks its rotor may be besides. */
float drive_seek_sum(const drive_state_t *x);

#ifdef __cplusplus
}
#endif

/* Whether the voltage u of this period [V] and the state after it are sound. */
CORE_INLINE int drive_sound(const guard_params_t *p, const drive_state_t *x, ab_t u) {
    return abs_f(u.a) <= p->u_out && abs_f(u.b) <= p->u_out && abs_f(drive_sum(x)) <= CHECK_LIMIT;
}

/* The voltage u [V], or one that drive_sound refuses. */
CORE_INLINE ab_t drive_unless(int sound, const guard_params_t *p, ab_t u) {
    u.a = sound ? u.a : 2.0f * p->u_out;
    return u;
}

/* Whether a counter, or several or-ed, is a small positive number: as a float it is finite then. */
CORE_INLINE int count_sound(int32_t n) { return n >= 0 && n < 1 << 30; }

/* Whether the counters of the start sequence and the fault bits are. */
CORE_INLINE int drive_start_counts(const drive_state_t *x) {
    const start_state_t *s = &x->start;
    return count_sound(s->n | s->tries | s->again | x->fault);
}

/* Whether those of the tests of lost lock are that an evaluation does not bound itself. */
CORE_INLINE int drive_lock_counts(const drive_state_t *x) {
    const lock_state_t *y = &x->lock;
    return count_sound(y->bad | y->calm | y->turned | y->restarts | y->alarms | y->reason);
}

/* Whether phase, counters and weight are such as the start sequence writes, and what its sliding-mode
 * observer goes on from is finite: the observer's bounds hide what is not. */
CORE_INLINE int drive_seek_sound(const drive_state_t *x) {
    const start_state_t *s = &x->start;
    float from = x->u_1.a + x->u_1.b + x->u_2.a + x->u_2.b;
    from += x->smo.i_hat.a + x->smo.i_hat.b + x->smo.z.a + x->smo.z.b;
    return start_is_phase(s->phase) && drive_start_counts(x) && drive_lock_counts(x) &&
           x->k_s >= 0.0f && x->k_s <= 1.0f && abs_f(from) <= CHECK_LIMIT;
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
