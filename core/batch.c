/* Blocks of drives in step: sim_period.h over LANES drives at a time, written so that the compiler
 * turns the loop over drives into vector instructions. Host only.
 *
 * A block holds every number of LANES drives side by side: a field at byte offset o of sim_t starts at
 * byte LANES * o. sim_fields.h, generated from sim_t, lists type and path of all fields. Each
 * lane does the operations of the plain loop in the same order, so results are the same to the bit.
 */
#define CORE_VECTOR /* before the first header: lookups by comparison, see curve.h */
#include "batch.h"

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)

#pragma GCC target("avx2")
#pragma GCC optimize("no-thread-jumps") /* threaded jumps would split the loop body into paths */

#include <stddef.h>

#include "sim_fields.h"
#include "sim_period.h"

typedef struct {
    double bytes[LANES * sizeof(sim_t) / sizeof(double)];
} block_t;

#define AT(type, path) ((type *)(void *)((char *)block + LANES * offsetof(sim_t, path)))
#define LOAD(type, path) s.path = AT(type, path)[l];
#define KEEP(type, path) AT(type, path)[l] = go ? s.path : AT(type, path)[l];
#define GATHER(type, path)                                                                         \
    for (int l = 0; l < LANES; l++) {                                                              \
        AT(type, path)[l] = sims[l].path;                                                          \
    }
#define SCATTER(type, path)                                                                        \
    for (int l = 0; l < LANES; l++) {                                                              \
        sims[l].path = AT(type, path)[l];                                                          \
    }

static void block_load(block_t *restrict block, const sim_t *restrict sims) {
    SIM_PARAM_FIELDS(GATHER)
    SIM_STATE_FIELDS(GATHER)
}

static void block_store(block_t *restrict block, sim_t *restrict sims) { SIM_STATE_FIELDS(SCATTER) }

/* One period of all lanes; lost and finished drives keep their state. */
static void block_period(block_t *restrict block, const float *restrict k_s_ref) {
#pragma GCC ivdep
    for (int l = 0; l < LANES; l++) {
        sim_t s;
        SIM_PARAM_FIELDS(LOAD)
        SIM_STATE_FIELDS(LOAD)
        int go = s.lost == 0 && s.k < s.k_end;
        sim_period(&s, k_s_ref[l], 0, 1, 1, 0);
        SIM_STATE_FIELDS(KEEP)
    }
}

int batch_fits(const sim_t *sims) {
    int fits = __builtin_cpu_supports("avx2");
    for (int l = 0; l < LANES; l++) {
        const sim_t *s = &sims[l];
        fits = fits && s->sensored == 0 && s->with_twin != 0 && s->plant.n_sub == 1 &&
               s->plant.bridge == 0 && s->control.hfi.scheme == HFI_ROTATING &&
               s->control.estimator == ESTIMATE_ANGLES && s->drive.x.start.phase == START_DONE &&
               !(s->inv_stick > 0.0f) && s->sensor.carrier == 0;
    }
    return fits;
}

void batch_run(sim_t *sims, int32_t periods, const float *k_s_ref) {
    block_t block;
    block_load(&block, sims);
    for (int32_t j = 0; j < periods; j++) {
        block_period(&block, k_s_ref);
    }
    block_store(&block, sims);
}

#else

int batch_fits(const sim_t *sims) {
    (void)sims;
    return 0;
}

void batch_run(sim_t *sims, int32_t periods, const float *k_s_ref) {
    (void)sims;
    (void)periods;
    (void)k_s_ref;
}

#endif
