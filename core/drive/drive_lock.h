/* Lost lock: what the drive shows to the tests of lock.h, and what it does when they fail. */
#ifndef SENSORLESS_DRIVE_LOCK_H
#define SENSORLESS_DRIVE_LOCK_H

#include "drive_types.h"
#include "vector.h"

#ifdef __cplusplus
extern "C" {
#endif

/* First part of an evaluation, after a period in control. Where voltage is short, as when the link
 * sags, the current cannot follow: its distance does not count. */
CORE_INLINE void drive_watch(const drive_params_t *p, drive_state_t *x) {
    control_state_t *y = &x->control;
    curve_pos_t pos = curve_locate(y->i.q, p->control.curve_inv_step);
    float one = p->lock.inv_t * p->T_s; /* over the number of periods */
    float psi_0 = curve_at(&p->coupled.psi_d, pos);
    lock_in_t in;
    in.omega = x->est.omega;
    in.theta = x->est.theta;
    in.T = (float)p->lock.n * p->T_s;
    in.u.d = one * y->u_sum.d;
    in.u.q = one * y->u_sum.q;
    in.i.d = one * y->i_sum.d;
    in.i.q = one * y->i_sum.q;
    in.i_now = y->i;
    in.L_d = p->control.L_d;
    in.L_q = p->lock.L_q_true * curve_at(&p->L_q, pos);
    in.psi_d = psi_0 + in.L_d * in.i.d;
    in.psi_a = min_f(psi_0 + (in.L_d - in.L_q) * in.i.d, 2.0f * psi_0);
    lock_emf(&p->lock, &x->lock, &in);
    lock_current(&p->lock, &x->lock, y->u_abs > y->u_max ? 0.0f : in.i.q - y->i_ref.q);
    lock_answer(&p->lock, &x->lock, x->hfi.answer, x->hfi.valid, x->k_s);
    control_sum_anew(y);
}

/* Whether the coupled observer can still take the place of the drive's own. */
CORE_INLINE int drive_can_change(const drive_params_t *p, const drive_state_t *x) {
    return p->estimator != ESTIMATE_COUPLED && x->start.again == 0;
}

/* Second part; and until the next, where the torque current gives way, and how much of its flux the
 * coupled observer corrects. */
CORE_INLINE void drive_judge(const drive_params_t *p, drive_state_t *x) {
    lock_stall(&p->lock, &x->lock, x->control.i_ref.q);
    lock_judge(&p->lock, &x->lock, x->est.omega, p->coupled.omega_max);
    control_ends(&p->control, &x->control, x->signal.omega_ref, x->est.omega, p->lock.i_off);
    coupled_rates(&p->coupled, &x->coupled, x->k_s, x->lock.emf, x->lock.i.q, x->est.omega,
                  !drive_can_change(p, x));
    x->lock.wait = p->lock.n;
    x->fault |= x->lock.alarm != 0 ? FAULT_LOCK : 0;
}

/* Whether the drive has to act. */
CORE_INLINE int drive_acts(const drive_params_t *p, const drive_state_t *x) {
    return lock_acts(&p->lock, &x->lock, drive_can_change(p, x));
}

/* After an alarm: the coupled observer in the place of another; then a new start sequence; then, or
 * at once with LOCK_STOP, no voltage any more. */
void drive_act(const drive_params_t *p, drive_state_t *x);

/* The part that is due, and the action, as a linkable function. u: voltage of this period [V];
 * returns it, or one that drive_sound of drive_check.h refuses if the state is damaged. */
ab_t drive_lock(const drive_params_t *p, drive_state_t *x, ab_t u);

#ifdef __cplusplus
}
#endif

#endif
