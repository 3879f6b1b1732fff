/* What the check in bring_up.h consists of: parameters, state, faults. */
#ifndef SENSORLESS_BRING_UP_TYPES_H
#define SENSORLESS_BRING_UP_TYPES_H

#include <stdint.h>

#include "frames.h"

/* Bits of bring_up_state_t.fault. */
enum {
    BRING_UP_FAULT_CURRENT = 1, /* current beyond i_stop, or not finite: the check was cut short */
    BRING_UP_FAULT_MOVES = 2,   /* current without voltage: the shaft turns, or a sensor's offset */
    BRING_UP_FAULT_DEAF = 4,  /* hardly any current: PWM off, motor not connected, or wrong scale */
    BRING_UP_FAULT_DELAY = 8, /* voltage does not act one period after its sample: see delay */
    BRING_UP_FAULT_SIGN = 16, /* all currents, or all voltages, have the wrong sign */
    BRING_UP_FAULT_PHASES = 32,     /* phases swapped between PWM and current sensors: see wiring */
    BRING_UP_FAULT_CHANNEL = 64,    /* one current channel has the wrong sign: see wiring */
    BRING_UP_FAULT_SCALE = 128,     /* wrong scale of the voltage or a current: see scale */
    BRING_UP_FAULT_DEAD_TIME = 256, /* dead time is compensated already: see lost */
    BRING_UP_FAULT_STATE = 512,     /* damaged, or without bring_up_init: the check was cut short */
    BRING_UP_FAULT_WIRING = 1024 /* no swap and no sign explains the currents: a channel is dead */
};

/* What the steps of the current look like. */
enum {
    WIRING_RIGHT = 0,
    WIRING_SWAPPED_BC, /* phases b and c */
    WIRING_SWAPPED_AB, /* phases a and b */
    WIRING_SWAPPED_CA, /* phases c and a */
    WIRING_NEXT,       /* each current channel has the phase after its own: a has b */
    WIRING_PREVIOUS,   /* the phase before its own: a has c */
    WIRING_CHANNEL_A,  /* i_a has the wrong sign */
    WIRING_CHANNEL_B,  /* i_b has the wrong sign */
    WIRING_UNKNOWN,    /* none of these */
    WIRING_N
};

enum {
    BRING_UP_NONE = 0, /* bring_up_init has not run: a damaged state */
    BRING_UP_REST,
    BRING_UP_PROBE,
    BRING_UP_PUSH,
    BRING_UP_DONE
};

enum { BRING_UP_LAGS = 4 }; /* samples after the command in which a step is looked for */

typedef struct {
    float T_s;        /* PWM period [s] */
    float u_probe;    /* pulse of one period [V] */
    float u_push;     /* pulse along the d axis [V] */
    float L_d;        /* inductance of the counted periods of a rise [H] */
    float L_high;     /* inductance at the level after it, mean of both ways [H] */
    float L_low;      /* at the level of half the current [H] */
    float R_s;        /* [ohm] */
    float anisotropy; /* (L_q - L_d) / (L_q + L_d) */
    float u_lost;     /* voltage that a leg loses by dead time, 0: do not judge [V] */
    float i_rest;     /* most current without voltage [A] */
    float i_least;    /* least step of the current by a pulse [A] */
    float i_stop;     /* current that ends the check [A] */
    float delay_band; /* most difference of the delay from one period [periods] */
    float scale_band; /* most difference of the scale from 1 */
    float lopsided;   /* most share of the steps across their axes that is the same on both */
    float lost_least; /* least share of u_lost that has to be lost */
    int32_t n_rest;   /* periods of REST */
    int32_t n_probe;  /* pulses of PROBE, a multiple of 8 */
    int32_t n_gap;    /* periods from one pulse to the next, at least BRING_UP_LAGS + 2 */
    int32_t n_push;   /* periods of a rise, even, at least 2; the first one does not count */
    int32_t n_hold;   /* periods without voltage at each of the two levels, at least 2; likewise */
    int32_t n_cycles; /* pulses of PUSH, even */
} bring_up_params_t;

typedef struct {
    int32_t phase;  /* BRING_UP_REST ... BRING_UP_DONE */
    int32_t n;      /* periods in this phase */
    int32_t fault;  /* BRING_UP_FAULT_* bits */
    int32_t wiring; /* WIRING_* */
    float delay;    /* of the voltage after its sample [periods]; 1 is right */
    float scale;    /* voltage in force over the commanded one, times the current's scale */
    float lost;     /* voltage lost by dead time over u_lost */
    float R_s;      /* resistance, for comparison [ohm] */
    ab_t i_1;       /* sample k-1 [A] */
    ab_t along_a[BRING_UP_LAGS]; /* sums of the steps after pulses along alpha [A] */
    ab_t along_b[BRING_UP_LAGS]; /* and along beta [A] */
    rot_t d;                     /* d axis */
    float rise;                  /* sums over PUSH: change of the current in the rise [A] */
    float level_rise;            /* the current in the rise [A] */
    float fall[2];               /* its changes at the two levels [A] */
    float level[2];              /* the current at the two levels [A] */
} bring_up_state_t;

/* Counts electrical turns of the drive's own angle. */
typedef struct {
    float theta; /* last angle [rad] */
    float turns; /* since turn_begin, signed */
} turn_count_t;

#endif
