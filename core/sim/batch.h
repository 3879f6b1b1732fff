/* LANES drives advanced together with vector instructions. */
#ifndef SENSORLESS_BATCH_H
#define SENSORLESS_BATCH_H

#include "lanes.h"
#include "sim.h"

/* The SIMD_* that a block of `count` drives can use on this machine, at most `most`: none unless
 * all of them agree in what block.h takes as constant, and none is in a condition of SCALAR_ONLY
 * (drive/vector.h). Drives that do not fit run one by one. */
int batch_fits(const sim_t *sims, int32_t count, int most);

/* Advances up to LANES drives that fit, whose sums must be zero. simd: from batch_fits. */
void batch_run(sim_t *sims, int32_t count, int32_t periods, int simd, const float *k_s_ref);

#endif
