/* Blocks with AVX-512: one vector of sixteen floats, two of eight doubles. */
#ifndef SENSORLESS_BLOCK_AVX512_H
#define SENSORLESS_BLOCK_AVX512_H

#include "sim.h"

/* Advances up to LANES drives that fit, see batch.h. */
void block_avx512(sim_t *sims, int32_t count, int32_t periods, const float *k_s_ref);

#endif
