/* The words of a state that show damage, struct by struct. */
#include "drive_check.h"

static float lock_sum(const lock_state_t *x) {
    float sum = x->i.d + x->i.q + x->across + x->residual + x->emf + x->theta + x->late;
    return sum + x->omega + x->i_off + x->answer;
}

static float start_sum(const start_state_t *x) {
    float sum =
        x->i_1.a + x->i_1.b + x->i_2.a + x->i_2.b + x->e_1.a + x->e_1.b + x->e_f.a + x->e_f.b;
    return sum + x->axis.a + x->axis.b + x->omega + x->i_0 + x->i_pole;
}

static float signal_sum(const signal_state_t *x) {
    float sum = x->omega + x->omega_2 + x->i_q + x->disagree + x->emf + x->hf;
    return sum + x->hfi_var + x->smo_var + x->voltage;
}

static float control_sum(const control_state_t *x) {
    float sum = x->u_sum.d + x->u_sum.q + x->i_sum.d + x->i_sum.q;
    return sum + x->i_int + x->i_d_end + x->i_q_least + x->u_abs; /* which has u_int in it */
}

static float drift_sum(const drift_state_t *x) {
    float sum = x->dead + x->res + x->ind + x->even + x->sign;
    return sum + x->loss + x->turn + x->sum + x->trust;
}

static float coupled_sum(const coupled_state_t *x) {
    float sum = x->psi.a + x->psi.b + x->load + x->eps_f + x->gain_0 + x->gain_w;
    return sum + drift_sum(&x->drift) + x->match.gain + x->match.mean;
}

static float smo_sum(const smo_state_t *x) {
    return x->i_hat.a + x->i_hat.b + x->z.a + x->z.b + x->v.a + x->v.b + x->omega_f;
}

float drive_sum(const drive_state_t *x) {
    const hfi_state_t *h = &x->hfi;
    float sum = h->i_2.d + h->i_2.q + h->jump + h->sign_2 + h->hold + h->err_f;
    sum += smo_sum(&x->smo) + x->flux.psi.a + x->flux.psi.b + coupled_sum(&x->coupled);
    sum += control_sum(&x->control) + signal_sum(&x->signal) + start_sum(&x->start);
    return sum + lock_sum(&x->lock) + x->u_2.a + x->u_2.b + x->k_s;
}

float drive_seek_sum(const drive_state_t *x) {
    const hfi_state_t *h = &x->hfi;
    const control_state_t *c = &x->control;
    float sum = h->pll.theta + h->pll.omega + h->i_1.d + h->i_1.q + h->sign_1 + h->sign_3;
    sum += h->amplitude + h->answer + h->valid + x->emf.pll.theta + x->emf.pll.omega;
    sum += x->emf.valid + x->coupled.match.offset_a + x->coupled.match.offset_b;
    sum += x->est.theta + x->est.omega + x->theta_hfi + x->theta_smo;
    sum += c->i_1.d + c->i_1.q + c->i.d + c->i.q + c->i_ref.d + c->i_ref.q;
    return sum + c->u_int.d + c->u_int.q + c->i_d_fw + c->u_max;
}
