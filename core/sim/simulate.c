/* Drives one by one or as blocks, over several threads. */
#include "simulate.h"

#include "batch.h"
#include "sim_advance.h"
#include "trace.h"
#include "workers.h"

CORE_INLINE void run_until(sim_t *s, int32_t k, float k_s_ref, int extra) {
    while (s->k < k && !sim_over(s)) {
        sim_advance(s, k_s_ref, extra);
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

typedef struct {
    sim_t *s;
    int32_t n, periods, simd;
    const float *k_s_ref;
    sim_gains_t *gains;
    float *obs;
} run_t;

/* Advances up to LANES drives from period `done` of the decision on; their sums go on. Returns how
 * many periods are done: all, unless a gain has to come into force first. */
static int32_t run_lanes(const run_t *run, int32_t first, int32_t count, int32_t done) {
    sim_t *s = &run->s[first];
    sim_gains_t *gains = run->gains != 0 ? &run->gains[first] : 0;
    const float *k_s_ref = &run->k_s_ref[first];
    int32_t k[LANES];
    for (int32_t i = 0; i < count; i++) {
        k[i] = s[i].k;
    }
    sim_set_due(s, gains, count, done, run->periods);
    int simd = batch_fits(s, count, run->simd);
    int32_t to = done + 1;
    if (simd != SIMD_NONE) {
        block_run_t block = {s, count, done, run->periods, k_s_ref, gains};
        to = batch_run(&block, simd);
    } else if (gains == 0 || done >= (int32_t)gains->n) {
        to = run->periods;
    }
    for (int32_t i = 0; i < count; i++) { /* also what drives left when they left their block */
        int32_t most = s[i].k_end - k[i];
        run_one(&s[i], k[i] + (most < to - done ? most : to - done), k_s_ref[i]);
    }
    return to;
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
    for (int32_t done = 0; done < run->periods;) {
        done = run_lanes(run, first, count, done);
    }
    sim_signals(s, count, &run->obs[(long)first * SIGNAL_N]);
}

#define PERIODS_A_THREAD 5000 /* with fewer, a thread takes longer to start than it saves */

void sim_run(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
             const float *k_s_ref, sim_gains_t *gains, float *obs) {
    run_t run = {s, n, periods, simd, k_s_ref, gains, obs};
    int64_t worth = (int64_t)n * periods / PERIODS_A_THREAD;
    workers_run(run_piece, &run, (n + LANES - 1) / LANES,
                worth < threads ? (int32_t)worth : threads);
}
