/* A drive in open loop for commissioning: it applies test commands and records what it measures.
 *
 * No estimator runs. The drive's own angle is the direction of its command. A current is set by the
 * shipped current control in the frame of that angle, with gains that the caller chooses. Commands
 * act one period after the sample at which they start, as in the drive.
 */
#ifndef SENSORLESS_COMMISSION_H
#define SENSORLESS_COMMISSION_H

#include "sim.h"

enum { COMMAND_VOLTAGE = 0, COMMAND_CURRENT = 1 };

/* A vector that runs from `from` to `to` in equal steps, in a direction that starts at theta and
 * turns at a speed that runs from omega_0 to omega_1 as half a cosine wave. */
typedef struct {
    int32_t kind; /* COMMAND_* */
    int32_t n;    /* most periods */
    float from;   /* magnitude at the start, of either sign [V] or [A] */
    float to;
    float theta;   /* electrical [rad] */
    int32_t go_on; /* 1: start at the angle that the last command ended at instead */
    float omega_0; /* electrical [rad/s] */
    float omega_1;
    float i_end; /* above 0: ends when the current along the vector has this size [A] */
    float
        damp; /* of a current: lowers the speed by this times the part of the voltage along it that
                  * is not slow, which follows the torque, so that the rotor does not swing
                  * [rad/(s V)] */
    float follow; /* share of a change that the slow part takes up in a period */
    int32_t reserved;
} command_t;

/* Columns of a row, one per sampling instant k. */
enum {
    COMMISSION_SEGMENT = 0, /* index of the command */
    COMMISSION_U_ALPHA,     /* commanded for [k, k+1], stator frame [V] */
    COMMISSION_U_BETA,
    COMMISSION_U_DC,  /* measured at k [V] */
    COMMISSION_I_A,   /* measured at k [A] */
    COMMISSION_I_B,   /* of phase b */
    COMMISSION_THETA, /* the drive's own angle at k [rad] */
    COMMISSION_OMEGA, /* and its speed, electrical [rad/s] */
    COMMISSION_N
};

/* Runs n commands one after the other and writes a row of COMMISSION_N numbers per period, which
 * needs room for the sum of their n. Stops at a measured current above i_stop [A]. Returns the
 * number of rows. */
int32_t commission_run(sim_t *s, const command_t *c, int32_t n, float i_stop, double *out);

#endif
