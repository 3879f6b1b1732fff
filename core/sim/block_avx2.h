/* Blocks with AVX2: two vectors of eight floats, four of four doubles. */
#ifndef SENSORLESS_BLOCK_AVX2_H
#define SENSORLESS_BLOCK_AVX2_H

#include "block_run.h"

/* Advances drives; returns the period reached, see block_run.h. */
int32_t block_avx2(const block_run_t *run);

#endif
