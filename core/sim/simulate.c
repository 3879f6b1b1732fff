/* Drives one by one or as blocks, over several threads. */
#include "simulate.h"

#include "batch.h"
#include "sim_period.h"
#include "workers.h"

/* d flux at zero current [Vs]: secant iteration from two guesses around the magnet's flux. */
static double flux_at_rest(const plant_params_t *p) {
    dq64_t psi = {p->map.i_f / p->map.a_d0, 0.0};
    double i_1 = flux_map_current(&p->map, psi, p->extra).d;
    double psi_1 = psi.d;
    psi.d = 0.9 * psi_1 + 1.0e-3;
    for (int j = 0; j < 60; j++) {
        double i_d = flux_map_current(&p->map, psi, p->extra).d;
        double slope = (i_d - i_1) / (psi.d - psi_1);
        if (i_d == i_1 || !(slope > 0.0)) {
            break;
        }
        psi_1 = psi.d;
        i_1 = i_d;
        psi.d -= i_d / slope;
    }
    return psi.d;
}

static void start_one(sim_t *s) {
    plant_state_t y = {0};
    sums_t none = {0};
    ab_t zero = {0.0f, 0.0f};
    const start_t *at = &s->start;
    y.psi_d = flux_at_rest(&s->plant);
    s->plant.harmonics.psi_0 = y.psi_d;
    y.omega_m = (double)at->omega_m;
    y.theta_e = (double)at->theta_e;
    plant_start(&s->plant, &y);
    if (s->plant.detail != 0) { /* no current with harmonics either */
        dq64_t m = magnet_harmonic(&s->plant.harmonics, sixth_power(y.cos_e, y.sin_e));
        y.psi_d += m.d;
        y.psi_q += m.q;
        plant_output(&s->plant, &y, s->plant.extra, 1);
    }
    float omega_e = s->omega_scale * at->omega_m;
    int seek = at->seek != 0 && s->sensored == 0;
    drive_init(&s->control, &s->drive.x, at->theta_e - at->theta_err, seek ? 0.0f : omega_e,
               at->k_s);
    if (seek) {
        drive_find_rotor(&s->drive.x);
    }
    drive_init(&s->control, &s->twin.x, at->theta_e, omega_e, at->k_s);
    s->drive.y = y;
    s->twin.y = y;
    s->drive.u = zero;
    s->twin.u = zero;
    s->now.omega_ref = omega_e;
    s->now.tau_load = 0.0f;
    s->now.u_dc = s->profile.u_dc[0];
    s->now.segment = 0;
    s->sums = none;
    s->tau_1 = 0.0f;
    s->dev_1 = 0.0f;
    s->err_count = 0;
    s->k = 0;
    s->lost = 0;
    s->begun = 0;
    s->k_lost = 0;
}

void sim_start(sim_t *s, int32_t n) {
    for (int32_t i = 0; i < n; i++) {
        start_one(&s[i]);
    }
}

/* Whether a drive does not advance any more. */
static int over(const sim_t *s) { return (s->lost != 0 && s->go_on == 0) || s->k >= s->k_end; }

/* One period; that of a lost drive changes neither sums nor verdict. extra: that of the plant,
 * passed so that it can be constant. Returns the inputs of the drive's controller. */
CORE_INLINE drive_in_t advance(sim_t *s, float k_s_ref, int extra) {
    sums_t sums = s->sums;
    int32_t lost = s->lost;
    int32_t k_lost = s->k_lost;
    drive_in_t in =
        sim_period(s, k_s_ref, s->sensored, s->with_twin, s->plant.n_sub, extra, s->plant.detail);
    if (lost != 0) {
        s->k = (s->lost & LOST_NONFINITE) != 0 ? s->k_end : s->k;
        s->sums = sums;
        s->lost = lost;
        s->k_lost = k_lost;
    }
    return in;
}

CORE_INLINE void run_until(sim_t *s, int32_t k, float k_s_ref, int extra) {
    while (s->k < k && !over(s)) {
        advance(s, k_s_ref, extra);
    }
}

/* Until period k. */
static void run_one(sim_t *s, int32_t k, float k_s_ref) {
    if (s->plant.extra == EXTRA_NONE) {
        run_until(s, k, k_s_ref, EXTRA_NONE);
    } else if (s->plant.extra == EXTRA_BRIDGE) {
        run_until(s, k, k_s_ref, EXTRA_BRIDGE);
    } else {
        run_until(s, k, k_s_ref, EXTRA_CORRECTION);
    }
}

void sim_signals(const sim_t *s, int32_t n, float *obs) {
    for (int32_t i = 0; i < n; i++) {
        signals_read(&s[i].control.signal, &s[i].drive.x.signal, &obs[(long)i * SIGNAL_N]);
    }
}

typedef struct {
    sim_t *s;
    int32_t n, periods, simd;
    const float *k_s_ref;
    sim_gains_t *gains;
    float *obs;
} run_t;

void sim_set_gain(sim_t *s, sim_gains_t *gains, int32_t n, uint32_t g) {
    for (int32_t i = 0; i < n; i++) {
        sim_gains_t *x = &gains[i];
        float wanted = gain_bounded(&x->limit[g], x->wanted[g]);
        x->value[g] =
            gain_step(&x->limit[g], x->which[g], x->value[g], wanted, &x->design, &s[i].control);
    }
}

/* Advances up to LANES drives; their sums go on. */
static void run_lanes(const run_t *run, int32_t first, int32_t count, int32_t periods) {
    sim_t *s = &run->s[first];
    int32_t k[LANES];
    for (int32_t i = 0; i < count; i++) {
        k[i] = s[i].k_end - s[i].k < periods ? s[i].k_end : s[i].k + periods;
    }
    int simd = batch_fits(s, count, run->simd);
    if (simd != SIMD_NONE) {
        batch_run(s, count, periods, simd, &run->k_s_ref[first]);
    }
    for (int32_t i = 0; i < count; i++) { /* also what drives left when they left their block */
        run_one(&s[i], k[i], run->k_s_ref[first + i]);
    }
}

/* Runs LANES drives, or those that are left. */
static void run_piece(void *job, int32_t piece) {
    const run_t *run = job;
    sums_t none = {0};
    int32_t first = piece * LANES;
    int32_t count = run->n - first < LANES ? run->n - first : LANES;
    sim_t *s = &run->s[first];
    for (int32_t i = 0; i < count; i++) {
        s[i].sums = none;
    }
    int32_t left = run->periods;
    if (run->gains != 0) {
        uint32_t g = 0;
        sim_gains_t *gains = &run->gains[first];
        for (; g < gains->n && left > 1; g++, left--) {
            run_lanes(run, first, count, 1);
            sim_set_gain(s, gains, count, g);
        }
        for (; g < gains->n; g++) {
            sim_set_gain(s, gains, count, g);
        }
    }
    run_lanes(run, first, count, left);
    sim_signals(s, count, &run->obs[(long)first * SIGNAL_N]);
}

#define PERIODS_A_THREAD 5000 /* with fewer, a thread takes longer to start than it saves */

void sim_run_gains(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
                   const float *k_s_ref, sim_gains_t *gains, float *obs) {
    run_t run = {s, n, periods, simd, k_s_ref, gains, obs};
    int64_t worth = (int64_t)n * periods / PERIODS_A_THREAD;
    workers_run(run_piece, &run, (n + LANES - 1) / LANES,
                worth < threads ? (int32_t)worth : threads);
}

void sim_run(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
             const float *k_s_ref, float *obs) {
    sim_run_gains(s, n, periods, simd, threads, k_s_ref, 0, obs);
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
    for (; j < periods && !over(s); j++) {
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
        row[TRACE_U_A] = (double)s->drive.u.a;
        row[TRACE_U_B] = (double)s->drive.u.b;
        row[TRACE_U_A_HAT] = (double)s->drive.x.u_1.a;
        row[TRACE_U_B_HAT] = (double)s->drive.x.u_1.b;
        row[TRACE_INJ] = (double)s->drive.x.hfi.sign_1;
        float starting = s->sums.starting;
        drive_in_t in = advance(s, k_s_ref, s->plant.extra);
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
