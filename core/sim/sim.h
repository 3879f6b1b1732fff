/* A drive with its machine, its sensored twin and the running sums of one decision.
 *
 * sim_t is plain old data: copying its bytes is a snapshot.
 */
#ifndef SENSORLESS_SIM_H
#define SENSORLESS_SIM_H

#include "drive/drive.h"
#include "inverter.h"
#include "plant.h"
#include "profile.h"

/* Why a drive counts as lost; bits of sim_t.lost. */
enum {
    LOST_ANGLE = 1,     /* angle error beyond err_limit for more than err_periods */
    LOST_CURRENT = 2,   /* over-current trip */
    LOST_NONFINITE = 4, /* a state is not finite */
    LOST_TWIN = 8       /* trips or runs away even with the true angle: not feasible */
};

typedef struct {
    drive_state_t x;
    plant_state_t y;
    ab_t u; /* command that acts over the next period [V] */
} chain_t;

/* Sums over the periods of one decision; divide by n. */
typedef struct {
    float tau, tau_sq;           /* torque [N m] and its square */
    float tau_lf_sq;             /* square of the two-sample mean, which has no injection */
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
    float starting;              /* of these, periods of the start sequence, as error 0 */
} sums_t;

/* Initial state of a scenario. */
typedef struct {
    float omega_m;   /* shaft speed, mechanical [rad/s] */
    float theta_e;   /* electrical angle [rad] */
    float theta_err; /* truth minus the estimators' first angle [rad] */
    float k_s;       /* weight to start with */
    int32_t seek;    /* 1: speed and angle are unknown; the drive runs its start sequence */
} start_t;

typedef struct {
    start_t start;
    drive_params_t control;
    sensor_params_t sensor;
    plant_params_t plant;
    profile_t profile;
    chain_t drive; /* the drive under test */
    chain_t twin;  /* the same controller on the true angle, without injection */
    profile_state_t now;
    sums_t sums;
    float omega_scale;   /* electrical rad/s per mechanical rad/s: pole pairs */
    float i_trip;        /* over-current limit, peak [A] */
    float omega_limit;   /* mechanical speed beyond which the twin has run away [rad/s] */
    float err_limit;     /* [rad] */
    float tau_1, dev_1;  /* torque and deviation of the last period [N m] */
    float inv_stick;     /* above 0: the load only resists, fully from 1 / inv_stick on [s/rad] */
    int32_t err_periods; /* periods in a row for which the error may exceed its limit */
    int32_t err_count;
    int32_t k;         /* period */
    int32_t k_end;     /* the scenario's length in periods */
    int32_t sensored;  /* 1: the drive under test itself runs on the true angle */
    int32_t with_twin; /* 0: no twin; deviations are 0 */
    int32_t lost;      /* LOST_* bits; a lost drive does not advance any more, but see go_on */
    uint32_t seed;     /* of the measurement noise */
    int32_t begun;     /* 1: the drive has been in control; a later start is one after lost lock */
    int32_t go_on;     /* 1: a lost drive advances to its end, without sums and further verdicts */
    int32_t k_lost;    /* periods lived when lost; 0 before */
} sim_t;

#endif
