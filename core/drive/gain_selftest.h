/* Golden vectors of a schedule that also sets gains; otherwise as in ks_selftest.h. */
#ifndef SENSORLESS_GAIN_SELFTEST_H
#define SENSORLESS_GAIN_SELFTEST_H

#include "gain_schedule.h"
#include "ks_selftest.h"

/* One lookup: the signal of each axis, and the value of each grid. */
typedef struct {
    uint32_t y[KS_TABLE_AXES];
    uint32_t value[GAIN_N];
} gain_vector_t;

#ifdef __cplusplus
extern "C" {
#endif

/* The lookup of the gains alone. Tables that ks_table_check, with the weights k_s, or
 * gain_table_check refuses count as wrong in all of them. */
uint32_t gain_table_selftest(const gain_table_t *t, const ks_table_t *axes, const void *k_s,
                             const void *values, const gain_vector_t *v, uint32_t n,
                             uint32_t *first);

/* The whole control core over consecutive periods: schedule with gains, and drive_step. live:
 * memory for a copy of the drive's parameters. */
uint32_t gain_drive_selftest(const drive_params_t *p, drive_params_t *live,
                             const gain_schedule_params_t *schedule, const drive_start_t *start,
                             const drive_vector_t *v, uint32_t n, uint32_t *first);

#ifdef __cplusplus
}
#endif

#endif
