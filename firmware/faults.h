/* What a fault must not do: tests that need no C library, for a host and for the target.
 *
 * Each returns the number of cases that went wrong. Wrong is: a damaged table that is accepted, a
 * number out of range or not finite that comes out, a fault that is not reported.
 */
#ifndef SENSORLESS_FAULTS_H
#define SENSORLESS_FAULTS_H

#include "../core/drive.h"
#include "../core/ks_schedule.h"

/* Every bit of header and values flipped, one at a time: ks_table_check has to refuse. */
uint32_t faults_flips(const ks_table_t *t, const void *values, uint32_t motor_hash);

/* Wrong format number, wrong CRC, wrong motor, no table: the built-in rule and KS_FAULT_TABLE. */
uint32_t faults_refusals(const ks_schedule_params_t *p, const signal_params_t *signal);

/* NaN, infinities, denormals, huge numbers as signals: a weight in [0, 1], the fallback and
 * KS_FAULT_INPUT where a signal that is read is not finite. */
uint32_t faults_signals(const ks_schedule_params_t *p, const signal_params_t *signal);

/* The same on every input of drive_step, alone and in pairs. */
uint32_t faults_inputs(const drive_params_t *p);

/* Start and turn across the seam at +-180 degrees. */
uint32_t faults_angles(const drive_params_t *p);

/* k_s at and beyond its limits. */
uint32_t faults_weights(const drive_params_t *p);

#endif
