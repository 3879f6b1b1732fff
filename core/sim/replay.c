/* Runs the estimators over a recorded log. */
#include <stdint.h>

#include "replay.h"

void replay_init(const drive_params_t *p, replay_t *x, float theta, float omega, float k_s) {
    dq_t none = {0.0f, 0.0f};
    drive_init(p, &x->x, theta, omega, k_s);
    x->u_1 = none;
    x->u_2 = none;
}

/* Sign of the injection, from the voltages of the last three periods; the last one is u. */
static float injection_sign(const replay_t *x, dq_t u, float u_inj) {
    dq_t last = {u.d - x->u_1.d, u.q - x->u_1.q};
    dq_t before = {x->u_1.d - x->u_2.d, x->u_1.q - x->u_2.q};
    float size =
        min_f(last.d * last.d + last.q * last.q, before.d * before.d + before.q * before.q);
    float least = 1.5f * u_inj;
    int to_and_fro = last.d * before.d + last.q * before.q < 0.0f;
    return to_and_fro && size >= least * least ? sign_f(last.d) : 0.0f;
}

static void replay_step(const drive_params_t *p, replay_t *r, const replay_in_t *in,
                        float k_s_ref) {
    drive_state_t *x = &r->x;
    ab_t i_ab = match_correct(&x->coupled.match, in->i_a, in->i_b);
    ab_t u_ab = {in->u_a, in->u_b};
    dq_t u = ab_to_dq(u_ab, rot_of(x->hfi.pll.theta - 0.5f * p->T_s * x->hfi.pll.omega));
    float s = in->infer != 0.0f ? injection_sign(r, u, p->hfi.u_inj) : in->inj;
    x->hfi.sign_3 = x->hfi.sign_2;
    x->hfi.sign_2 = s;
    x->u_2 = u_ab;
    rot_t r_est = drive_observe(p, x, i_ab, ks_limit(k_s_ref));
    x->coupled.i_1 = i_ab;
    x->lock.wait = x->lock.wait > 1 ? x->lock.wait - 1 : p->lock.n; /* the drive learns by it */
    control_sample(&x->control, r_est, i_ab);
    float u_d = 0.5f * (u.d + r->u_1.d); /* the fundamental */
    float u_q = 0.5f * (u.q + r->u_1.q);
    x->control.u_abs = sqrt_f(u_d * u_d + u_q * u_q);
    x->control.u_max = max_f(in->u_dc * INV_SQRT3_F - s * s * p->hfi.u_inj, 1.0f);
    drive_signals(&p->signal, x, x->est.omega);
    r->u_2 = r->u_1;
    r->u_1 = u;
}

void replay_run(const drive_params_t *p, replay_t *x, const replay_in_t *in, int32_t n,
                float k_s_ref, float *out, float *obs) {
    for (int32_t j = 0; j < n; j++) {
        float *row = &out[(long)j * REPLAY_N];
        row[REPLAY_OMEGA_HFI] = x->x.hfi.pll.omega;
        row[REPLAY_OMEGA_SMO] = x->x.emf.pll.omega;
        replay_step(p, x, &in[j], k_s_ref);
        row[REPLAY_THETA_HFI] = x->x.theta_hfi;
        row[REPLAY_THETA_SMO] = x->x.theta_smo;
        row[REPLAY_THETA_BLEND] = x->x.est.theta;
        row[REPLAY_OMEGA_BLEND] = x->x.est.omega;
        row[REPLAY_K_S] = x->x.k_s;
        row[REPLAY_VALID_HFI] = x->x.hfi.valid;
        row[REPLAY_VALID_SMO] = x->x.emf.valid;
    }
    signals_read(&p->signal, &x->x.signal, obs);
}
