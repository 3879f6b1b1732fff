/* What a drive consists of: parameters, state, inputs and faults.
 *
 * The state is all in drive_state_t and the parameters are all in drive_params_t; there are no
 * globals and no allocation.
 */
#ifndef SENSORLESS_DRIVE_TYPES_H
#define SENSORLESS_DRIVE_TYPES_H

#include "blend.h"
#include "control.h"
#include "coupled_observer.h"
#include "curve.h"
#include "flux_observer.h"
#include "hf_injection.h"
#include "lock.h"
#include "signals.h"
#include "sliding_mode.h"
#include "start_sequence.h"

/* Bits of drive_state_t.fault. */
enum {
    FAULT_CURRENT = 1, /* a current sample was not finite, too large or too far from the last one */
    FAULT_U_DC = 2,    /* the DC-link voltage was not finite, too low or too high */
    FAULT_COMMAND = 4, /* speed reference, k_s or an argument of drive_init out of range */
    FAULT_POLE = 8,    /* the start sequence was not sure of the north pole */
    FAULT_OVER_CURRENT = 16, /* a current vector beyond the limit, or drive_trip: open the bridge */
    FAULT_LOCK = 32,         /* the estimate is not the rotor's, or the shaft stalls: lock.reason */
    FAULT_STOPPED = 64, /* no voltage any more, lost lock or state: start again with drive_init */
    FAULT_STATE = 128,  /* the state was damaged or never begun: a new start, no voltage at first */
    FAULT_ALL = 255     /* all of these */
};

/* What drive_init writes, and drive_trip after it: memory that was never begun holds neither. A period
 * does not write this word, so it cannot write over a trip that interrupts it; but one that mends a
 * damaged state does if it holds neither. */
enum { DRIVE_BEGUN = 0x1DEA5EED, DRIVE_TRIPPED = 0x5709BED1 };

/* What inputs of a period may be. */
typedef struct {
    float i_sample;  /* largest plausible sample of a phase current [A] */
    float i_over_sq; /* square of the largest current vector [A^2] */
    float i_step_sq; /* square of the largest change of the current vector in a period [A^2] */
    float u_dc_min;  /* least DC-link voltage that sets no fault [V] */
    float u_dc_max;  /* largest plausible DC-link voltage [V] */
    float omega;     /* largest speed reference, electrical [rad/s] */
    float u_out;     /* largest voltage of a component that the drive can compute [V] */
} guard_params_t;

typedef struct {
    float T_s;      /* PWM period [s] */
    float k_s_step; /* largest change of k_s per period */
    int estimator;  /* ESTIMATE_* of blend.h */
    guard_params_t guard;
    hfi_params_t hfi;
    smo_params_t smo;
    flux_params_t flux;
    coupled_params_t coupled;
    control_params_t control;
    signal_params_t signal;
    curve_t L_q;         /* apparent q inductance of the observer over |i_q| [H] */
    curve_t theta_cross; /* half the cross-coupling angle over |i_q|, for positive i_q [rad] */
    start_params_t start;
    lock_params_t lock;
} drive_params_t;

typedef struct {
    hfi_state_t hfi;
    emf_estimate_t emf; /* of the observer in use: sliding-mode, flux or coupled */
    smo_state_t smo;
    flux_state_t flux;
    coupled_state_t coupled;
    control_state_t control;
    signal_state_t signal;
    start_state_t start;
    lock_state_t lock;
    estimate_t est;  /* blended estimate at k */
    ab_t u_1;        /* voltage that acts over [k, k+1], stator frame [V] */
    ab_t u_2;        /* voltage that acted over [k-1, k] [V] */
    float theta_hfi; /* compensated angle of injection at k; coupled: est plus err_hfi [rad] */
    float theta_smo; /* angle of the observer in use at k; coupled: est plus eps [rad] */
    float k_s;       /* weight in force */
    int32_t begun;   /* DRIVE_BEGUN from drive_init on, DRIVE_TRIPPED from drive_trip on */
    int fault;       /* FAULT_* bits, kept until the caller clears them */
} drive_state_t;

typedef struct {
    float i_a; /* phase currents at k [A] */
    float i_b;
    float u_dc;      /* DC-link voltage [V] */
    float omega_ref; /* speed reference, electrical [rad/s] */
    float k_s_ref;   /* weight wanted, 0 ... 1 */
} drive_in_t;

#endif
