/* What is read from drives: signals, inputs, and every period of a run. */
#include "trace.h"

#include "sim_advance.h"

void sim_signals(const sim_t *s, int32_t n, float *obs) {
    for (int32_t i = 0; i < n; i++) {
        signals_read(&s[i].control.signal, &s[i].drive.x.signal, &obs[(long)i * SIGNAL_N]);
    }
}

void sim_inputs(const sim_t *s, int32_t n, drive_in_t *in) {
    for (int32_t i = 0; i < n; i++) {
        sim_t now = s[i];
        profile_step(&now.profile, &now.now, now.k);
        in[i] = sim_sample(&now, &now.drive, 0.0f, now.plant.detail);
    }
}

static void trace_row(const sim_t *s, double t, double *row) {
    double per = 1.0 / s->plant.n_p;
    const chain_t *c = &s->drive;
    row[TRACE_T] = t;
    row[TRACE_OMEGA_M_REF] = (double)s->now.omega_ref * per;
    row[TRACE_TAU_LOAD] = (double)s->now.tau_load;
    row[TRACE_OMEGA_M_HAT] = (double)c->x.est.omega * per;
    row[TRACE_K_S] = (double)c->x.k_s;
    row[TRACE_HF_AMPLITUDE] = (double)(c->x.hfi.valid * c->x.hfi.amplitude);
}

int32_t sim_trace(sim_t *s, int32_t periods, float k_s_ref, double *out) {
    int32_t j = 0;
    sums_t none = {0};
    s->sums = none;
    for (; j < periods && !sim_over(s); j++) {
        double *row = &out[(long)j * TRACE_N];
        plant_state_t y = s->drive.y; /* state at the instant k, which this period samples */
        double t = (double)s->k * (double)s->control.T_s;
        row[TRACE_OMEGA_M] = y.omega_m;
        row[TRACE_OMEGA_M_TWIN] = s->twin.y.omega_m;
        row[TRACE_TAU] = y.tau;
        row[TRACE_TAU_TWIN] = s->with_twin ? s->twin.y.tau : y.tau;
        row[TRACE_THETA_E] = y.theta_e;
        row[TRACE_I_D] = y.i_d;
        row[TRACE_I_Q] = y.i_q;
        row[TRACE_U_ALPHA] = (double)s->drive.u.a;
        row[TRACE_U_BETA] = (double)s->drive.u.b;
        row[TRACE_U_ALPHA_HAT] = (double)s->drive.x.u_1.a;
        row[TRACE_U_BETA_HAT] = (double)s->drive.x.u_1.b;
        row[TRACE_INJ] = (double)s->drive.x.hfi.sign_1;
        float starting = s->sums.starting;
        drive_in_t in = sim_advance(s, k_s_ref, s->plant.extra);
        const drive_state_t *x = &s->drive.x;
        row[TRACE_U_DC] = (double)in.u_dc;
        row[TRACE_I_A] = (double)in.i_a;
        row[TRACE_I_B] = (double)in.i_b;
        row[TRACE_THETA_E_ERR] = (double)wrap_pi((float)y.theta_e - x->est.theta);
        row[TRACE_THETA_E_ERR_HFI] = (double)wrap_pi((float)y.theta_e - x->theta_hfi);
        row[TRACE_THETA_E_ERR_SMO] = (double)wrap_pi((float)y.theta_e - x->theta_smo);
        row[TRACE_STARTING] = (double)(s->sums.starting - starting);
        trace_row(s, t, row);
    }
    return j;
}
