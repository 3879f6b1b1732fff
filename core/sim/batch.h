/* LANES drives advanced together with vector instructions. Host only. */
#ifndef SENSORLESS_BATCH_H
#define SENSORLESS_BATCH_H

#include "simulate.h"

#define LANES 16
#define LANES_WORTH 4 /* drives that pay for a whole block */

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define BATCH_BLOCKS /* the compiler knows how to make them */
#endif

/* Which of the SIMD_* a block of `count` drives can use on this machine, `most` at the most. Vector
 * code wants: all with or all without twin, all on the sliding-mode or all on the flux observer, not
 * sensored, one sub-step, no bridge term, no carrier, no passive load, the drive's own injection
 * scheme, and none in its start sequence. What does not fit runs drive by drive. */
int batch_fits(const sim_t *sims, int32_t count, int most);

/* Advances up to LANES drives that fit; their sums must have been cleared. simd: from batch_fits. */
void batch_run(sim_t *sims, int32_t count, int32_t periods, int simd, const float *k_s_ref);

/* The same block.h for each set of instructions. */
void batch_avx2(sim_t *sims, int32_t count, int32_t periods, const float *k_s_ref);
void batch_avx512(sim_t *sims, int32_t count, int32_t periods, const float *k_s_ref);

#endif
