/* Both estimators and their blend over a recorded log, in open loop: nothing is driven.
 *
 * The estimators are the drive's own (drive_observe). What its control would pass to them comes
 * from the log: the voltage applied, and the sign of its injected part. If the log does not have
 * that sign, it is read from the voltage: in the frame of the injection estimator, the injected
 * part changes by 2 u_inj from period to period. Two changes in a row in opposite directions, each
 * of at least 3/4 of that, count as injection, and the d part of the last one has its sign. In two
 * periods, neither the motion of the frame nor current control changes the voltage that much.
 */
#ifndef SENSORLESS_REPLAY_H
#define SENSORLESS_REPLAY_H

#include "drive/drive.h"

/* What the log has for the sampling instant k. */
typedef struct {
    float i_a; /* phase currents at k [A] */
    float i_b;
    float u_a; /* voltage applied over [k-1, k], stator frame [V] */
    float u_b;
    float u_dc;  /* [V] */
    float inj;   /* sign of the injection over [k-1, k]: -1, 0 or 1 */
    float infer; /* 1: read the sign from the voltage instead */
} replay_in_t;

typedef struct {
    drive_state_t x;
    dq_t
        u_1; /* voltages of the two periods before, each in the injection frame at its middle [V] */
    dq_t u_2;
} replay_t;

/* Columns of an output row; angles and speeds are those for instant k, electrical. */
enum {
    REPLAY_THETA_HFI = 0, /* [rad] */
    REPLAY_OMEGA_HFI,     /* [rad/s] */
    REPLAY_THETA_SMO,
    REPLAY_OMEGA_SMO,
    REPLAY_THETA_BLEND,
    REPLAY_OMEGA_BLEND,
    REPLAY_K_S,
    REPLAY_VALID_HFI, /* 1: driven by its own signal, 0: following the blend */
    REPLAY_VALID_SMO,
    REPLAY_N
};

/* Starts the estimators at theta [rad] and omega [rad/s], electrical, with weight k_s. */
void replay_init(const drive_params_t *p, replay_t *x, float theta, float omega, float k_s);

/* Runs n rows of the log with the weight k_s_ref. Writes REPLAY_N numbers per row to out, and the
 * signals after the last row to obs[SIGNAL_N]. */
void replay_run(const drive_params_t *p, replay_t *x, const replay_in_t *in, int32_t n,
                float k_s_ref, float *out, float *obs);

#endif
