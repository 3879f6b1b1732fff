/* Makes the inputs of a period safe. */
#ifndef SENSORLESS_DRIVE_GUARD_H
#define SENSORLESS_DRIVE_GUARD_H

#include "drive_types.h"

/* A speed within the limit: the limit beyond it, 0 if it is not finite. */
CORE_INLINE float guard_speed(float omega, float most) {
    return finite_f(omega) ? bound_f(omega, most) : 0.0f;
}

/* 1 / u_dc of the duty formula [1/V], u_dc: sample of the link [V]. Down to half of the least one that
 * sets no fault the drive goes on, and rides through a sag; where it is 0, for a lower or an impossible
 * link, all duties are one half. */
CORE_INLINE float guard_inv_link(const guard_params_t *p, float u_dc) {
    return u_dc >= 0.5f * p->u_dc_min && u_dc <= p->u_dc_max ? 1.0f / u_dc : 0.0f;
}

/* Replaces bad values and sets their fault bits. */
CORE_INLINE drive_in_t drive_guard(const guard_params_t *p, drive_state_t *x,
                                   const drive_in_t *in) {
    drive_in_t y = {in->i_a, in->i_b, in->u_dc, in->omega_ref, in->k_s_ref};
    if (SHORTCUT(abs_f(y.i_a) <= p->i_sample && abs_f(y.i_b) <= p->i_sample &&
                 y.u_dc >= p->u_dc_min && y.u_dc <= p->u_dc_max && abs_f(y.omega_ref) <= p->omega &&
                 bits_of(y.k_s_ref) <= BITS_OF_ONE)) {
        return y;
    }
    int a = abs_f(in->i_a) <= p->i_sample;
    int b = abs_f(in->i_b) <= p->i_sample;
    int link = in->u_dc >= p->u_dc_min && in->u_dc <= p->u_dc_max;
    int speed = abs_f(in->omega_ref) <= p->omega;
    int k_s = in->k_s_ref <= 1.0f && in->k_s_ref >= 0.0f;
    y.i_a = a ? in->i_a : 0.0f;
    y.i_b = b ? in->i_b : 0.0f;
    y.u_dc = max_f(sane_f(in->u_dc, p->u_dc_max), 0.0f);
    y.omega_ref = guard_speed(in->omega_ref, p->omega);
    y.k_s_ref = k_s ? in->k_s_ref : ks_limit(x->k_s);
    x->fault |= (a ? 0 : FAULT_CURRENT) | (b ? 0 : FAULT_CURRENT) | (link ? 0 : FAULT_U_DC) |
                (speed ? 0 : FAULT_COMMAND) | (k_s ? 0 : FAULT_COMMAND);
    return y;
}

/* Sets the fault of a current vector beyond the limit; i_ab: sample k [A]. */
CORE_INLINE void drive_guard_current(const guard_params_t *p, drive_state_t *x, ab_t i_ab) {
    int fine = i_ab.a * i_ab.a + i_ab.b * i_ab.b <= p->i_over_sq;
    if (SHORTCUT(fine)) {
        return;
    }
    x->fault |= fine ? 0 : FAULT_OVER_CURRENT;
}

/* Sets the fault of samples k-1 and k that no voltage brings that far apart; i_ab: sample k [A]. */
CORE_INLINE void drive_guard_step(const guard_params_t *p, drive_state_t *x, ab_t i_ab) {
    float a = i_ab.a - x->coupled.i_1.a;
    float b = i_ab.b - x->coupled.i_1.b;
    int fine = a * a + b * b <= p->i_step_sq;
    if (SHORTCUT(fine)) {
        return;
    }
    x->fault |= fine ? 0 : FAULT_CURRENT;
}

#endif
