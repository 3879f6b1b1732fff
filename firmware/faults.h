/* Fault tests that need no C library, for a host and for the target.
 *
 * Each returns the number of cases that went wrong: a damaged table was accepted, an output was not
 * finite or out of range, or a fault was not reported.
 */
#ifndef SENSORLESS_FAULTS_H
#define SENSORLESS_FAULTS_H

#include "../core/drive.h"
#include "../core/ks_schedule.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Every bit of header and values flipped, one at a time: ks_table_check must refuse the table. */
uint32_t faults_flips(const ks_table_t *t, const void *values, uint32_t motor_hash);

/* Wrong format number, CRC or motor, or no table: the built-in rule decides, with
 * KS_FAULT_TABLE. */
uint32_t faults_refusals(const ks_schedule_params_t *p, const signal_params_t *signal);

/* NaN, infinity, denormal and huge numbers as signals: the weight stays in [0, 1], and is the
 * fallback where a signal of the table is not finite. */
uint32_t faults_signals(const ks_schedule_params_t *p, const signal_params_t *signal);

/* The same numbers on every input of drive_step, alone and in pairs. */
uint32_t faults_inputs(const drive_params_t *p);

/* Starting at and turning across +-180 degrees. */
uint32_t faults_angles(const drive_params_t *p);

/* k_s at and beyond its limits. */
uint32_t faults_weights(const drive_params_t *p);

#ifdef __cplusplus
}
#endif

#endif
