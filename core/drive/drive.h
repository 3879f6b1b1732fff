/* One PWM period of the sensorless drive: estimate, blend, control.
 *
 * Call drive_step once a period with the sample of instant k; the voltage it returns is to be
 * applied over [k+1, k+2]. All memory is in drive_state_t, all numbers are in drive_params_t;
 * there are no globals and no allocation.
 */
#ifndef SENSORLESS_DRIVE_H
#define SENSORLESS_DRIVE_H

#include "blend.h"
#include "control.h"
#include "curve.h"
#include "flux_observer.h"
#include "hf_injection.h"
#include "signals.h"
#include "sliding_mode.h"
#include "start_sequence.h"

#define FAULT_CURRENT 1 /* a current sample was not finite or beyond any plausible value */
#define FAULT_U_DC 2    /* the DC-link voltage was not finite, negative or implausible */
#define FAULT_COMMAND 4 /* speed reference or k_s command not finite or out of range */
#define FAULT_POLE 8    /* the start sequence was not sure of the polarity */

/* Whether a drive in this phase still seeks its rotor. Loops over many drives leave such drives out
 * and do not carry the code. */
#ifdef CORE_VECTOR
#define CORE_STARTING(phase) 0
#else
#define CORE_STARTING(phase) ((phase) != START_DONE)
#endif

#define LIMIT_CURRENT 1.0e4f /* [A] plausible magnitude of a sample */
#define LIMIT_VOLTAGE 1.0e5f /* [V] */
#define LIMIT_SPEED 1.0e5f   /* [rad/s] electrical */

typedef struct {
    float T_s;      /* PWM period [s] */
    float k_s_step; /* largest change of k_s a period */
    int estimator;  /* ESTIMATE_* of blend.h */
    hfi_params_t hfi;
    smo_params_t smo;
    flux_params_t flux;
    control_params_t control;
    signal_params_t signal;
    curve_t L_q;         /* apparent q inductance of the observer over |i_q| [H] */
    curve_t theta_cross; /* half the cross-coupling angle at positive i_q over |i_q| [rad] */
    start_params_t start;
} drive_params_t;

typedef struct {
    hfi_state_t hfi;
    emf_estimate_t emf; /* of the sliding-mode observer, or of the flux observer in its place */
    smo_state_t smo;
    flux_state_t flux;
    control_state_t control;
    signal_state_t signal;
    start_state_t start;
    estimate_t est;  /* blended estimate at k */
    ab_t u_1;        /* voltage that acts over [k, k+1], stator frame [V] */
    ab_t u_2;        /* voltage that acted over [k-1, k] [V] */
    float theta_hfi; /* compensated angle of the injection estimator at k [rad] */
    float theta_smo; /* angle of the sliding-mode estimator at k [rad] */
    float k_s;       /* weight in force */
    int fault;       /* FAULT_* bits, kept until the caller clears them */
} drive_state_t;

typedef struct {
    float i_a; /* phase currents at k [A] */
    float i_b;
    float u_dc;      /* DC-link voltage [V] */
    float omega_ref; /* speed reference, electrical [rad/s] */
    float k_s_ref;   /* weight wanted, 0 ... 1 */
} drive_in_t;

/* Inputs made safe: a bad value is replaced and its fault bit set. */
CORE_INLINE drive_in_t drive_guard(drive_state_t *x, const drive_in_t *in) {
    drive_in_t y;
    y.i_a = sane_f(in->i_a, LIMIT_CURRENT);
    y.i_b = sane_f(in->i_b, LIMIT_CURRENT);
    y.u_dc = max_f(sane_f(in->u_dc, LIMIT_VOLTAGE), 0.0f);
    y.omega_ref = sane_f(in->omega_ref, LIMIT_SPEED);
    y.k_s_ref = in->k_s_ref <= 1.0f && in->k_s_ref >= 0.0f ? in->k_s_ref : x->k_s;
    x->fault |= (y.i_a == in->i_a ? 0 : FAULT_CURRENT) | (y.i_b == in->i_b ? 0 : FAULT_CURRENT) |
                (y.u_dc == in->u_dc ? 0 : FAULT_U_DC) |
                (y.omega_ref == in->omega_ref ? 0 : FAULT_COMMAND) |
                (y.k_s_ref == in->k_s_ref ? 0 : FAULT_COMMAND);
    return y;
}

/* Both observers and their blend; x->est is the result for instant k. */
CORE_INLINE void drive_observe(const drive_params_t *p, drive_state_t *x, ab_t i_ab,
                               float k_s_ref) {
    curve_pos_t pos = curve_locate(x->control.i.q, p->control.curve_inv_step);
    float cross = sign_f(x->control.i.q) * curve_at(&p->theta_cross, pos);
    float L_q = curve_at(&p->L_q, pos);

    x->k_s = ks_slew(x->k_s, k_s_ref, p->k_s_step);
    if (p->estimator == ESTIMATE_ERRORS) {
        x->hfi.pll.theta = wrap_pi(x->emf.pll.theta - cross);
        x->hfi.pll.omega = x->emf.pll.omega;
    }
    estimate_t hfi = {wrap_pi(x->hfi.pll.theta + cross), x->hfi.pll.omega};
    estimate_t smo = {x->emf.pll.theta, x->emf.pll.omega};
    x->theta_hfi = hfi.theta;
    x->theta_smo = smo.theta;
    x->est = p->estimator == ESTIMATE_UNWRAPPED ? ks_blend_unwrapped(hfi, smo, x->k_s)
                                                : ks_blend(hfi, smo, x->k_s);

    hfi_observe(&p->hfi, &x->hfi, i_ab, wrap_pi(x->est.theta - cross), x->est.omega, p->T_s);
    if (p->estimator == ESTIMATE_FLUX) {
        flux_observe(&p->flux, &x->flux, &x->emf, i_ab, x->u_2, L_q, x->est.omega, x->est.theta,
                     p->T_s);
    } else {
        smo_observe(&p->smo, &x->smo, &x->emf, i_ab, x->u_2, L_q, x->est.omega, x->est.theta,
                    p->T_s);
    }
    if (p->estimator == ESTIMATE_ERRORS) {
        estimate_t by_hfi = {wrap_pi(x->hfi.pll.theta + cross), x->hfi.pll.omega};
        estimate_t by_smo = {x->emf.pll.theta, x->emf.pll.omega};
        estimate_t next = ks_blend(by_hfi, by_smo, x->k_s);
        x->emf.pll.theta = next.theta;
        x->emf.pll.omega = next.omega;
    }
}

/* Low-passes what a schedule may see. */
CORE_INLINE void drive_signals(const signal_params_t *p, drive_state_t *x, float omega_ref) {
    signal_state_t *y = &x->signal;
    float a = p->alpha;
    y->omega += a * (x->est.omega - y->omega);
    y->omega_2 += a * (y->omega - y->omega_2);
    y->omega_ref = omega_ref;
    y->i_q += a * (x->control.i.q - y->i_q);
    y->disagree += a * (wrap_pi(x->theta_hfi - x->theta_smo) - y->disagree);
    y->emf += a * (norm_ab(x->emf.e) - y->emf);
    y->hf += a * (x->hfi.valid * x->hfi.amplitude - y->hf);
    y->hfi_var += a * (x->hfi.err * x->hfi.err - y->hfi_var);
    y->smo_var += a * (x->emf.err * x->emf.err - y->smo_var);
    y->voltage += a * (x->control.u_abs / x->control.u_max - y->voltage);
    y->k_s = x->k_s;
}

/* Injection of sign s and dead-time compensation on top of the voltage u [V]. Returns what to apply
 * over [k+1, k+2] and moves the voltage queue on. */
CORE_INLINE ab_t drive_output(const drive_params_t *p, drive_state_t *x, ab_t u, estimate_t est,
                              float s) {
    rot_t r = hfi_direction(&p->hfi, &x->hfi, p->T_s);
    ab_t model = {u.a + s * p->hfi.u_inj * r.c, u.b + s * p->hfi.u_inj * r.s};
    x->u_2 = x->u_1;
    x->u_1 = model;
    rot_t r_i = rot_of(est.theta);
    ab_t comp =
        dead_time_voltage(p->control.u_dt, p->control.inv_i_dt, dq_to_ab(x->control.i, r_i));
    ab_t out = {model.a + comp.a, model.b + comp.b};
    return out;
}

/* Control on any estimate (the sensored reference drive passes the true angle), injection sign s. */
CORE_INLINE ab_t drive_actuate(const drive_params_t *p, drive_state_t *x, const drive_in_t *in,
                               ab_t i_ab, estimate_t est, float s) {
    float reserve = s * s * p->hfi.u_inj;
    ab_t u =
        control_step(&p->control, &x->control, est, i_ab, in->u_dc, in->omega_ref, reserve, p->T_s);
    return drive_output(p, x, u, est, s);
}

/* No torque on any estimate: the current held at zero (or where field weakening wants it), the speed
 * controller kept ready. */
CORE_INLINE ab_t drive_hold(const drive_params_t *p, drive_state_t *x, const drive_in_t *in,
                            ab_t i_ab, estimate_t est) {
    control_ready(&p->control, &x->control, est.omega);
    ab_t u = current_control(&p->control, &x->control, est, i_ab, in->u_dc, 0.0f, 0.0f, p->T_s);
    return drive_output(p, x, u, est, 0.0f);
}

/* Makes the drive find its rotor before it controls: call it after drive_init if angle or speed are
 * not known. The angle given to drive_init only says which pole to try first. */
void drive_find_rotor(drive_state_t *x);

/* One period of the start sequence, of a drive in such a phase. */
ab_t drive_seek(const drive_params_t *p, drive_state_t *x, const drive_in_t *in, ab_t i_ab);

/* The whole period. */
CORE_INLINE ab_t drive_step_inline(const drive_params_t *p, drive_state_t *x,
                                   const drive_in_t *raw) {
    drive_in_t in = drive_guard(x, raw);
    ab_t i_ab = phases_to_ab(in.i_a, in.i_b);
    if (CORE_STARTING(x->start.phase)) {
        return drive_seek(p, x, &in, i_ab);
    }
    drive_observe(p, x, i_ab, in.k_s_ref);
    float s = hfi_inject(&p->hfi, &x->hfi, x->k_s > 0.0f || in.k_s_ref > 0.0f);
    ab_t u = drive_actuate(p, x, &in, i_ab, x->est, s);
    drive_signals(&p->signal, x, in.omega_ref);
    return u;
}

/* The same as one function of its own, for firmware. */
ab_t drive_step(const drive_params_t *p, drive_state_t *x, const drive_in_t *in);

/* State at rest: no currents, estimators at theta [rad] and omega [rad/s], weight k_s. */
void drive_init(const drive_params_t *p, drive_state_t *x, float theta, float omega, float k_s);

#endif
