/* LANES drives advanced together with vector instructions. */
#ifndef SENSORLESS_BATCH_H
#define SENSORLESS_BATCH_H

#include "block_run.h"

/* The SIMD_* that a block of `count` drives can use on this machine, at most `most`: none unless
 * all of them agree in what block.h takes as constant, and none is in a condition of SCALAR_ONLY
 * (drive/vector.h). Drives that do not fit run one by one. */
int batch_fits(const sim_t *sims, int32_t count, int most);

/* Advances drives that fit. simd: from batch_fits. Returns the period reached, see block_run.h. */
int32_t batch_run(const block_run_t *run, int simd);

#endif
