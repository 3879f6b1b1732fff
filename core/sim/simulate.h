/* A drive with its machine, its sensored twin and the running sums of one decision. Host only.
 *
 * sim_t is plain old data: copying its bytes is a snapshot.
 */
#ifndef SENSORLESS_SIMULATE_H
#define SENSORLESS_SIMULATE_H

#include "drive/drive.h"
#include "inverter.h"
#include "plant.h"
#include "profile.h"

/* Why a drive is not advanced any more; bits of sim_t.lost. */
enum {
    LOST_ANGLE = 1,     /* angle error beyond its limit for longer than allowed */
    LOST_CURRENT = 2,   /* over-current trip */
    LOST_NONFINITE = 4, /* a state left the numbers */
    LOST_TWIN = 8       /* the sensored twin itself tripped */
};

typedef struct {
    drive_state_t x;
    int32_t reserved;
    plant_state_t y;
    ab_t u; /* command waiting to act over the next period [V] */
} chain_t;

/* Sums over the periods of one decision; divide by n. */
typedef struct {
    float tau, tau_sq;           /* torque [N m] and its square */
    float tau_lf_sq;             /* square of the two-sample mean: without the injection band */
    float tau_min, tau_max;      /* extremes [N m] */
    float tau_twin;              /* torque of the twin [N m] */
    float dev_sq, dev_lf_sq;     /* (torque - twin)^2, and of its two-sample mean */
    float omega_m, omega_m_twin; /* mechanical speed [rad/s] */
    float err, err_sq, err_max;  /* angle error of the blend [rad], its square, largest magnitude */
    float err_hfi, err_smo;      /* angle errors of the two estimators [rad] */
    float k_s, k_s_moved;        /* weight; sum of the magnitudes of its changes */
    float injecting;             /* periods with injection on */
    float i_sq, i_sq_twin;       /* squared current vector [A^2] */
    float n;                     /* periods summed */
    float starting;              /* of them, periods of the start sequence: angle errors read 0 */
} sums_t;

/* Where a scenario begins. */
typedef struct {
    float omega_m;   /* shaft speed, mechanical [rad/s] */
    float theta_e;   /* electrical angle [rad] */
    float theta_err; /* truth minus the estimators' first angle [rad] */
    float k_s;       /* first weight */
    int32_t seek;    /* 1: speed and angle are not known, the drive runs its start sequence */
    int32_t reserved;
} start_t;

typedef struct {
    start_t start;
    drive_params_t control;
    sensor_params_t sensor;
    plant_params_t plant;
    profile_t profile;
    chain_t drive; /* the drive under test */
    chain_t twin;  /* the same controller fed by the true angle, injection off */
    profile_state_t now;
    sums_t sums;
    float omega_scale;   /* electrical rad/s per mechanical rad/s: pole pairs */
    float i_trip;        /* over-current limit, peak [A] */
    float err_limit;     /* [rad] */
    float tau_1, dev_1;  /* torque and deviation of the last period [N m] */
    float inv_stick;     /* above 0: the load only resists, fully from 1 / inv_stick on [s/rad] */
    int32_t err_periods; /* periods in a row the error may stay beyond its limit */
    int32_t err_count;
    int32_t k;         /* period */
    int32_t k_end;     /* the scenario's length in periods */
    int32_t sensored;  /* 1: the drive under test is itself fed by the true angle */
    int32_t with_twin; /* 0: no twin, deviations read 0 */
    int32_t lost;      /* LOST_* bits; a lost drive is not advanced any more */
    uint32_t seed;     /* of the measurement noise */
} sim_t;

/* Vector instructions, each set including those before. */
enum { SIMD_NONE = 0, SIMD_AVX2 = 1, SIMD_AVX512 = 2 };

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

/* What a critic may see, see sim_truth; signed quantities are taken in the direction of motion. */
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

/* Puts n drives at the start their own start_t describes, without current. */
void sim_start(sim_t *s, int32_t n);

/* Advances n drives by up to `periods` periods each with the weight k_s_ref[i] (one a drive), then
 * reads the signals of drive i into obs[i * SIGNAL_N]. Drives that are lost or at their end stay.
 * simd: the most that may be used of SIMD_*; threads: likewise. Results depend on neither. */
void sim_run(sim_t *s, int32_t n, int32_t periods, int32_t simd, int32_t threads,
             const float *k_s_ref, float *obs);

/* TRUTH_N numbers of each of n drives times scale[TRUTH_N], limited to +-bound (NaN to -bound), into
 * the first of the `columns` of each row of out. u_dc: the nominal voltage [V]. */
void sim_truth(const sim_t *s, int32_t n, float u_dc, const float *scale, float bound, float *out,
               int32_t columns);

/* Most of SIMD_* that this machine has. */
int32_t sim_simd(void);

/* What the controllers of n drives are about to be given in the coming period; k_s_ref is 0. */
void sim_inputs(const sim_t *s, int32_t n, drive_in_t *in);

/* One drive, one row of TRACE_N numbers a period into out; returns the periods advanced. */
int32_t sim_trace(sim_t *s, int32_t periods, float k_s_ref, double *out);

/* Currents [A] over n flux linkages (psi[2 j], psi[2 j + 1]) [Vs]. */
void flux_map_currents(const flux_map_t *p, int32_t bridge, const double *psi, double *i,
                       int32_t n);

/* The machine alone over n periods under u[3 j]: u_alpha, u_beta [V], tau_load [N m]; rows of seven
 * (i_d, i_q, psi_d, psi_q, tau, omega_m, theta_e unwrapped) at j = 0 ... n into out. */
void plant_run(const plant_params_t *p, plant_state_t *x, const double *u, double *out, int32_t n);

/* cos_e, sin_e, currents and torque from theta_e, flux and speed. */
void plant_start(const plant_params_t *p, plant_state_t *x);

#endif
