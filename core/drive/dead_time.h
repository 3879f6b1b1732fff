/* The voltage that dead time takes, or that compensates it. */
#ifndef SENSORLESS_DEAD_TIME_H
#define SENSORLESS_DEAD_TIME_H

#include "frames.h"

/* Share of the full dead-time voltage at a leg's current [A], -1 ... 1; inv_i: slope of its
 * transition through zero current [1/A]. */
CORE_INLINE float dead_time_share(float i, float inv_i) { return clamp_f(i * inv_i, -1.0f, 1.0f); }

/* Stator frame, without what is common to all legs. */
CORE_INLINE ab_t dead_time_to_ab(float u, float a, float b, float c) {
    ab_t y = {u * 0.333333333f * (2.0f * a - b - c), u * INV_SQRT3_F * (b - c)};
    return y;
}

/* Dead-time voltage of three legs for the current i_ab, to be added to the command [V]; u_dt: of a
 * leg [V]. */
CORE_INLINE ab_t dead_time_voltage(float u_dt, float inv_i, ab_t i_ab) {
    float i_b = -0.5f * i_ab.a + HALF_SQRT3_F * i_ab.b;
    float i_c = -0.5f * i_ab.a - HALF_SQRT3_F * i_ab.b;
    return dead_time_to_ab(u_dt, dead_time_share(i_ab.a, inv_i), dead_time_share(i_b, inv_i),
                           dead_time_share(i_c, inv_i));
}

/* What a compensation of slope inv_i puts beyond what legs of slope inv_i_true take [V]. */
CORE_INLINE ab_t dead_time_excess(float u_dt, float inv_i, float inv_i_true, ab_t i_ab) {
    float i_b = -0.5f * i_ab.a + HALF_SQRT3_F * i_ab.b;
    float i_c = -0.5f * i_ab.a - HALF_SQRT3_F * i_ab.b;
    return dead_time_to_ab(u_dt,
                           dead_time_share(i_ab.a, inv_i) - dead_time_share(i_ab.a, inv_i_true),
                           dead_time_share(i_b, inv_i) - dead_time_share(i_b, inv_i_true),
                           dead_time_share(i_c, inv_i) - dead_time_share(i_c, inv_i_true));
}

#endif
