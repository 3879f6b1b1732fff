/* Blocks with AVX-512: one vector of sixteen floats, two of eight doubles. */
#ifndef SENSORLESS_BLOCK_AVX512_H
#define SENSORLESS_BLOCK_AVX512_H

#include "block_run.h"

/* Advances drives; returns the period reached, see block_run.h. */
int32_t block_avx512(const block_run_t *run);

#endif
