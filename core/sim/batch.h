/* LANES drives advanced together with vector instructions. */
#ifndef SENSORLESS_BATCH_H
#define SENSORLESS_BATCH_H

#include "lanes.h"
#include "sim.h"

/* Which of the SIMD_* a block of `count` drives can use on this machine, `most` at the most: none
 * unless all of them are alike in what block.h takes as constant, and none is in a condition of
 * SCALAR_ONLY (drive/vector.h). What does not fit runs drive by drive. */
int batch_fits(const sim_t *sims, int32_t count, int most);

/* Advances up to LANES drives that fit; their sums must have been cleared. simd: from batch_fits. */
void batch_run(sim_t *sims, int32_t count, int32_t periods, int simd, const float *k_s_ref);

#endif
