/* Many drives over many PWM periods per call. */
#ifndef SENSORLESS_SIMULATE_H
#define SENSORLESS_SIMULATE_H

#include "sim.h"
#include "sim_gains.h"
#include "simd.h"

/* Advances drive i of n by up to `periods` periods with the weight k_s_ref[i], then reads its
 * signals into obs[i * SIGNAL_N]. Drives that are lost or at their end do not move. simd, threads:
 * the largest SIMD_* and the most threads to use; results depend on neither. gains[n], or 0 for
 * none, come into force one by one from the second period of the call on, as gain_schedule_step has
 * it; all drives have the same number of them. */
void sim_run(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
             const float *k_s_ref, sim_gains_t *gains, float *obs);

#endif
