/* The inline stages of the core as functions a test can call; every argument a pointer or a number. */
#include "sim/batch.h"
#include "sim/block_avx2.h"
#include "sim/block_avx512.h"
#include "sim/sim_period.h"
#include "sim/simd.h"

/* Only which drives would run as a block is of interest here. */
int32_t block_avx2(const block_run_t *run) { return run->periods; }

int32_t block_avx512(const block_run_t *run) { return run->periods; }

void t_batch_fits(const sim_t *sims, int count, int32_t *simd) {
    *simd = batch_fits(sims, count, SIMD_AVX512);
}

void t_rot_of(const float *x, float *y, int n) {
    for (int j = 0; j < n; j++) {
        rot_t r = rot_of(x[j]);
        y[2 * j] = r.c;
        y[2 * j + 1] = r.s;
    }
}

void t_rot_turn(const float *r, const float *x, float *y, int n) {
    for (int j = 0; j < n; j++) {
        rot_t at = {r[2 * j], r[2 * j + 1]};
        rot_t to = rot_turn(at, x[j]);
        y[2 * j] = to.c;
        y[2 * j + 1] = to.s;
    }
}

void t_angle_of(const float *x, float *y, int n) {
    for (int j = 0; j < n; j++) {
        ab_t v = {x[2 * j], x[2 * j + 1]};
        y[j] = angle_of(v);
    }
}

void t_tanh(const float *x, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = tanh_f(x[j]);
    }
}

void t_wrap(const float *x, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = wrap_pi(x[j]);
    }
}

void t_disagreement(const float *d, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = disagreement(d[j]);
    }
}

void t_clamp(const float *x, float lo, float hi, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = clamp_f(x[j], lo, hi);
    }
}

void t_park(const float *ab, const float *theta, float *dq, float *back, int n) {
    for (int j = 0; j < n; j++) {
        ab_t x = {ab[2 * j], ab[2 * j + 1]};
        rot_t r = rot_of(theta[j]);
        dq_t y = ab_to_dq(x, r);
        ab_t z = dq_to_ab(y, r);
        dq[2 * j] = y.d;
        dq[2 * j + 1] = y.q;
        back[2 * j] = z.a;
        back[2 * j + 1] = z.b;
    }
}

void t_small_angle(const double *x, double *y, int n) {
    for (int j = 0; j < n; j++) {
        small_angle(x[j], &y[2 * j], &y[2 * j + 1]);
    }
}

void t_pll(const pll_params_t *p, pll_state_t *x, float err, float T_s) {
    pll_step(p, x, err, T_s);
}

void t_hfi_observe(const hfi_params_t *p, hfi_state_t *x, float i_a, float i_b, float theta_idle,
                   float omega_idle, float T_s) {
    ab_t i = {i_a, i_b};
    hfi_observe(p, x, i, theta_idle, omega_idle, T_s);
}

void t_hfi_inject(const hfi_params_t *p, hfi_state_t *x, int wanted, float *sign) {
    *sign = hfi_inject(p, x, wanted);
}

void t_hfi_direction(const hfi_params_t *p, const hfi_state_t *x, float T_s, float *y) {
    rot_t r = hfi_direction(p, x, T_s);
    y[0] = r.c;
    y[1] = r.s;
}

void t_flux_observe(const flux_params_t *p, const flux_model_t *m, flux_state_t *x,
                    emf_estimate_t *y, const float *i, const float *before, const float *u,
                    float omega, float theta_idle, float lead, float T_s) {
    ab_t i_ab = {i[0], i[1]};
    ab_t i_1 = {before[0], before[1]};
    ab_t u_ab = {u[0], u[1]};
    flux_observe(p, m, x, y, i_ab, i_1, u_ab, omega, theta_idle, lead, T_s);
}

/* n periods, all of which learn; i: currents, u: voltages over the period before, err: of the
 * injection; out: angle, speed, error, load, drift without torque, flux of each. */
void t_coupled_observe(const coupled_params_t *p, const flux_model_t *m, coupled_state_t *x,
                       emf_estimate_t *y, const float *i, const float *u, const float *err,
                       float k_s, float T_s, float *out, int n) {
    coupled_correct(p, x, 1.0f);
    for (int j = 0; j < n; j++) {
        ab_t i_ab = {i[2 * j], i[2 * j + 1]};
        ab_t u_ab = {u[2 * j], u[2 * j + 1]};
        out[7 * j] = y->pll.theta;
        float seen = bound_f(p->inv_slope * err[j], 1.0f);
        coupled_observe(p, m, x, y, rot_of(y->pll.theta), i_ab, u_ab, k_s, seen, 1, T_s);
        x->i_1 = i_ab;
        out[7 * j + 1] = y->pll.omega;
        out[7 * j + 2] = y->err;
        out[7 * j + 3] = x->load;
        out[7 * j + 4] = x->drift.even;
        out[7 * j + 5] = x->psi.a;
        out[7 * j + 6] = x->psi.b;
    }
}

/* n periods with weight k_s, of which every `every`-th learns; out: drifts by dead time, resistance
 * and inductances, even drift, voltage lost, turn of each. */
void t_drift(const drift_params_t *p, drift_state_t *x, const float *err, const float *i_q,
             const float *omega, float k_s, int every, float *out, int n) {
    for (int j = 0; j < n; j++) {
        float load = drift_load(p, i_q[j]);
        drift_learn(p, x, (j + 1) % every == 0, k_s, err[j], i_q[j], load, omega[j]);
        out[6 * j] = x->dead;
        out[6 * j + 1] = x->res;
        out[6 * j + 2] = x->ind;
        out[6 * j + 3] = x->even;
        out[6 * j + 4] = x->loss;
        out[6 * j + 5] = drift_turn(x, load);
    }
}

void t_drift_clear(const drift_params_t *p, drift_state_t *x) { drift_clear(p, x); }

void t_dead_time_excess(float u_dt, float u_i, float loss, float loss_i, const float *i, float *u,
                        int n) {
    for (int j = 0; j < n; j++) {
        ab_t i_ab = {i[2 * j], i[2 * j + 1]};
        ab_t y = dead_time_excess(u_dt, u_i, loss, loss_i, i_ab);
        u[2 * j] = y.a;
        u[2 * j + 1] = y.b;
    }
}

void t_curve_incremental(const curve_t *c, const float *i_q, float inv_step, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = curve_incremental(c, curve_locate(i_q[j], inv_step));
    }
}

void t_smo_observe(const smo_params_t *p, smo_state_t *x, emf_estimate_t *y, const float *i,
                   const float *u, float L_q, float omega, float theta_idle, float T_s) {
    ab_t i_ab = {i[0], i[1]};
    ab_t u_ab = {u[0], u[1]};
    smo_observe(p, x, y, i_ab, u_ab, L_q, omega, theta_idle, T_s);
}

/* n periods; rows has current, voltage and, afterwards, the angle before and i_hat.a after each. */
void t_smo_periods(const smo_params_t *p, smo_state_t *x, emf_estimate_t *y, float *rows, int n,
                   float L_q, float omega, float T_s) {
    for (float *row = rows; row < rows + 6 * n; row += 6) {
        row[4] = y->pll.theta;
        t_smo_observe(p, x, y, row, row + 2, L_q, omega, 0.0f, T_s);
        row[5] = x->i_hat.a;
    }
}

void t_blend(const float *hfi, const float *smo, float k_s, float *y) {
    estimate_t h = {hfi[0], hfi[1]};
    estimate_t s = {smo[0], smo[1]};
    estimate_t b = ks_blend(h, s, k_s);
    y[0] = b.theta;
    y[1] = b.omega;
}

void t_blend_unwrapped(const float *hfi, const float *smo, float k_s, float *y) {
    estimate_t h = {hfi[0], hfi[1]};
    estimate_t s = {smo[0], smo[1]};
    estimate_t b = ks_blend_unwrapped(h, s, k_s);
    y[0] = b.theta;
    y[1] = b.omega;
}

void t_slew(float k_s, float target, float step, float *y) { *y = ks_slew(k_s, target, step); }

void t_control(const control_params_t *p, control_state_t *x, const float *est, const float *i,
               float u_dc, float omega_ref, float reserve, float T_s, float *u) {
    estimate_t at = {est[0], est[1]};
    ab_t i_ab = {i[0], i[1]};
    ab_t y = control_step(p, x, at, rot_of(at.theta), i_ab, u_dc, omega_ref, reserve, T_s);
    u[0] = y.a;
    u[1] = y.b;
}

void t_dead_time(float u_dt, float inv_i, const float *i, float *u, int n) {
    for (int j = 0; j < n; j++) {
        ab_t i_ab = {i[2 * j], i[2 * j + 1]};
        ab_t y = dead_time_voltage(u_dt, inv_i, i_ab);
        u[2 * j] = y.a;
        u[2 * j + 1] = y.b;
    }
}

void t_inverter(const sensor_params_t *p, const float *u, float u_dc, const float *i, float *y,
                int n) {
    for (int j = 0; j < n; j++) {
        ab_t u_ab = {u[2 * j], u[2 * j + 1]};
        ab_t i_ab = {i[2 * j], i[2 * j + 1]};
        ab_t out = inverter_voltage(p, u_ab, u_dc, i_ab);
        y[2 * j] = out.a;
        y[2 * j + 1] = out.b;
    }
}

void t_edges(const sensor_params_t *p, const plant_params_t *m, const plant_state_t *x,
             const float *u, float u_dc, float *y, int n) {
    for (int j = 0; j < n; j++) {
        ab_t u_ab = {u[2 * j], u[2 * j + 1]};
        ab_t i_ab = {
            (float)(x[j].cos_e * x[j].i_d - x[j].sin_e * x[j].i_q),
            (float)(x[j].sin_e * x[j].i_d + x[j].cos_e * x[j].i_q),
        };
        plant_slope_t slope = plant_slope(m, &x[j], m->extra, m->detail);
        ab_t out = edges_voltage(p, slope, u_ab, u_dc, (float)(m->h * (double)m->n_sub), i_ab);
        y[2 * j] = out.a;
        y[2 * j + 1] = out.b;
    }
}

void t_link_ripple(const sensor_params_t *p, const int32_t *half, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = link_ripple(p, half[j]);
    }
}

void t_quantise(const sensor_params_t *p, const float *i, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = sensor_quantise(p, i[j]);
    }
}

void t_noise(const uint32_t *seed, const uint32_t *counter, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = noise_normal(seed[j], counter[j]);
    }
}

void t_curve(const curve_t *c, const float *i_q, float inv_step, float *y, int n) {
    for (int j = 0; j < n; j++) {
        y[j] = curve_at(c, curve_locate(i_q[j], inv_step));
    }
}

/* n evaluations of an estimate without bound; rows of in: omega, u_d, u_q, i_d, i_q, L_d, L_q,
 * psi_d, psi_a, i_q less its reference, angle, time since the last one. */
void t_lock(const lock_params_t *p, lock_state_t *x, const float *in, int n) {
    for (int j = 0; j < n; j++) {
        const float *v = &in[12 * j];
        lock_in_t now = {v[0],         v[10], v[11], {v[1], v[2]}, {v[3], v[4]},
                         {v[3], v[4]}, v[5],  v[6],  v[7],         v[8]};
        lock_emf(p, x, &now);
        lock_current(p, x, v[9]);
        lock_judge(p, x, v[0], 1e30f);
    }
}

/* n evaluations at rest; rows of in: answer to the injection, its valid, k_s, i_q. */
void t_lock_answer(const lock_params_t *p, lock_state_t *x, const float *in, int n) {
    for (int j = 0; j < n; j++) {
        const float *v = &in[4 * j];
        x->i.q = v[3];
        lock_answer(p, x, v[0], v[1], v[2]);
        lock_judge(p, x, 0.0f, 1e30f);
    }
}
