/* Many drives over many PWM periods per call: start, run, read. */
#ifndef SENSORLESS_SIMULATE_H
#define SENSORLESS_SIMULATE_H

#include "drive/gains.h"
#include "sim.h"
#include "simd.h"

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
    TRACE_U_A, /* commanded for the period [k, k+1], stator frame [V] */
    TRACE_U_B,
    TRACE_U_DC,         /* [V] */
    TRACE_HF_AMPLITUDE, /* [A] */
    TRACE_STARTING,     /* 1 while the start sequence runs */
    TRACE_U_A_HAT,      /* TRACE_U_A and _B as the estimators see them: without the drive's */
    TRACE_U_B_HAT,      /* compensation of dead time [V] */
    TRACE_INJ,          /* sign of the injection over [k, k+1], 0 = off */
    TRACE_N
};

/* Puts n drives into the state that their start_t describes, without current. */
void sim_start(sim_t *s, int32_t n);

/* Gains that a decision sets besides k_s, of one drive. */
typedef struct {
    drive_params_t design;       /* the drive's parameters with static gains */
    uint32_t n;                  /* gains, 1 ... GAIN_N */
    uint32_t which[GAIN_N];      /* GAIN_* of each, rising */
    gain_limits_t limit[GAIN_N]; /* of each */
    float value[GAIN_N];         /* in force */
    float wanted[GAIN_N];        /* values of this decision; what is out of bounds is clipped */
} sim_gains_t;

/* Advances drive i of n by up to `periods` periods with the weight k_s_ref[i], then reads its
 * signals into obs[i * SIGNAL_N]. Drives that are lost or at their end do not move. simd, threads:
 * the largest SIMD_* and the most threads to use; results depend on neither. */
void sim_run(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
             const float *k_s_ref, float *obs);

/* The same with gains[n], which come into force one by one from the second period of the call on, as
 * gain_schedule_step has it; all drives have the same number of them. */
void sim_run_gains(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
                   const float *k_s_ref, sim_gains_t *gains, float *obs);

/* Brings gain g of n drives into force; no drive moves. */
void sim_set_gain(sim_t *s, sim_gains_t *gains, int32_t n, uint32_t g);

/* Reads the present signals of n drives into obs[i * SIGNAL_N]; no drive moves. */
void sim_signals(const sim_t *s, int32_t n, float *obs);

/* Inputs of the controllers of n drives in the next period; k_s_ref is 0. */
void sim_inputs(const sim_t *s, int32_t n, drive_in_t *in);

/* Advances one drive and writes TRACE_N numbers per period to out; returns the number of periods.
 * Sums are those of this call, as after sim_run. */
int32_t sim_trace(sim_t *s, int32_t periods, float k_s_ref, double *out);

#endif
