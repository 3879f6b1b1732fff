/* Gains that a decision sets besides k_s, of simulated drives. */
#ifndef SENSORLESS_SIM_GAINS_H
#define SENSORLESS_SIM_GAINS_H

#include "drive/gains.h"
#include "sim.h"

/* Gains of one drive. */
typedef struct {
    drive_params_t design;       /* the drive's parameters with static gains */
    uint32_t n;                  /* gains, 1 ... GAIN_N */
    uint32_t which[GAIN_N];      /* GAIN_* of each, rising */
    gain_limits_t limit[GAIN_N]; /* of each */
    float value[GAIN_N];         /* in force */
    float wanted[GAIN_N];        /* values of this decision; what is out of bounds is clipped */
} sim_gains_t;

/* Brings the gains of n drives into force that come before a period, counted from 0, of a decision
 * of `periods`: one before each but the first, and all that are left before the last, as
 * gain_schedule_step has it. No drive moves. Returns whether there were any. gains: 0 for none. */
int sim_set_due(sim_t *s, sim_gains_t *gains, int32_t n, int32_t period, int32_t periods);

/* lock_bounds for the design, which has no inline functions: bounds at the amplitude u [V]. */
void sim_lock_bounds(lock_params_t *p, float u);

#endif
