/* The true state of drives, from their machines and sums. */
#include "truth.h"

static void truth_read(const sim_t *s, float u_dc, float *y) {
    const sums_t *m = &s->sums;
    float n = max_f(m->n, 1.0f);
    int moved = m->n != 0.0f; /* if not, all estimators are still at the initial angle */
    y[TRUTH_ERR] = moved ? m->err / n : s->start.theta_err;
    y[TRUTH_ERR_HFI] = moved ? m->err_hfi / n : s->start.theta_err;
    y[TRUTH_ERR_SMO] = moved ? m->err_smo / n : s->start.theta_err;
    y[TRUTH_OMEGA_M_DEV] = (m->omega_m - m->omega_m_twin) / n;
    y[TRUTH_TAU_DEV] = (m->tau - m->tau_twin) / n;
    y[TRUTH_TAU] = m->tau / n;
    y[TRUTH_TAU_LOAD] = s->now.tau_load;
    y[TRUTH_OMEGA_M] = (float)s->drive.y.omega_m;
    float dir = sign_f(s->drive.x.signal.omega);
    for (int j = TRUTH_ERR; j <= TRUTH_OMEGA_M; j++) {
        y[j] *= dir;
    }
    y[TRUTH_U_DC] = s->now.u_dc - u_dc;
    y[TRUTH_ERR_COUNT] = (float)s->err_count;
}

void sim_truth(const sim_t *s, int32_t n, float u_dc, const float *scale, float bound, float *out,
               int32_t columns) {
    for (int32_t i = 0; i < n; i++) {
        float *y = &out[(long)i * columns];
        truth_read(&s[i], u_dc, y);
        for (int j = 0; j < TRUTH_N; j++) {
            y[j] = clamp_f(y[j] * scale[j], -bound, bound);
        }
    }
}
