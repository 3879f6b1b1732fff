/* One period of each phase of the start sequence, and the next phase. */
#include "drive_start.h"

#include "drive_actuate.h"
#include "drive_check.h"
#include "drive_observe.h"
#include "drive_stop.h"

/* Stages that several places call, kept once in the memory of a target. */
CORE_APART rot_t unit(float theta) { return rot_of(theta); }

CORE_APART void see_emf(const drive_params_t *p, drive_state_t *x, ab_t i_ab, float omega) {
    smo_observe(&p->start.smo, &x->smo, &x->emf, i_ab, x->u_2, p->L_q.y[0], omega, x->est.theta,
                p->T_s);
}

CORE_COLD void drive_find_again(drive_state_t *x, int32_t again) {
    ab_t i_ab = dq_to_ab(x->control.i_1, unit(x->est.theta));
    ab_t nothing = {0.0f, 0.0f};
    start_begin(&x->start);
    start_enter(&x->start, START_QUIET);
    hfi_quiet(&x->hfi);
    x->start.again = again;
    x->start.i_1 = i_ab;
    x->start.i_2 = i_ab;
    x->smo.i_hat = i_ab;
    x->smo.z = nothing;
    x->emf.e = nothing;
    x->control.i.d = 0.0f;
    x->control.i.q = 0.0f;
    x->control.i_ref.q = 0.0f; /* torque will rise from zero with the slope of its reference */
    x->control.u_int.d = 0.0f; /* of the wrong frame: they would kick when control goes on */
    x->control.u_int.q = 0.0f;
    x->control.i_d_fw = 0.0f;
}

CORE_COLD void drive_change_observer(const drive_params_t *p, drive_state_t *x) {
    const coupled_params_t *c = &p->coupled;
    dq_t i = x->control.i;
    flux_model_t m = drive_flux_model(p, curve_locate(i.q, p->control.curve_inv_step));
    dq_t psi = flux_of_current(&m, i).psi;
    x->start.again = START_SAME_POLE;
    x->emf.pll.theta = wrap_pi(x->est.theta + p->T_s * x->est.omega);
    x->emf.pll.omega = x->est.omega;
    x->emf.valid = 1.0f;
    x->coupled.psi = dq_to_ab(psi, unit(x->est.theta)); /* the next period integrates from k on */
    x->coupled.load = bound_f(-c->k_tau * (psi.d * i.q - psi.q * i.d), c->load_max);
    x->coupled.eps_f = 0.0f;
    drift_clear(&c->drift, &x->coupled.drift);
}

/* Hands over to control; both estimators continue from the estimate for k+1. */
CORE_COLD static void release(const drive_params_t *p, drive_state_t *x, estimate_t next,
                              ab_t i_ab) {
    ab_t nothing = {0.0f, 0.0f};
    x->hfi.pll.theta = next.theta;
    x->hfi.pll.omega = next.omega;
    x->emf.pll = x->hfi.pll;
    x->smo.omega_f = next.omega;
    x->emf.valid = 0.0f; /* observers that integrate start again */
    x->flux.psi = nothing;
    drift_clear(&p->coupled.drift, &x->coupled.drift);
    x->control.i_1 = ab_to_dq(i_ab, unit(x->est.theta));
    if (x->start.again == 0) { /* else the integrator knows the load of before */
        control_ready(&p->control, &x->control, next.omega);
        x->lock.turned = 0;
    }
    control_sum_anew(&x->control);
    lock_begin(&p->lock, &x->lock, next.omega);
    start_enter(&x->start, START_DONE);
}

/* Sets the angle that all parts of the drive read. */
CORE_COLD static void show_angle(drive_state_t *x, estimate_t est) {
    x->est = est;
    x->theta_hfi = est.theta;
    x->theta_smo = est.theta;
}

/* The shaft spins: angle and speed from the EMF e = omega psi (-sin theta, cos theta). */
CORE_COLD static void enter_fly(const drive_params_t *p, drive_state_t *x, ab_t i_ab) {
    const start_state_t *s = &x->start;
    float omega = bound_f(s->omega, p->smo.pll.omega_max);
    float way = sign_f(omega);
    ab_t north = {way * s->e_f.b, -way * s->e_f.a};
    x->emf.pll.theta = wrap_pi(angle_of(north) + p->T_s * omega);
    x->emf.pll.omega = omega;
    x->smo.omega_f = x->emf.pll.omega;
    x->k_s = 0.0f;
    x->control.i_1 = ab_to_dq(i_ab, unit(x->emf.pll.theta));
    x->signal.omega = x->emf.pll.omega; /* for the schedule, without its low-pass */
    x->signal.omega_2 = x->emf.pll.omega;
    start_enter(&x->start, START_FLY);
}

/* One period of FLY: the sliding-mode observer alone; the injection estimator follows its angle. */
CORE_COLD static ab_t fly(const drive_params_t *p, drive_state_t *x, const drive_in_t *in,
                          ab_t i_ab) {
    estimate_t own = {x->emf.pll.theta, x->emf.pll.omega};
    show_angle(x, own);
    x->hfi.pll.theta = own.theta;
    x->hfi.pll.omega = own.omega;
    see_emf(p, x, i_ab, x->est.omega);
    ab_t u = drive_hold(p, x, in, i_ab, x->est);
    x->start.n = count_i(x->start.n, 1);
    if (x->start.n >= (x->start.again != 0 ? p->start.n_again : p->start.n_fly)) {
        estimate_t next = {x->emf.pll.theta, x->emf.pll.omega};
        release(p, x, next, i_ab);
    }
    return u;
}

/* Decides at the end of CATCH whether the shaft spins. */
CORE_COLD static void watch_emf(const drive_params_t *p, drive_state_t *x, ab_t i_ab) {
    start_state_t *s = &x->start;
    int spins = norm_ab(s->e_f) >= p->start.e_fly;
    if (s->n >= p->start.n_catch && spins) {
        enter_fly(p, x, i_ab);
    } else if (s->n >= p->start.n_catch) {
        start_enter(s, START_SCAN);
    }
}

/* The axis is known except for its sense. The initial speed is that at which the EMF turns; at rest
 * that is noise, so the EMF's magnitude bounds it. The rotor has turned on since the estimate ended. */
CORE_COLD static void enter_lock(const drive_params_t *p, drive_state_t *x) {
    float omega = bound_f(x->start.omega, norm_ab(x->start.e_f) / p->control.psi_f);
    float turned = p->T_s * (float)(p->start.n_catch + 2 * p->start.n_scan) * omega;
    float before = x->est.theta + (x->start.again == START_OTHER_POLE ? PI_F : 0.0f);
    x->hfi.pll.theta = start_axis(&x->start, wrap_far(before + turned));
    x->hfi.pll.omega = omega;
    x->k_s = 1.0f;
    start_enter(&x->start, START_LOCK);
}

/* Signed speed from the EMF on the estimated q axis, which has much less noise than a fast loop. */
CORE_COLD static float emf_speed(const drive_params_t *p, const drive_state_t *x) {
    rot_t r = unit(x->hfi.pll.theta);
    float omega = (r.c * x->start.e_f.b - r.s * x->start.e_f.a) / p->control.psi_f;
    return bound_f(omega, p->hfi.pll.omega_max);
}

/* Whether the shaft turns fast enough for its EMF to show the pole, without pulses: a speed by EMF
 * against that of the injection estimator means south. */
CORE_COLD static int know_pole(const drive_params_t *p, drive_state_t *x) {
    float by_emf = emf_speed(p, x);
    float turns = x->hfi.pll.omega;
    if (abs_f(by_emf) < p->start.omega_pole || abs_f(turns) < 0.5f * abs_f(by_emf)) {
        return 0;
    }
    int south = by_emf * turns < 0.0f;
    x->hfi.pll.theta = wrap_pi(x->hfi.pll.theta + (south ? PI_F : 0.0f));
    return 1;
}

/* Without injection, the angle continues at the last speed. The sign of the EMF depends on the
 * pole, which is not known yet, so only its magnitude is used. */
CORE_COLD static void enter_pole(const drive_params_t *p, drive_state_t *x) {
    x->hfi.pll.omega = sign_f(x->hfi.pll.omega) * abs_f(emf_speed(p, x));
    start_enter(&x->start, START_POLE);
}

/* After a pair of pulses: decides on the pole, or tries another pair. */
CORE_COLD static void judge_pole(const drive_params_t *p, drive_state_t *x) {
    start_state_t *s = &x->start;
    int sure = abs_f(s->i_pole) >= p->start.i_pole_sure;
    s->tries = count_i(s->tries, 1);
    if (sure || s->tries >= p->start.n_tries) {
        int south = s->i_pole * p->start.i_pole < 0.0f;
        x->hfi.pll.theta = wrap_pi(x->hfi.pll.theta + (south ? PI_F : 0.0f));
        x->fault |= sure ? 0 : FAULT_POLE;
        x->hfi.pll.omega = emf_speed(p, x);
        start_enter(s, START_SETTLE);
    } else {
        start_enter(s, START_POLE);
    }
}

/* Voltage of a pulse along the estimated axis, on top of the EMF. */
CORE_COLD static ab_t pulse(const drive_params_t *p, drive_state_t *x, float way) {
    rot_t r = unit(x->est.theta + 1.5f * p->T_s * x->est.omega);
    float push = way * p->start.u_pulse;
    ab_t u = {x->start.e_f.a + push * r.c, x->start.e_f.b + push * r.s};
    return u;
}

/* Adds injection of sign s to u, limits the sum to the DC link and compensates dead time. */
CORE_COLD static ab_t output(const drive_params_t *p, drive_state_t *x, ab_t u, rot_t axis, float s,
                             ab_t i_ab, float u_dc) {
    ab_t v = {u.a + s * p->hfi.u_inj * axis.c, u.b + s * p->hfi.u_inj * axis.s};
    float scale = min_f(u_dc * INV_SQRT3_F / max_f(norm_ab(v), 1.0f), 1.0f);
    x->u_2 = x->u_1;
    x->u_1.a = scale * v.a;
    x->u_1.b = scale * v.b;
    ab_t mean = {0.5f * (i_ab.a + x->start.i_1.a), 0.5f * (i_ab.b + x->start.i_1.b)};
    ab_t comp = dead_time_voltage(p->control.u_dt, p->control.inv_i_dt, mean);
    ab_t out = {x->u_1.a + comp.a, x->u_1.b + comp.b};
    return out;
}

/* One period at rest or low speed: adds the sample to the phase's sums; returns the voltage. */
CORE_COLD static ab_t seek_axis(const drive_params_t *p, drive_state_t *x, ab_t i_ab, float u_dc) {
    const start_params_t *q = &p->start;
    start_state_t *s = &x->start;
    int pole = s->phase == START_POLE;
    int scan = s->phase == START_SCAN;
    int tracks = s->phase == START_LOCK || s->phase == START_SETTLE;
    see_emf(p, x, i_ab, 0.0f);
    if (pole) { /* pulses hide the EMF from the observer: the last EMF keeps turning */
        s->e_f = start_turned(s->e_f, p->T_s * x->est.omega);
        start_peak(q, s, ab_to_dq(i_ab, unit(x->hfi.pll.theta)).d);
    } else {
        start_emf(q, s, x->emf.e, p->T_s);
    }
    if (scan) {
        start_scan(q, s, i_ab, x->hfi.sign_2);
    } else if (tracks || pole) {
        estimate_t own = {x->hfi.pll.theta, x->hfi.pll.omega};
        show_angle(x, own);
        x->hfi.jump = 0.0f; /* this loop says nothing of it */
        hfi_observe(&q->hfi, &x->hfi, i_ab, own.theta, own.omega, p->T_s);
    }
    float way = pole ? start_pulse(q, s) : 0.0f;
    ab_t u = way != 0.0f ? pulse(p, x, way) : start_hold(q, s, i_ab, p->T_s);
    float sign = hfi_inject(&q->hfi, &x->hfi, tracks || (scan && s->n < 2 * q->n_scan));
    rot_t along_a = {1.0f, 0.0f};
    rot_t along_b = {0.0f, 1.0f};
    rot_t axis = unit(x->hfi.pll.theta + 0.5f * p->T_s * x->hfi.pll.omega);
    axis = scan ? (s->n < q->n_scan ? along_a : along_b) : axis;
    return output(p, x, u, axis, sign, i_ab, u_dc);
}

/* Hands over at the angle of the injection estimator and the speed of the EMF. */
CORE_COLD static void take_over(const drive_params_t *p, drive_state_t *x, ab_t i_ab) {
    estimate_t next = {x->hfi.pll.theta, emf_speed(p, x)};
    release(p, x, next, i_ab);
}

/* The axis is known. If the shaft turns, its EMF may tell the pole. After lost lock, where pulses
 * cannot, LOCK goes on for as long as they would take: a load may make the shaft fast enough; then the
 * guess decides. */
CORE_COLD static void leave_lock(const drive_params_t *p, drive_state_t *x, ab_t i_ab) {
    const start_params_t *q = &p->start;
    int32_t pulses = q->n_tries * start_pair(q);
    int again = x->start.again != 0;
    int known = know_pole(p, x);
    if (!known && (!again || abs_f(q->i_pole) >= q->i_pole_sure)) {
        enter_pole(p, x);
    } else if (known || x->start.n >= 2 * q->n_lock + pulses) {
        x->fault |= known ? 0 : FAULT_POLE;
        take_over(p, x, i_ab);
    }
}

/* Enters the next phase when the present one has had its periods. */
CORE_COLD static void seek_next(const drive_params_t *p, drive_state_t *x, ab_t i_ab) {
    const start_params_t *q = &p->start;
    start_state_t *s = &x->start;
    s->n = count_i(s->n, 1);
    if (s->phase == START_QUIET) {
        if (norm_ab(i_ab) < q->i_quiet || s->n >= q->n_quiet) {
            start_enter(s, START_CATCH);
        }
    } else if (s->phase == START_CATCH) {
        watch_emf(p, x, i_ab);
    } else if (s->phase == START_SCAN && s->n >= 2 * q->n_scan + 2) {
        enter_lock(p, x);
    } else if (s->phase == START_LOCK && s->n >= q->n_lock) {
        leave_lock(p, x, i_ab);
    } else if (s->phase == START_POLE && s->n >= start_pair(q)) {
        judge_pole(p, x);
    } else if (s->phase == START_SETTLE && s->n >= q->n_lock) {
        (void)(s->again != 0 && know_pole(p, x)); /* a load may have moved the shaft meanwhile */
        take_over(p, x, i_ab);
    }
}

CORE_COLD ab_t drive_seek(const drive_params_t *p, drive_state_t *x, const drive_in_t *in,
                          ab_t i_ab) {
    ab_t u = {0.0f, 0.0f};
    if (!drive_seek_sound(x)) {
        return drive_unless(0, &p->guard, u);
    }
    if (x->start.phase == START_STOPPED || drive_is_to_stop(x)) {
        drive_stop(x); /* again: drive_trip came within a period, or the bits were cleared */
        x->u_2 = x->u_1;
        x->u_1 = u;
    } else if (x->start.phase == START_FLY) {
        u = fly(p, x, in, i_ab);
    } else {
        u = seek_axis(p, x, i_ab, in->u_dc);
        seek_next(p, x, i_ab);
        x->start.i_2 = x->start.i_1;
        x->start.i_1 = i_ab;
    }
    drive_signals(&p->signal, x, in->omega_ref);
    x->lock.wait = x->lock.wait > 1 ? x->lock.wait - 1 : p->lock.n;
    return drive_unless(abs_f(drive_seek_sum(x)) <= CHECK_LIMIT, &p->guard, u);
}
