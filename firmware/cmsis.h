/* Comparison of the CMSIS-DSP layout of a table with the core's lookup. */
#ifndef CMSIS_H
#define CMSIS_H

#include "../core/ks_table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Number of points, in a grid within, at and beyond the edges of a table with two axes, where the
 * two differ by more than rounding. */
uint32_t cmsis_differences(const ks_table_t *t, const float *values);

#ifdef __cplusplus
}
#endif

#endif
