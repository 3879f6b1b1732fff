/* Averaged two-level inverter and the current measurement. */
#ifndef SENSORLESS_INVERTER_H
#define SENSORLESS_INVERTER_H

#include "drive/control.h"
#include "noise.h"

typedef struct {
    float dead_time_share;     /* dead time / PWM period */
    float inv_i_zero;          /* slope of the dead-time voltage through zero current [1/A] */
    float gain_a, gain_b;      /* gain of the phase-current channels, 1 = exact */
    float offset_a, offset_b;  /* [A] */
    float noise_rms;           /* [A] */
    float lsb;                 /* resolution of the converter [A], above range / 2^30 */
    float inv_lsb;             /* 1 / lsb [1/A] */
    float range;               /* largest current that the converter can show [A] */
    float u_on;                /* mean threshold voltage of transistor and diode [V] */
    float u_skew;              /* the transistor's minus the diode's [V] */
    float ripple;              /* amplitude of the DC link's ripple over its mean */
    uint32_t ripple_phase;     /* of the ripple at period 0; 2^32 is a turn */
    uint32_t ripple_half_step; /* its advance per half period */
    int32_t carrier; /* 1: switching instants of a carrier, see carrier.h; 0: mean voltage */
    int32_t reserved;
} sensor_params_t;

/* Voltages of the three legs against the midpoint of the link [V]. */
typedef struct {
    float a, b, c;
} legs_t;

/* Leg voltages for the stator voltage u [V], with the common-mode voltage that centres them. */
CORE_INLINE legs_t inverter_legs(ab_t u) {
    float a = u.a;
    float b = phase_b(u);
    float c = phase_c(u);
    float mid = 0.5f * (max_f(a, max_f(b, c)) + min_f(a, min_f(b, c)));
    legs_t y = {a - mid, b - mid, c - mid};
    return y;
}

/* Ripple of the DC link over its mean voltage, `half` half periods after the start. */
CORE_INLINE float link_ripple(const sensor_params_t *p, int32_t half) {
    uint32_t phase = p->ripple_phase + (uint32_t)half * p->ripple_half_step;
    return p->ripple * rot_of((float)(int32_t)phase * (PI_F / 2147483648.0f)).c;
}

/* Stator voltage of three legs [V]. */
CORE_INLINE ab_t legs_voltage(legs_t leg) { return legs_to_stator(1.0f, leg.a, leg.b, leg.c); }

/* Mean stator voltage of a period [V]: dead time against the direction of each phase current i_ab
 * [A], legs limited to the link. */
CORE_INLINE ab_t inverter_voltage(const sensor_params_t *p, ab_t u, float u_dc, ab_t i_ab) {
    legs_t leg = inverter_legs(u);
    float u_dt = u_dc * p->dead_time_share;
    float half = 0.5f * u_dc;
    leg.a -= u_dt * dead_time_at(i_ab.a, p->inv_i_zero);
    leg.b -= u_dt * dead_time_at(phase_b(i_ab), p->inv_i_zero);
    leg.c -= u_dt * dead_time_at(phase_c(i_ab), p->inv_i_zero);
    leg.a = clamp_f(leg.a, -half, half);
    leg.b = clamp_f(leg.b, -half, half);
    leg.c = clamp_f(leg.c, -half, half);
    return legs_voltage(leg);
}

/* Rounds to the nearest step of the converter and limits to its range. Only positive numbers become
 * integers: gcc may replace the conversion to an integer and back by a truncation, which keeps the
 * sign of zero that an integer does not have. */
CORE_INLINE float sensor_quantise(const sensor_params_t *p, float i) {
    float n = clamp_f(i, -p->range, p->range) * p->inv_lsb;
    float steps = p->lsb * (float)(int32_t)(abs_f(n) + 0.5f);
    return n < 0.0f ? 0.0f - steps : steps;
}

/* Measured phase current of channel 0 (a) or 1 (b) at period k [A]. */
CORE_INLINE float sensor_read(const sensor_params_t *p, float i, float gain, float offset,
                              uint32_t seed, uint32_t k, uint32_t channel) {
    float noise = p->noise_rms * noise_normal(seed, 2U * k + channel);
    return sensor_quantise(p, gain * i + offset + noise);
}

#endif
