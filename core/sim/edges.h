/* Averaged inverter that takes the currents at its switching edges into account.
 *
 * inverter_voltage uses the current at the sample for the whole period. For a small current, that
 * is wrong in two ways: injection and pulses move it through zero between the edges, and the dead
 * time of one edge can stop a current but not reverse it. Here the pulses of carrier.h, symmetric
 * about the middle of the period, and the slope of the current give its value at both edges of each
 * leg; the dead-time voltage falls to zero linearly below the current that the dead time of a
 * period can stop, 2/3 gamma u_dc t_d, gamma the leg's own inverse inductance.
 *
 * Leg j rises at t_j = T (1/2 - u_j / u_dc) / 2. Until then, each leg m above it has put T (u_m -
 * u_j)/2 volt-seconds on its phase; the same follows after the fall at T - t_j.
 */
#ifndef SENSORLESS_EDGES_H
#define SENSORLESS_EDGES_H

#include "inverter.h"
#include "plant.h"

typedef struct {
    const sensor_params_t *p;
    plant_slope_t slope;
    legs_t leg; /* [V] */
    ab_t i;     /* at the sample [A] */
    float u_dc; /* [V] */
    float T_s;  /* period [s] */
} edges_t;

/* Mean voltage of leg j in the direction (n_a, n_b) of its phase, with voltage u among the others
 * u_1 and u_2, whose phases follow at 120 and 240 degrees. */
CORE_INLINE float edges_leg(const edges_t *e, float u, float u_1, float u_2, float n_a, float n_b) {
    const plant_slope_t *g = &e->slope;
    float g_a = g->aa * n_a + g->ab * n_b;
    float g_b = g->ab * n_a + g->bb * n_b;
    float gamma = g_a * n_a + g_b * n_b;
    float above_1 = max_f(u_1 - u, 0.0f);
    float above_2 = max_f(u_2 - u, 0.0f);
    /* volt-seconds of the others before the edge: along the phase, and across it */
    float before_n = -0.166666667f * e->T_s * (above_1 + above_2);
    float before_t = 0.333333333f * e->T_s * HALF_SQRT3_F * (above_1 - above_2);
    float v_a = before_n * n_a - before_t * n_b;
    float v_b = before_n * n_b + before_t * n_a;
    ab_t whole = legs_voltage(e->leg);
    float first = g_a * v_a + g_b * v_b;
    float all = e->T_s * (g_a * whole.a + g_b * whole.b);
    float drift = g->drift_a * n_a + g->drift_b * n_b;
    float t = 0.5f * e->T_s * clamp_f(0.5f - u / max_f(e->u_dc, 1.0f), 0.0f, 1.0f);
    float i = e->i.a * n_a + e->i.b * n_b;
    float rise = i + first + drift * t;
    float fall = i + all - first + drift * (e->T_s - t);
    float u_dt = e->u_dc * e->p->dead_time_share;
    float inv = 1.0f / max_f(0.666666667f * gamma * u_dt * e->T_s, 1.0e-9f);
    float way = 0.5f * (clamp_f(rise * inv, -1.0f, 1.0f) + clamp_f(fall * inv, -1.0f, 1.0f));
    float half = 0.5f * e->u_dc;
    float y = clamp_f(u - u_dt * way, -half, half);
    return y - e->p->u_on * way - e->p->u_skew * y / max_f(e->u_dc, 1.0f);
}

/* Mean stator voltage of a period [V] under the command u [V], from the current i [A] at its
 * start. */
CORE_INLINE ab_t edges_voltage(const sensor_params_t *p, plant_slope_t slope, ab_t u, float u_dc,
                               float T_s, ab_t i) {
    legs_t leg = inverter_legs(u);
    edges_t e = {p, slope, leg, i, u_dc, T_s};
    legs_t y = {
        edges_leg(&e, leg.a, leg.b, leg.c, 1.0f, 0.0f),
        edges_leg(&e, leg.b, leg.c, leg.a, -0.5f, HALF_SQRT3_F),
        edges_leg(&e, leg.c, leg.a, leg.b, -0.5f, -HALF_SQRT3_F),
    };
    return legs_voltage(y);
}

#endif
