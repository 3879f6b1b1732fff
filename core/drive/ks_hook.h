/* The schedule alone, for a drive that has its own observers and its own blend.
 *
 * Call ks_hook_init once, then ks_hook_step every PWM period with what the drive knows; it returns
 * the weight k_s of injection, limited in slope. Besides ks_hook.c it needs ks_schedule.c, ks_table.c
 * and the table. Of a table's axes it knows speed, torque current, disagreement, acceleration and
 * k_s; a table with others is refused, as if it were damaged: the built-in rule decides.
 */
#ifndef SENSORLESS_KS_HOOK_H
#define SENSORLESS_KS_HOOK_H

#include "ks_schedule.h"

typedef struct {
    ks_schedule_params_t schedule;
    signal_params_t signal;
    float k_s_step;   /* largest change of k_s per period */
    float omega_full; /* electrical speed of the Q15 number 1 [rad/s] */
    float i_full;     /* torque current of the Q15 number 1 [A] */
    float omega_most; /* largest plausible electrical speed [rad/s] */
    float i_most;     /* largest plausible torque current [A] */
} ks_hook_params_t;

typedef struct {
    ks_schedule_state_t schedule; /* its `fault` has KS_FAULT_* bits */
    signal_state_t signal;
    float k_s; /* weight in force */
} ks_hook_state_t;

#ifdef __cplusplus
extern "C" {
#endif

/* Returns KS_OK or KS_BAD_*; the hook works in either case. */
int ks_hook_init(const ks_hook_params_t *p, ks_hook_state_t *x);

/* k_s of this period from the speed estimate in use [rad/s], electrical, the torque current i_q [A],
 * of the sign of the torque, and the angle of injection minus that of the other observer [rad], a
 * turn apart at most. If one of them is beyond omega_most, i_most or a turn and a half, or not
 * finite, all three are left out and the signals stay, with KS_FAULT_INPUT. Damaged signals begin
 * anew from this period's inputs, with the same bit. */
float ks_hook_step(const ks_hook_params_t *p, ks_hook_state_t *x, float omega, float i_q,
                   float difference);

/* The same in Q15: 1 is omega_full, i_full and half a turn; so differences of angles in the same
 * format wrap by themselves. Returns 0 ... 0x7FFF, which is exactly 1. */
int16_t ks_hook_step_q15(const ks_hook_params_t *p, ks_hook_state_t *x, int16_t omega, int16_t i_q,
                         int16_t difference);

#ifdef __cplusplus
}
#endif

#endif
