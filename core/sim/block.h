/* A block of drives in lock-step: sim_period.h over LANES drives at a time, written so that the
 * compiler turns the loop over drives into vector instructions.
 *
 * Included once for every set of instructions, with BLOCK_RUN as the name of the function to
 * define. Each lane does the operations of the plain loop in the same order, so results are the
 * same to the bit.
 */
#ifndef SENSORLESS_BLOCK_H
#define SENSORLESS_BLOCK_H

#include "block_copy.h"
#include "block_run.h"

#ifdef BLOCK_RUN

#ifndef __clang__
#pragma GCC optimize("no-thread-jumps") /* threaded jumps would split the loop body into paths */
#endif

#include "sim_period.h"

#define AT(type, path) ((type *)(void *)((char *)block + LANES * offsetof(sim_t, path)))
#define LOAD(type, path) s.path = AT(type, path)[l];
#define KEEP(type, path) AT(type, path)[l] = s.path;

/* One period of all lanes, even of those at their end, which BLOCK_RUN has stored before. A
 * constant estimator leaves no branch in the loop. */
CORE_INLINE void block_period(block_t *restrict block, const float *restrict k_s_ref, int with_twin,
                              int estimator, int detail) {
    LANES_LOOP for (int l = 0; l < LANES; l++) {
        sim_t s;
        SIM_PARAM_FIELDS(LOAD)
        SIM_STATE_FIELDS(LOAD)
        s.with_twin = with_twin;
        s.control.estimator = estimator;
        sim_period(&s, k_s_ref[l], 0, with_twin, 1, 0, detail);
        SIM_STATE_FIELDS(KEEP)
    }
}

#define KEEP_DUE(type, path)                                                                       \
    {                                                                                              \
        type old = AT(type, path)[l];                                                              \
        type now = s.path;                                                                         \
        AT(type, path)[l] = due ? now : old;                                                       \
    }

/* One of the two parts of lock.h, in lanes where it is due. */
#define BLOCK_LOCK(name, part, when)                                                               \
    CORE_APART void name(block_t *restrict block) {                                                \
        LANES_LOOP for (int l = 0; l < LANES; l++) {                                               \
            sim_t s;                                                                               \
            SIM_PARAM_FIELDS(LOAD)                                                                 \
            SIM_STATE_FIELDS(LOAD)                                                                 \
            int due = s.drive.x.lock.wait == (when);                                               \
            part(&s.control, &s.drive.x);                                                          \
            SIM_LOCK_FIELDS(KEEP_DUE)                                                              \
        }                                                                                          \
    }

BLOCK_LOCK(block_watch, drive_watch, 1)
BLOCK_LOCK(block_judge, drive_judge, 0)

#define BLOCK_LOOP(name, with_twin, estimator, detail)                                             \
    CORE_APART void name(block_t *restrict block, const float *restrict k_s_ref) {                 \
        block_period(block, k_s_ref, with_twin, estimator, detail);                                \
    }

BLOCK_LOOP(block_smo_alone, 0, ESTIMATE_SMO, 0)
BLOCK_LOOP(block_smo_twin, 1, ESTIMATE_SMO, 0)
BLOCK_LOOP(block_smo_alone_detail, 0, ESTIMATE_SMO, 1)
BLOCK_LOOP(block_smo_twin_detail, 1, ESTIMATE_SMO, 1)
BLOCK_LOOP(block_flux_alone, 0, ESTIMATE_FLUX, 0)
BLOCK_LOOP(block_flux_twin, 1, ESTIMATE_FLUX, 0)
BLOCK_LOOP(block_flux_alone_detail, 0, ESTIMATE_FLUX, 1)
BLOCK_LOOP(block_flux_twin_detail, 1, ESTIMATE_FLUX, 1)

BLOCK_LOOP(block_coupled_alone, 0, ESTIMATE_COUPLED, 0)
BLOCK_LOOP(block_coupled_twin, 1, ESTIMATE_COUPLED, 0)
BLOCK_LOOP(block_coupled_alone_detail, 0, ESTIMATE_COUPLED, 1)
BLOCK_LOOP(block_coupled_twin_detail, 1, ESTIMATE_COUPLED, 1)

typedef void (*period_t)(block_t *restrict, const float *restrict);

/* By detail and twin. */
static const period_t SMO_LOOPS[2][2] = {
    {block_smo_alone, block_smo_twin},
    {block_smo_alone_detail, block_smo_twin_detail},
};
static const period_t FLUX_LOOPS[2][2] = {
    {block_flux_alone, block_flux_twin},
    {block_flux_alone_detail, block_flux_twin_detail},
};
static const period_t COUPLED_LOOPS[2][2] = {
    {block_coupled_alone, block_coupled_twin},
    {block_coupled_alone_detail, block_coupled_twin_detail},
};

/* The loop for drives that all agree with this one, see batch_fits. */
static period_t block_loop(const sim_t *s) {
    int detail = s->plant.detail != 0;
    int twin = s->with_twin != 0;
    if (s->control.estimator == ESTIMATE_COUPLED) {
        return COUPLED_LOOPS[detail][twin];
    }
    return s->control.estimator == ESTIMATE_FLUX ? FLUX_LOOPS[detail][twin]
                                                 : SMO_LOOPS[detail][twin];
}

/* Drives that are lost, at their end, not or no longer in control, or since lost lock on another
 * observer than the block: bit l for lane l. */
static uint32_t block_at_end(const block_t *block) {
    const int32_t *lost = AT(const int32_t, lost);
    const int32_t *k = AT(const int32_t, k);
    const int32_t *k_end = AT(const int32_t, k_end);
    const int32_t *phase = AT(const int32_t, drive.x.start.phase);
    const int32_t *again = AT(const int32_t, drive.x.start.again);
    const int32_t *estimator = AT(const int32_t, control.estimator);
    const int32_t *action = AT(const int32_t, control.lock.action);
    const int32_t *n_act = AT(const int32_t, control.lock.n_act);
    const int32_t *n_alarm = AT(const int32_t, control.lock.n_alarm);
    const int32_t *bad = AT(const int32_t, drive.x.lock.bad);
    const int32_t *calm = AT(const int32_t, drive.x.lock.calm);
    uint32_t bits = 0;
    for (int l = 0; l < LANES; l++) {
        int change = again[l] == 0 && estimator[l] != ESTIMATE_COUPLED; /* drive_can_change */
        int32_t n = change && action[l] == LOCK_RESTART ? n_alarm[l] : n_act[l]; /* lock_acts */
        int acts = action[l] != LOCK_REPORT && bad[l] >= n && calm[l] == 0;
        int other = again[l] != 0 && estimator[l] != ESTIMATE_COUPLED;
        int out = lost[l] != 0 || k[l] >= k_end[l] || phase[l] != START_DONE || acts || other;
        bits |= (uint32_t)out << l;
    }
    return bits;
}

/* The tests of lock.h, if due in any lane. */
static void block_lock(block_t *block) {
    const int32_t *wait = AT(const int32_t, drive.x.lock.wait);
    int first = 0;
    int second = 0;
    for (int l = 0; l < LANES; l++) {
        first |= wait[l] == 1;
        second |= wait[l] == 0;
    }
    if (first) {
        block_watch(block);
    }
    if (second) {
        block_judge(block);
    }
}

/* Stores the lanes in `bits`; the others go to `nowhere`. */
static void block_take(const block_t *block, sim_t *sims, uint32_t bits, sim_t *nowhere) {
    sim_t *to[LANES];
    for (int l = 0; l < LANES; l++) {
        to[l] = (bits >> l & 1U) != 0 ? &sims[l] : nowhere;
    }
    block_store(block, to);
}

/* Drives in `bits` that lost lock act, as they do in the plain loop. */
static void block_act(sim_t *sims, uint32_t bits) {
    for (int l = 0; l < LANES; l++) {
        if ((bits >> l & 1U) != 0 && drive_acts(&sims[l].control, &sims[l].drive.x)) {
            drive_state_t *x = &sims[l].drive.x;
            drive_act(&sims[l].control, x);
            sims[l].drive.u = x->start.phase == START_STOPPED ? x->u_1 : sims[l].drive.u;
        }
    }
}

/* Whether a drive in `bits` moves on. */
static int block_moves(const sim_t *sims, uint32_t bits) {
    int moves = 0;
    for (int l = 0; l < LANES; l++) {
        moves |= (bits >> l & 1U) != 0 && !sim_over(&sims[l]);
    }
    return moves;
}

/* A drive at its end is stored at once, and its lane runs on without effect; so do the lanes beyond
 * count, which repeat the first drive. Drives that leave early have periods left. */
int32_t BLOCK_RUN(const block_run_t *run) {
    sim_t *sims = run->sims;
    block_t block;
    sim_t nowhere;
    float wanted[LANES];
    const sim_t *from[LANES];
    for (int l = 0; l < LANES; l++) {
        int lane = l < run->count ? l : 0;
        from[l] = &sims[lane];
        wanted[l] = run->k_s_ref[lane];
    }
    block_load(&block, from, 0, UNITS);
    uint32_t all = (1U << run->count) - 1U;
    uint32_t live = all & ~block_at_end(&block);
    period_t period = block_loop(sims);
    int32_t gains = run->gains != 0 ? (int32_t)run->gains->n : 0;
    int32_t done = run->done;
    int32_t due = done;                                      /* gains of this period are in force */
    int apart = gains > 0 && block_moves(sims, all & ~live); /* that drive needs each gain, too */
    while (live != 0 && done < run->periods && due == done) {
        period(&block, wanted);
        done++;
        block_lock(&block);
        uint32_t over = live & block_at_end(&block);
        if (over != 0) {
            block_take(&block, sims, over, &nowhere);
            block_act(sims, over);
            live &= ~over;
            apart = gains > 0 && block_moves(sims, all & ~live);
        }
        if (live != 0 && (!apart || done > gains)) {
            due = done;
            if (sim_set_due(sims, run->gains, run->count, done, run->periods)) {
                block_load(&block, from, UNIT_CONTROL, UNIT_SENSOR);
            }
        }
    }
    block_take(&block, sims, live, &nowhere);
    int32_t least = run->done + 1;
    return live == 0 && due >= gains ? run->periods : done > least ? done : least;
}

#endif
#endif
