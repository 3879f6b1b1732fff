/* LANES drives advanced together with vector instructions. Host only. */
#ifndef SENSORLESS_BATCH_H
#define SENSORLESS_BATCH_H

#include "simulate.h"

#define LANES 16

/* Whether these LANES drives can run as a block on this machine: an AVX2 processor, twins on, not
 * sensored, one sub-step, no bridge term, no carrier, no passive load, no published scheme or other
 * estimator, none in its start sequence. What does not fit runs drive by drive. */
int batch_fits(const sim_t *sims);

/* Advances LANES drives that fit; their sums must have been cleared. */
void batch_run(sim_t *sims, int32_t periods, const float *k_s_ref);

#endif
