/* The true state of a drive, which only a critic may see. */
#ifndef SENSORLESS_TRUTH_H
#define SENSORLESS_TRUTH_H

#include "sim.h"

/* Columns; signed quantities are in the direction of motion. */
enum {
    TRUTH_ERR = 0,     /* angle error of the blend, mean over the last sim_run [rad] */
    TRUTH_ERR_HFI,     /* of the injection estimator */
    TRUTH_ERR_SMO,     /* of the observer in use */
    TRUTH_OMEGA_M_DEV, /* speed minus the twin's, mean [rad/s] mechanical */
    TRUTH_TAU_DEV,     /* torque minus the twin's, mean [N m] */
    TRUTH_TAU,         /* torque, mean [N m] */
    TRUTH_TAU_LOAD,    /* load torque [N m] */
    TRUTH_OMEGA_M,     /* [rad/s] */
    TRUTH_U_DC,        /* DC-link voltage minus the nominal one [V] */
    TRUTH_ERR_COUNT,   /* periods for which the error has exceeded its limit */
    TRUTH_N
};

/* Writes TRUTH_N numbers of each of n drives, times scale[TRUTH_N] and limited to +-bound (NaN to
 * -bound), to the first of the `columns` columns of out. u_dc: the nominal DC-link voltage [V]. */
void sim_truth(const sim_t *s, int32_t n, float u_dc, const float *scale, float bound, float *out,
               int32_t columns);

#endif
