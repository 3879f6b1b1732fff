/* Golden vectors: results of the control core where the table was exported, which must recur here.
 *
 * All numbers are float32 words, so that equality is equality of bits. The functions return the
 * number of vectors with a mismatch and store the index of the first (n if there is none).
 */
#ifndef SENSORLESS_KS_SELFTEST_H
#define SENSORLESS_KS_SELFTEST_H

#include "drive.h"
#include "ks_schedule.h"

/* One lookup: the signal of each axis, and the weight. */
typedef struct {
    uint32_t y[KS_TABLE_AXES];
    uint32_t k_s;
} ks_vector_t;

/* One PWM period: inputs and result of drive_step, and its estimate. */
typedef struct {
    uint32_t i_a, i_b, u_dc, omega_ref, k_s_ref;
    uint32_t u_a, u_b, theta, omega;
} drive_vector_t;

/* Arguments of drive_init before the first period, and the periods that drive_find_rotor is called
 * before. */
typedef struct {
    float theta; /* [rad] */
    float omega; /* electrical [rad/s] */
    float k_s;
    uint32_t find[2];
} drive_start_t;

#ifdef __cplusplus
extern "C" {
#endif

/* The lookup alone; fast enough to run at every start of the target. A table that ks_table_check
 * refuses counts as wrong in all of them. */
uint32_t ks_table_selftest(const ks_table_t *t, const void *values, const ks_vector_t *v,
                           uint32_t n, uint32_t *first);

/* The whole control core over consecutive periods: schedule and drive_step. drive_step gets k_s_ref
 * of the vectors, and the schedule must decide the same. */
uint32_t drive_selftest(const drive_params_t *p, const ks_schedule_params_t *schedule,
                        const drive_start_t *start, const drive_vector_t *v, uint32_t n,
                        uint32_t *first);

#ifdef __cplusplus
}
#endif

#endif
