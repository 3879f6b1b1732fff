/* Is the drive integrated correctly? A check with voltage pulses at rest, for the first power-up.
 *
 * Instead of drive_step, call bring_up_step every PWM period and apply its voltage in the same way,
 * until x->phase is BRING_UP_DONE; then read x->fault. The shaft must stand still. Nothing is
 * controlled, so no wrong sign can make a loop unstable, and a current beyond i_stop ends the check.
 *
 *   REST   no voltage: no current may flow
 *   PROBE  pulses of one period along alpha and beta, both ways. The current must step between the
 *          first and the second sample after the one that commanded the pulse; where it steps
 *          instead shows the delay. The steps along both axes are a matrix; for a salient machine
 *          with the right wiring it is symmetric and positive, and each wrong sign or swapped pair
 *          of phases turns or mirrors it in its own way
 *   PUSH   pulses along the d axis that PROBE found, which make no torque. The rise shows the
 *          voltage in force over the commanded one. Then no voltage is commanded: what the current
 *          falls by, at two levels to tell it from resistance, is the voltage lost by dead time.
 *          The check itself compensates nothing. So if nothing is lost, somebody else compensates,
 *          and drive_step would do it a second time
 *
 * Nothing electrical shows the number of pole pairs: turn_count counts electrical turns while the
 * shaft turns a known number of times.
 */
#ifndef SENSORLESS_BRING_UP_H
#define SENSORLESS_BRING_UP_H

#include "bring_up_types.h"

#ifdef __cplusplus
extern "C" {
#endif

void bring_up_init(bring_up_state_t *x);

/* One period: currents i_a and i_b at k [A]; returns the voltage to apply over [k+1, k+2]. */
ab_t bring_up_step(const bring_up_params_t *p, bring_up_state_t *x, float i_a, float i_b);

void turn_begin(turn_count_t *x, float theta);

/* Takes in the angle [rad] of a period. */
void turn_count(turn_count_t *x, float theta);

/* Pole pairs, after the shaft has made shaft_turns, of either sign. */
int32_t turn_pole_pairs(const turn_count_t *x, float shaft_turns);

#ifdef __cplusplus
}
#endif

#endif
