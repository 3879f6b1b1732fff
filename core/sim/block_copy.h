/* Copies drives into a block and back: sim_t in units of 8 bytes, transposed 4 by 4.
 *
 * A block holds each number of LANES drives side by side: a field at byte offset o of sim_t starts
 * at byte LANES * o. A unit of sim_t is one double or a pair of 4-byte numbers; sim_fields.h says
 * which.
 */
#ifndef SENSORLESS_BLOCK_COPY_H
#define SENSORLESS_BLOCK_COPY_H

#include "lanes.h"
#include "sim.h"
#include "simd.h"

#ifdef SIMD_BLOCKS

#include <stddef.h>

#include "sim_fields.h"

#define UNITS (sizeof(sim_t) / 8)
#define UNIT_CONTROL (offsetof(sim_t, control) / 8)
#define UNIT_SENSOR (offsetof(sim_t, sensor) / 8 + 1)
#define UNIT_STATE (offsetof(sim_t, drive) / 8) /* parameters before it, the state after */

typedef struct {
    double units[UNITS][LANES] __attribute__((aligned(64)));
} block_t;

/* Four units, and eight 4-byte numbers. They may alias anything, at any multiple of 8 bytes. */
typedef long long four_t __attribute__((vector_size(32), may_alias, aligned(8)));
typedef int eight_t __attribute__((vector_size(32), may_alias, aligned(8)));

#ifdef __clang__
#define SHUFFLE(type, a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define SHUFFLE(type, a, b, ...) __builtin_shuffle(a, b, (type){__VA_ARGS__})
#endif

static const unsigned char unit_is_pair[UNITS] = SIM_UNIT_IS_PAIR;

/* Units that a block uses: first and end of each run, four or more. */
static const size_t unit_run[][2] = SIM_UNIT_RUNS;
#define UNIT_RUNS (sizeof(unit_run) / sizeof(unit_run[0]))

/* Transposes four rows of four. */
CORE_INLINE void turn_4x4(four_t *x) {
    four_t a = SHUFFLE(four_t, x[0], x[1], 0, 4, 2, 6);
    four_t b = SHUFFLE(four_t, x[0], x[1], 1, 5, 3, 7);
    four_t c = SHUFFLE(four_t, x[2], x[3], 0, 4, 2, 6);
    four_t d = SHUFFLE(four_t, x[2], x[3], 1, 5, 3, 7);
    x[0] = SHUFFLE(four_t, a, c, 0, 1, 4, 5);
    x[1] = SHUFFLE(four_t, b, d, 0, 1, 4, 5);
    x[2] = SHUFFLE(four_t, a, c, 2, 3, 6, 7);
    x[3] = SHUFFLE(four_t, b, d, 2, 3, 6, 7);
}

/* One unit of eight lanes, as pairs in the order of sim_t, to and from half a row of the block;
 * there, the first numbers of all pairs come LANES numbers before the second ones. */
CORE_INLINE void pairs_apart(const four_t *x, char *row) {
    eight_t a = (eight_t)x[0];
    eight_t b = (eight_t)x[1];
    *(eight_t *)(void *)row = SHUFFLE(eight_t, a, b, 0, 2, 4, 6, 8, 10, 12, 14);
    *(eight_t *)(void *)(row + 4 * LANES) = SHUFFLE(eight_t, a, b, 1, 3, 5, 7, 9, 11, 13, 15);
}

CORE_INLINE void pairs_together(const char *row, four_t *x) {
    eight_t a = *(const eight_t *)(const void *)row;
    eight_t b = *(const eight_t *)(const void *)(row + 4 * LANES);
    x[0] = (four_t)SHUFFLE(eight_t, a, b, 0, 8, 1, 9, 2, 10, 3, 11);
    x[1] = (four_t)SHUFFLE(eight_t, a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}

/* Copies units u ... u + 3 of lanes l ... l + 7 into the block. */
CORE_INLINE void load_4x8(block_t *block, const sim_t *const *from, size_t u, int l) {
    four_t x[2][4];
    for (int h = 0; h < 2; h++) {
        for (int j = 0; j < 4; j++) {
            x[h][j] = *((const four_t *)(const void *)((const double *)from[l + 4 * h + j] + u));
        }
        turn_4x4(x[h]);
    }
    for (size_t j = 0; j < 4; j++) {
        four_t both[2] = {x[0][j], x[1][j]};
        char *row = (char *)block->units[u + j];
        if (unit_is_pair[u + j]) {
            pairs_apart(both, row + 4 * l);
        } else {
            *(four_t *)(void *)(row + 8 * l) = both[0];
            *(four_t *)(void *)(row + 8 * l + 32) = both[1];
        }
    }
}

/* Copies them back. */
CORE_INLINE void store_4x8(const block_t *block, sim_t *const *to, size_t u, int l) {
    four_t x[2][4];
    for (size_t j = 0; j < 4; j++) {
        four_t both[2];
        const char *row = (const char *)block->units[u + j];
        if (unit_is_pair[u + j]) {
            pairs_together(row + 4 * l, both);
        } else {
            both[0] = *(const four_t *)(const void *)(row + 8 * l);
            both[1] = *(const four_t *)(const void *)(row + 8 * l + 32);
        }
        x[0][j] = both[0];
        x[1][j] = both[1];
    }
    for (int h = 0; h < 2; h++) {
        turn_4x4(x[h]);
        for (int j = 0; j < 4; j++) {
            *((four_t *)(void *)((double *)(void *)to[l + 4 * h + j] + u)) = x[h][j];
        }
    }
}

/* Those of a run that are in first ... end - 1: their first one, and how far they go. */
CORE_INLINE size_t run_first(size_t run, size_t first) {
    return unit_run[run][0] > first ? unit_run[run][0] : first;
}

CORE_INLINE size_t run_end(size_t run, size_t end) {
    return unit_run[run][1] < end ? unit_run[run][1] : end;
}

/* Copies what a block uses of units first ... end - 1 of the drives from[LANES]. The last four of a
 * run may overlap those before. */
static inline void block_load(block_t *block, const sim_t *const *from, size_t first, size_t end) {
    for (size_t j = 0; j < UNIT_RUNS; j++) {
        size_t last = run_end(j, end);
        for (size_t u = run_first(j, first); u < last; u += 4) {
            for (int l = 0; l < LANES; l += 8) {
                load_4x8(block, from, u + 4 <= last ? u : last - 4, l);
            }
        }
    }
}

/* Copies what it uses of the state to the drives to[LANES]. */
static inline void block_store(const block_t *block, sim_t *const *to) {
    for (size_t j = 0; j < UNIT_RUNS; j++) {
        size_t last = run_end(j, UNITS);
        for (size_t u = run_first(j, UNIT_STATE); u < last; u += 4) {
            for (int l = 0; l < LANES; l += 8) {
                store_4x8(block, to, u + 4 <= last ? u : last - 4, l);
            }
        }
    }
}

#endif
#endif
