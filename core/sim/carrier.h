/* Inverter that switches at the instants of a triangular carrier.
 *
 * The carrier has the period of the control, with one voltage command per period (single update).
 * So the injection, whose sign changes every period, is at half the switching frequency, and every
 * sample is taken at a peak of the carrier, where all legs are low and symmetric pulses leave no
 * ripple. A leg is high for a share d = 1/2 + u_leg / u_dc of the period, around its middle; u_leg
 * has the common-mode voltage of the averaged inverter, so the linear range is the same.
 *
 * Dead time: around every edge of a leg, both its switches are off, from t_d / 2 before to t_d / 2
 * after it (hardware that delays each turn-on by t_d has the same pattern t_d / 2 later). Meanwhile
 * its diodes carry the current: from the lower rail if it flows out of the leg, to the upper rail
 * if it flows in. A current that reaches zero stays there until the leg is switched again, as long
 * as that needs a voltage between the rails. A leg at its limit does not switch at all.
 */
#ifndef SENSORLESS_CARRIER_H
#define SENSORLESS_CARRIER_H

#include "inverter.h"
#include "plant.h"

enum { PIECES_A_PERIOD = 13 }; /* most stretches of constant voltage in a period */

/* Columns of a row of carrier_run: time [s], stator voltage from this row on [V], then the
 * state. */
enum {
    CARRIER_T = 0,
    CARRIER_U_ALPHA,
    CARRIER_U_BETA,
    CARRIER_I_D,
    CARRIER_I_Q,
    CARRIER_PSI_D,
    CARRIER_PSI_Q,
    CARRIER_TAU,
    CARRIER_OMEGA_M,
    CARRIER_THETA_E, /* unwrapped [rad] */
    CARRIER_N
};

/* Advances the machine by one period under the command u [V], with m->n_sub Runge-Kutta steps from
 * one switching instant to the next. tau_load: [N m]. */
void carrier_advance(const sensor_params_t *p, const plant_params_t *m, plant_state_t *x, ab_t u,
                     float u_dc, double tau_load);

/* The same over n periods under the commands u[4 j]: u_alpha, u_beta, u_dc [V], tau_load [N m].
 * Writes a row of CARRIER_N numbers for every Runge-Kutta step, and one for the end, to out, which
 * needs room for n * PIECES_A_PERIOD * n_sub + 1 rows. Returns the number of rows. */
int32_t carrier_run(const sensor_params_t *p, const plant_params_t *m, plant_state_t *x,
                    const double *u, double *out, int32_t n);

#endif
