/* Many drives over many PWM periods a call: start, run, look. */
#ifndef SENSORLESS_SIMULATE_H
#define SENSORLESS_SIMULATE_H

#include "sim.h"
#include "simd.h"

/* Signals of a trace row, one a period. */
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
    TRACE_U_A, /* commanded for the period [k, k+1], stator frame [V] */
    TRACE_U_B,
    TRACE_U_DC,         /* [V] */
    TRACE_HF_AMPLITUDE, /* [A] */
    TRACE_STARTING,     /* 1 while the start sequence runs */
    TRACE_U_A_HAT,      /* TRACE_U_A and _B as the observers see them: without the drive's */
    TRACE_U_B_HAT,      /* compensation of its dead time [V] */
    TRACE_INJ,          /* sign of the injection over [k, k+1], 0 = off */
    TRACE_N
};

/* Puts n drives at the start their own start_t describes, without current. */
void sim_start(sim_t *s, int32_t n);

/* Advances n drives by up to `periods` periods each with the weight k_s_ref[i] (one a drive), then
 * reads the signals of drive i into obs[i * SIGNAL_N]. Drives that are lost or at their end stay.
 * simd: the most that may be used of SIMD_*; threads: likewise. Results depend on neither. */
void sim_run(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
             const float *k_s_ref, float *obs);

/* Signals of n drives as they stand into obs[i * SIGNAL_N]; no drive moves. */
void sim_signals(const sim_t *s, int32_t n, float *obs);

/* What the controllers of n drives are about to be given in the coming period; k_s_ref is 0. */
void sim_inputs(const sim_t *s, int32_t n, drive_in_t *in);

/* One drive, one row of TRACE_N numbers a period into out; returns the periods advanced. Sums are
 * those of this call, as after sim_run. */
int32_t sim_trace(sim_t *s, int32_t periods, float k_s_ref, double *out);

#endif
