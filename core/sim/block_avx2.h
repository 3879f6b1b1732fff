/* Blocks with AVX2: two vectors of eight floats, four of four doubles. */
#ifndef SENSORLESS_BLOCK_AVX2_H
#define SENSORLESS_BLOCK_AVX2_H

#include "sim.h"

/* Advances up to LANES drives that fit, see batch.h. */
void block_avx2(sim_t *sims, int32_t count, int32_t periods, const float *k_s_ref);

#endif
