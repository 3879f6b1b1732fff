/* What only a critic may see of a drive in motion. */
#ifndef SENSORLESS_TRUTH_H
#define SENSORLESS_TRUTH_H

#include "sim.h"

/* What a critic may see, signed quantities are taken in the direction of motion. */
enum {
    TRUTH_ERR = 0,     /* angle errors: of the blend, mean of the last sim_run [rad] */
    TRUTH_ERR_HFI,     /* of the injection estimator */
    TRUTH_ERR_SMO,     /* of the sliding-mode observer */
    TRUTH_OMEGA_M_DEV, /* speed minus the twin's, mean [rad/s] mechanical */
    TRUTH_TAU_DEV,     /* torque minus the twin's, mean [N m] */
    TRUTH_TAU,         /* torque, mean [N m] */
    TRUTH_TAU_LOAD,    /* load torque [N m] */
    TRUTH_OMEGA_M,     /* [rad/s] */
    TRUTH_U_DC,        /* DC-link voltage minus the nominal one [V] */
    TRUTH_ERR_COUNT,   /* periods the error has been beyond its limit */
    TRUTH_N
};

/* TRUTH_N numbers of each of n drives times scale[TRUTH_N], limited to +-bound (NaN to -bound), into
 * the first of the `columns` of each row of out. u_dc: the nominal voltage [V]. */
void sim_truth(const sim_t *s, int32_t n, float u_dc, const float *scale, float bound, float *out,
               int32_t columns);

#endif
