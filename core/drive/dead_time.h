/* The voltage that dead time takes by the sign of each phase current: what the drive compensates, and
 * what the inverter of core/sim loses. */
#ifndef SENSORLESS_DEAD_TIME_H
#define SENSORLESS_DEAD_TIME_H

#include "frames.h"

/* Share of the full dead-time voltage at current i of a leg [A], -1 ... 1; inv_i: slope of the
 * transition through zero current [1/A]. */
CORE_INLINE float dead_time_at(float i, float inv_i) { return clamp_f(i * inv_i, -1.0f, 1.0f); }

/* Voltage u with the slope u_i through zero current [V/A] less voltage v with v_i, both with the
 * sign of the current i of a leg [V]; u, v at least 0. */
CORE_INLINE float dead_time_difference(float u, float u_i, float v, float v_i, float i) {
    float size = min_f(abs_f(i) * u_i, u) - min_f(abs_f(i) * v_i, v);
    return times_sign_f(size, i);
}

/* Dead-time voltage of three legs at the current i_ab, to be added to the command [V]; u_dt: that
 * of one leg [V]. */
CORE_INLINE ab_t dead_time_voltage(float u_dt, float inv_i, ab_t i_ab) {
    float i_b = phase_b(i_ab);
    float i_c = phase_c(i_ab);
    return legs_to_stator(u_dt, dead_time_at(i_ab.a, inv_i), dead_time_at(i_b, inv_i),
                          dead_time_at(i_c, inv_i));
}

/* Voltage that a compensation u adds beyond a loss v [V], both of a leg, with slopes u_i and v_i
 * through zero current [V/A]. */
CORE_INLINE ab_t dead_time_excess(float u, float u_i, float v, float v_i, ab_t i_ab) {
    float i_b = phase_b(i_ab);
    float i_c = phase_c(i_ab);
    return legs_to_stator(1.0f, dead_time_difference(u, u_i, v, v_i, i_ab.a),
                          dead_time_difference(u, u_i, v, v_i, i_b),
                          dead_time_difference(u, u_i, v, v_i, i_c));
}

#endif
