/* What a drive does with a sample: both estimators, their blend, and the signals of a schedule. */
#ifndef SENSORLESS_DRIVE_OBSERVE_H
#define SENSORLESS_DRIVE_OBSERVE_H

#include "drive_types.h"

/* The machine for an observer of the flux, at the torque current of pos. */
CORE_INLINE flux_model_t drive_flux_model(const drive_params_t *p, curve_pos_t pos) {
    flux_model_t m;
    m.R_s = p->coupled.R_s;
    m.L_d = p->coupled.L_d;
    m.L_q = curve_at(&p->L_q, pos);
    m.L_qq = curve_incremental(&p->L_q, pos);
    m.psi_0 = curve_at(&p->coupled.psi_d, pos);
    m.psi_sq_min = p->coupled.psi_sq_min;
    return m;
}

/* The coupled observer, after the injection was demodulated. r: direction of its angle; cross: from
 * the injection's axis to the angle [rad]. theta_hfi and theta_smo become the observer's angle plus
 * the error that injection or flux sees. Gain and offset of the sensors are learned in turn, in
 * periods without a decision and without tests of the lock where there are two. */
CORE_INLINE void drive_couple(const drive_params_t *p, drive_state_t *x, ab_t i_ab, rot_t r,
                              float cross, curve_pos_t pos) {
    int learn = x->lock.wait > p->coupled.match.after ? x->lock.wait : 0;
    x->est.theta = x->emf.pll.theta;
    x->est.omega = x->emf.pll.omega;
    float err = bound_f(p->coupled.inv_slope * x->hfi.err, 1.0f);
    flux_model_t m = drive_flux_model(p, pos);
    x->hfi.jump = coupled_observe(&p->coupled, &m, &x->coupled, &x->emf, r, i_ab, x->u_2, x->k_s,
                                  err, learn, p->T_s);
    x->theta_hfi = wrap_pi(x->est.theta + err);
    x->theta_smo = wrap_pi(x->est.theta + x->emf.err);
    x->hfi.pll.theta = wrap_pi(x->emf.pll.theta - cross);
    x->hfi.pll.omega = x->emf.pll.omega;
}

/* Both estimators and their blend; x->est becomes the estimate for instant k. Returns its
 * direction. After lost lock the coupled observer takes the place of the one that lost it. k_s_ref:
 * weight wanted, 0 to 1, as drive_guard leaves it. */
CORE_INLINE rot_t drive_observe(const drive_params_t *p, drive_state_t *x, ab_t i_ab,
                                float k_s_ref) {
    curve_pos_t pos = curve_locate(x->control.i.q, p->control.curve_inv_step);
    float cross = times_sign_f(curve_at(&p->theta_cross, pos), x->control.i.q);

    x->k_s = ks_approach(x->k_s, k_s_ref, p->k_s_step);
    int coupled = p->estimator == ESTIMATE_COUPLED || SCALAR_ONLY(x->start.again != 0);
    if (p->estimator == ESTIMATE_ERRORS) {
        x->hfi.pll.theta = wrap_pi(x->emf.pll.theta - cross);
        x->hfi.pll.omega = x->emf.pll.omega;
    }
    rot_t r = rot_of(coupled ? x->emf.pll.theta : x->hfi.pll.theta);
    if (coupled) {
        hfi_demodulate(&p->hfi, &x->hfi, i_ab, rot_turn(r, -cross));
        drive_couple(p, x, i_ab, r, cross, pos);
        return r;
    }
    hfi_demodulate(&p->hfi, &x->hfi, i_ab, r);
    estimate_t hfi = {wrap_pi(x->hfi.pll.theta + cross), x->hfi.pll.omega};
    estimate_t smo = {x->emf.pll.theta, x->emf.pll.omega};
    x->theta_hfi = hfi.theta;
    x->theta_smo = smo.theta;
    x->est = p->estimator == ESTIMATE_UNWRAPPED ? ks_blend_unwrapped(hfi, smo, x->k_s)
                                                : ks_blend(hfi, smo, x->k_s);

    hfi_follow(&p->hfi, &x->hfi, wrap_pi(x->est.theta - cross), x->est.omega, p->T_s);
    if (p->estimator == ESTIMATE_FLUX) {
        float lead = x->hfi.valid * x->k_s * wrap_pi(hfi.theta - smo.theta);
        flux_model_t m = drive_flux_model(p, pos);
        flux_observe(&p->flux, &m, &x->flux, &x->emf, i_ab, x->coupled.i_1, x->u_2, x->est.omega,
                     x->est.theta, lead, p->T_s);
    } else {
        float share = pos.j > 0 ? 1.0f : pos.f;
        float L_q = smo_L_q(&p->smo, curve_at(&p->L_q, pos), x->control.i.q * x->est.omega, share);
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
    return rot_of(x->est.theta);
}

/* Low-pass filters the signals of a schedule. */
CORE_INLINE void drive_signals(const signal_params_t *p, drive_state_t *x, float omega_ref) {
    signal_state_t *y = &x->signal;
    float a = p->alpha;
    signals_filter(p, y, x->est.omega, x->control.i.q, wrap_pi(x->theta_hfi - x->theta_smo));
    y->omega_ref = omega_ref;
    y->emf += a * (norm_ab(x->emf.e) - y->emf);
    y->hf += a * (x->hfi.valid * x->hfi.amplitude - y->hf);
    y->hfi_var += a * (x->hfi.err * x->hfi.err - y->hfi_var);
    y->smo_var += a * (x->emf.err * x->emf.err - y->smo_var);
    y->voltage += a * (x->control.u_abs / x->control.u_max - y->voltage);
    y->k_s = x->k_s;
}

#endif
