/* Errors of the two current sensors, learned while the shaft turns.
 *
 * Channels a and b read (1 + g_a) i_a + o_a and (1 + g_b) i_b + o_b. What both gains have in common
 * cannot be known without torque or a third sensor; their difference makes a current of negative
 * sequence, twice the speed in the rotor frame, and the offsets one that stands still in the stator
 * frame. The coupled observer sees both in its flux error:
 *
 *   gain    in the part along the auxiliary flux psi_a, which no steady angle error enters. Its
 *           slope g over the gain is known from the current, so the gain goes down the gradient of
 *           the square, less the mean, which errors of inductance make. A gain also makes
 *           injection's angle swing twice a turn, and that swing comes back along psi_a: where it
 *           outweighs the current, the gain is learned without injection alone
 *   offset  only in the part across, eps: along psi_a the flux takes it over. The observer follows
 *           what it sees, and eps leads the error of a steady offset by 0 to 180 degrees, so it is
 *           multiplied by the error's direction a quarter turn ahead
 *
 * Below two speeds, and at rest, the values stay as they are. docs/coupled-learning.md derives it.
 */
#ifndef SENSORLESS_SENSOR_MATCH_H
#define SENSORLESS_SENSOR_MATCH_H

#include <stdint.h>

#include "frames.h"

typedef struct {
    int32_t after;      /* periods before a test of the lock from which there is time to learn */
    float k_gain;       /* from the error along psi_a to the gain */
    float k_offset;     /* from the error across to the offset, times the auxiliary flux [A Vs] */
    float gain_max;     /* bound on the gain */
    float offset_max;   /* bound on an offset [A] */
    float err_max;      /* bound on both errors: larger ones are of the drive, not of sensors */
    float alpha;        /* low-pass of the mean error along psi_a: 1 - exp(-w T), T between uses */
    float omega_gain;   /* least speed to learn the gain at, electrical [rad/s] */
    float omega_offset; /* the same for the offset [rad/s] */
    float alone;        /* 1: the gain is learned without injection alone; 0: with it too */
} match_params_t;

typedef struct {
    float gain;     /* half the difference of the gains, (g_a - g_b) / 2 */
    float offset_a; /* of the channels [A] */
    float offset_b;
    float mean; /* low-passed error along psi_a */
} match_state_t;

/* Phase currents i_a, i_b [A] without the errors known so far, as a vector. */
CORE_INLINE ab_t match_correct(const match_state_t *x, float i_a, float i_b) {
    float a = i_a - x->gain * i_a - x->offset_a;
    float b = i_b + x->gain * i_b - x->offset_b;
    return phases_to_ab(a, b);
}

#define MATCH_ALONE 0.01f /* weight at or below which injection does not turn the angle */

/* Learns the gain, if `now`. i_ab: corrected sample [A]; r: direction of the estimate; aux:
 * auxiliary flux [Vs], inv: 1 over its square; L_d, L_qq: incremental inductances [H]; along: flux
 * error along aux, over aux; omega: speed, electrical [rad/s]; k_s: weight of injection. */
CORE_INLINE void match_gain(const match_params_t *p, match_state_t *x, int now, ab_t i_ab, rot_t r,
                            dq_t aux, float inv, float L_d, float L_qq, float along, float omega,
                            float k_s) {
    if (SHORTCUT(!now)) {
        return;
    }
    ab_t per_gain = {i_ab.a + INV_SQRT3_F * i_ab.b, INV_SQRT3_F * i_ab.a - i_ab.b};
    dq_t n = ab_to_dq(per_gain, r);
    float slope = inv * (L_d * n.d * aux.d + L_qq * n.q * aux.q);
    float swing = bound_f(along - x->mean, p->err_max);
    int clear = p->alone * k_s <= MATCH_ALONE;
    float k = clear && abs_f(omega) >= p->omega_gain ? p->k_gain : 0.0f;
    float gain = bound_f(x->gain + k * slope * swing, p->gain_max);
    float mean = x->mean + p->alpha * (along - x->mean);
    x->gain = now ? gain : x->gain;
    x->mean = now ? mean : x->mean;
}

/* Learns the offsets, if `now`; eps: flux error across aux, over aux; the rest as in match_gain. */
CORE_INLINE void match_offset(const match_params_t *p, match_state_t *x, int now, rot_t r, dq_t aux,
                              float inv, float eps, float omega) {
    if (SHORTCUT(!now)) {
        return;
    }
    dq_t mirrored = {aux.d, -aux.q};
    ab_t lead = dq_to_ab(mirrored, r);
    float k = abs_f(omega) >= p->omega_offset ? times_sign_f(p->k_offset, omega) : 0.0f;
    float step = k * inv * bound_f(eps, p->err_max);
    float to_b = HALF_SQRT3_F * lead.b - 0.5f * lead.a;
    float a = bound_f(x->offset_a + step * lead.a, p->offset_max);
    float b = bound_f(x->offset_b + step * to_b, p->offset_max);
    x->offset_a = now ? a : x->offset_a;
    x->offset_b = now ? b : x->offset_b;
}

#endif
