/* From an estimate to the voltage to apply: control, injection, dead-time compensation. */
#ifndef SENSORLESS_DRIVE_ACTUATE_H
#define SENSORLESS_DRIVE_ACTUATE_H

#include "drive_types.h"

/* Adds injection of sign s and dead-time compensation to the voltage u [V]; r_i: direction that the
 * frame of the controlled current will have over [k+1, k+2]. Returns the voltage to apply then and
 * advances the voltage queue. */
CORE_INLINE ab_t drive_output(const drive_params_t *p, drive_state_t *x, ab_t u, rot_t r_i,
                              float s) {
    rot_t r = hfi_direction(&p->hfi, &x->hfi, p->T_s);
    ab_t model = {u.a + s * p->hfi.u_inj * r.c, u.b + s * p->hfi.u_inj * r.s};
    x->u_2 = x->u_1;
    x->u_1 = model;
    ab_t comp =
        dead_time_voltage(p->control.u_dt, p->control.inv_i_dt, dq_to_ab(x->control.i, r_i));
    ab_t out = {model.a + comp.a, model.b + comp.b};
    return out;
}

/* Control on any estimate (the sensored twin passes the true angle); r: direction of its angle, s:
 * sign of the injection. */
CORE_INLINE ab_t drive_actuate(const drive_params_t *p, drive_state_t *x, const drive_in_t *in,
                               ab_t i_ab, estimate_t est, rot_t r, float s) {
    float reserve = s * s * p->hfi.u_inj;
    ab_t u = control_step(&p->control, &x->control, est, r, i_ab, in->u_dc, in->omega_ref, reserve,
                          p->T_s);
    return drive_output(p, x, u, control_when_acts(r, est.omega, p->T_s), s);
}

/* The same without torque: holds the current at zero (or where field weakening puts it) and keeps
 * the speed controller ready. After lost lock its integrator stays: it knows the load of before. */
CORE_INLINE ab_t drive_hold(const drive_params_t *p, drive_state_t *x, const drive_in_t *in,
                            ab_t i_ab, estimate_t est) {
    rot_t r = rot_of(est.theta);
    if (x->start.again == 0) {
        control_ready(&p->control, &x->control, est.omega);
    }
    ab_t u = current_control(&p->control, &x->control, est, r, i_ab, in->u_dc, 0.0f, 0.0f, p->T_s);
    return drive_output(p, x, u, control_when_acts(r, est.omega, p->T_s), 0.0f);
}

#endif
