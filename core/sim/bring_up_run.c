/* Samples and voltages on their way through what is built in. */
#include "bring_up_run.h"

#include "sim_period.h"

static ab_t mapped(const float *m, ab_t x) {
    ab_t y = {m[0] * x.a + m[1] * x.b, m[2] * x.a + m[3] * x.b};
    return y;
}

static ab_t between(ab_t x, ab_t y, float share) {
    ab_t z = {x.a + share * (y.a - x.a), x.b + share * (y.b - x.b)};
    return z;
}

/* Voltage that acts now, of the commands of this period and of the last two. */
static ab_t delayed(float delay, const ab_t *u) {
    return delay < 1.0f ? between(u[0], u[1], delay) : between(u[1], u[2], delay - 1.0f);
}

int32_t bring_up_run(sim_t *s, const built_t *b, const bring_up_params_t *p, bring_up_state_t *x,
                     int32_t periods, double *out) {
    ab_t u[3] = {{0.0f, 0.0f}, {0.0f, 0.0f}, {0.0f, 0.0f}};
    int32_t rows = 0;
    for (; rows < periods && x->phase != BRING_UP_DONE; rows++) {
        double *row = &out[(long)rows * BUILT_N];
        drive_in_t in = sim_sample(s, &s->drive, 0.0f, s->plant.detail);
        ab_t i_ab = phases_to_ab(in.i_a, in.i_b);
        ab_t got = mapped(b->i_map, i_ab);
        float i_b = phase_b(got);
        ab_t wanted = bring_up_step(p, x, got.a, i_b);
        row[BUILT_I_A] = (double)got.a;
        row[BUILT_I_B] = (double)i_b;
        row[BUILT_U_A] = (double)wanted.a;
        row[BUILT_U_B] = (double)wanted.b;
        u[2] = u[1];
        u[1] = u[0];
        u[0] = mapped(b->u_map, wanted);
        ab_t acts = delayed(b->delay, u);
        float u_leg = b->added * in.u_dc * s->sensor.dead_time_share;
        ab_t more = dead_time_voltage(u_leg, b->inv_i_add, i_ab);
        s->drive.u.a = acts.a + more.a;
        s->drive.u.b = acts.b + more.b;
        chain_advance(s, &s->drive, acts, s->plant.n_sub, s->plant.extra, s->plant.detail);
        s->k += 1;
    }
    return rows;
}

int32_t bring_up_replay(const bring_up_params_t *p, bring_up_state_t *x, int32_t n, double *rows) {
    int32_t j = 0;
    for (; j < n && x->phase != BRING_UP_DONE; j++) {
        double *row = &rows[(long)j * BUILT_N];
        ab_t u = bring_up_step(p, x, (float)row[BUILT_I_A], (float)row[BUILT_I_B]);
        row[BUILT_U_A] = (double)u.a;
        row[BUILT_U_B] = (double)u.b;
    }
    return j;
}
