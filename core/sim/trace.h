/* What is read from drives: signals, inputs, and every period of a run. */
#ifndef SENSORLESS_TRACE_H
#define SENSORLESS_TRACE_H

#include "sim.h"

/* Columns of a trace, which has one row per period. */
enum {
    TRACE_T = 0,       /* [s] */
    TRACE_OMEGA_M_REF, /* [rad/s] mechanical */
    TRACE_OMEGA_M,
    TRACE_OMEGA_M_HAT,
    TRACE_OMEGA_M_TWIN,
    TRACE_TAU, /* [N m] */
    TRACE_TAU_LOAD,
    TRACE_TAU_TWIN,
    TRACE_K_S,
    TRACE_THETA_E,     /* [rad] */
    TRACE_THETA_E_ERR, /* truth minus estimate [rad] */
    TRACE_THETA_E_ERR_HFI,
    TRACE_THETA_E_ERR_SMO,
    TRACE_I_D, /* true currents in the true frame [A] */
    TRACE_I_Q,
    TRACE_I_A, /* measured by the drive's sensors at k [A] */
    TRACE_I_B,
    TRACE_U_ALPHA, /* commanded for the period [k, k+1], stator frame [V] */
    TRACE_U_BETA,
    TRACE_U_DC,         /* [V] */
    TRACE_HF_AMPLITUDE, /* [A] */
    TRACE_STARTING,     /* 1 while the start sequence runs */
    TRACE_U_ALPHA_HAT, /* TRACE_U_ALPHA and _BETA as the estimators see them: without the drive's */
    TRACE_U_BETA_HAT,  /* compensation of dead time [V] */
    TRACE_INJ,         /* sign of the injection over [k, k+1], 0 = off */
    TRACE_N
};

/* Reads the present signals of n drives into obs[i * SIGNAL_N]; no drive moves. */
void sim_signals(const sim_t *s, int32_t n, float *obs);

/* Inputs of the controllers of n drives in the next period; k_s_ref is 0. */
void sim_inputs(const sim_t *s, int32_t n, drive_in_t *in);

/* Advances one drive and writes TRACE_N numbers per period to out; returns the number of periods.
 * Sums are those of this call, as after sim_run. */
int32_t sim_trace(sim_t *s, int32_t periods, float k_s_ref, double *out);

#endif
