/* Finding the rotor before control begins: shaft at rest or spinning, angle and polarity unknown.
 *
 *   QUIET   only after lost lock: the current of before is taken to zero
 *   CATCH   current held at zero; the sliding-mode observer's EMF shows whether the shaft spins
 *   FLY     it does: the EMF's direction gives angle and polarity, its rotation the signed speed;
 *           the observer's loop settles
 *   SCAN    it does not, or slowly: injection along alpha, then along beta. The responses are
 *           columns of the inverse inductance in the stator frame; their anisotropic part points
 *           along twice the rotor angle. So the axis is found at every angle, without
 *           machine parameters
 *   LOCK    the injection estimator settles on that axis
 *   POLE    current pulses along the axis, forwards and backwards with equal volt-seconds: the iron
 *           saturates in one of them, which draws more current (the flux map says which)
 *   SETTLE  the injection estimator settles again, turned by half a turn if the pole was south
 *
 * The sequence commands no torque: all currents are on the d axis or held at zero.
 */
#ifndef SENSORLESS_START_SEQUENCE_H
#define SENSORLESS_START_SEQUENCE_H

#include <stdint.h>

#include "hf_injection.h"
#include "sliding_mode.h"

/* Two bits or more lie between any two phases: one flipped bit is no phase, and is told as damage. */
enum {
    START_DONE = 0, /* the drive is in control */
    START_CATCH = 0x11,
    START_FLY = 0x22,
    START_SCAN = 0x33,
    START_LOCK = 0x44,
    START_POLE = 0x55,
    START_SETTLE = 0x66,
    START_QUIET = 0x77,
    START_STOPPED = 0x88 /* not in control any more, no voltage */
};

/* start_state_t.again: the pole that counts after lost lock if nothing tells. */
enum { START_FIRST = 0, START_SAME_POLE = 1, START_OTHER_POLE = 2 };

typedef struct {
    hfi_params_t hfi; /* both estimators, with faster loops than in normal operation */
    smo_params_t smo;
    float k_hold;      /* gain that holds the current at zero [V/A] */
    float alpha_e;     /* correction of the EMF that turns with its own speed, per period */
    float k_turn;      /* from the angle of that correction to the speed, per period [1/s] */
    float e_turn_sq;   /* square of the EMF below which its direction counts for less [V^2] */
    float e_fly;       /* EMF above which the shaft counts as spinning [V] */
    float omega_pole;  /* speed above which the EMF shows the pole after lost lock [rad/s] */
    float u_pulse;     /* voltage of a polarity pulse [V] */
    float i_pole;      /* forward minus backward peak at the right polarity, signed [A] */
    float i_pole_sure; /* least magnitude of that difference for a sure decision [A] */
    float i_quiet;     /* current below which QUIET ends [A] */
    int32_t n_quiet;   /* its most periods */
    int32_t n_catch;   /* periods of CATCH */
    int32_t n_fly;     /* periods of FLY */
    int32_t n_again;   /* the same after lost lock, when time without torque counts */
    int32_t n_scan;    /* periods of each half of SCAN */
    int32_t n_lock;    /* periods of LOCK and of SETTLE */
    int32_t n_rest;    /* periods at zero current before a pulse */
    int32_t n_pulse;   /* periods of a pulse, and as many to undo it; at least 2 */
    int32_t n_tries;   /* most pairs of pulses; then even an unsure difference decides */
} start_params_t;

typedef struct {
    int32_t phase; /* START_* */
    int32_t n;     /* periods in this phase */
    int32_t tries; /* pairs of pulses so far */
    int32_t again; /* START_FIRST, or after lost lock another; then the coupled observer drives */
    ab_t i_1;      /* sample k-1 [A] */
    ab_t i_2;      /* sample k-2 [A] */
    ab_t e_1;      /* EMF of period k-1 [V] */
    ab_t e_f;      /* EMF that turns with omega, corrected by that of each period [V] */
    ab_t axis;     /* sum of the anisotropic responses, along twice the rotor angle [A] */
    float omega;   /* electrical speed at which the EMF turns [rad/s] */
    float i_0;     /* d current before a pulse [A] */
    float i_pole;  /* forward minus backward peaks so far [A] */
} start_state_t;

/* Starts the sequence, with nothing measured yet. */
CORE_INLINE void start_begin(start_state_t *x) {
    ab_t zero = {0.0f, 0.0f};
    x->phase = START_CATCH;
    x->n = 0;
    x->tries = 0;
    x->again = 0;
    x->i_1 = zero;
    x->i_2 = zero;
    x->e_1 = zero;
    x->e_f = zero;
    x->axis = zero;
    x->omega = 0.0f;
    x->i_0 = 0.0f;
    x->i_pole = 0.0f;
}

/* Whether a number is a phase in which the drive is not in control. */
CORE_INLINE int start_is_phase(int32_t phase) {
    return phase > START_DONE && phase <= START_STOPPED && (phase & 15) == phase >> 4;
}

/* Enters a phase. */
CORE_INLINE void start_enter(start_state_t *x, int32_t phase) {
    x->phase = phase;
    x->n = 0;
}

/* e [V] turned by an angle x [rad]. */
CORE_INLINE ab_t start_turned(ab_t e, float x) {
    rot_t r = rot_of(x);
    ab_t y = {r.c * e.a - r.s * e.b, r.s * e.a + r.c * e.b};
    return y;
}

/* Follows the EMF, whose part of this period is e [V]: the mean of two in a row contains no
 * injection. Between periods it turns with its own speed, so it does not lag behind a shaft that
 * spins. The current of before hides the EMF: in QUIET the speed stays as it is. */
CORE_INLINE void start_emf(const start_params_t *p, start_state_t *x, ab_t e, float T_s) {
    ab_t was = start_turned(x->e_f, T_s * x->omega);
    ab_t now = {0.5f * (e.a + x->e_1.a), 0.5f * (e.b + x->e_1.b)};
    float across = was.a * now.b - was.b * now.a;
    float turn = across / max_f(was.a * was.a + was.b * was.b, p->e_turn_sq);
    x->omega += x->phase != START_QUIET ? p->k_turn * bound_f(turn, 1.0f) : 0.0f;
    x->e_f.a = was.a + p->alpha_e * (now.a - was.a);
    x->e_f.b = was.b + p->alpha_e * (now.b - was.b);
    x->e_1 = e;
}

/* Voltage that takes the current i_ab [A] to zero against the EMF, stator frame [V]: it acts from
 * one to two periods later. */
CORE_INLINE ab_t start_hold(const start_params_t *p, const start_state_t *x, ab_t i_ab, float T_s) {
    ab_t e = start_turned(x->e_f, 1.5f * T_s * x->omega);
    ab_t u = {
        e.a - 0.5f * p->k_hold * (i_ab.a + x->i_1.a),
        e.b - 0.5f * p->k_hold * (i_ab.b + x->i_1.b),
    };
    return u;
}

/* Adds one sample of SCAN; sign: that of the injection over [k-1, k]. The axis changes at n_scan; a
 * sample shows what was commanded two and three periods before. */
CORE_INLINE void start_scan(const start_params_t *p, start_state_t *x, ab_t i_ab, float sign) {
    float a = 0.25f * sign * (i_ab.a - 2.0f * x->i_1.a + x->i_2.a);
    float b = 0.25f * sign * (i_ab.b - 2.0f * x->i_1.b + x->i_2.b);
    int along_a = x->n >= 3 && x->n < p->n_scan + 2;
    int along_b = x->n >= p->n_scan + 3;
    x->axis.a += along_a ? a : (along_b ? -b : 0.0f);
    x->axis.b += along_a ? b : (along_b ? a : 0.0f);
}

/* Rotor axis found by SCAN [rad], in the one of its two directions that is nearer to theta. */
CORE_INLINE float start_axis(const start_state_t *x, float theta) {
    float found = 0.5f * angle_of(x->axis);
    return abs_f(wrap_pi(found - theta)) > 0.5f * PI_F ? wrap_pi(found + PI_F) : found;
}

/* Periods of each half of POLE: n_rest, n_pulse one way, n_pulse back. */
CORE_INLINE int32_t start_half(const start_params_t *p) { return p->n_rest + 2 * p->n_pulse; }

/* Periods of POLE: two halves, and until the sample after the last pulse. A command acts one period
 * later. */
CORE_INLINE int32_t start_pair(const start_params_t *p) { return 2 * start_half(p) + 2; }

/* Present direction of the pulse voltage: +1, -1, or 0 without a pulse. The second half of a pair
 * has the opposite sign. */
CORE_INLINE float start_pulse(const start_params_t *p, const start_state_t *x) {
    int second = x->n >= start_half(p);
    int32_t j = (second ? x->n - start_half(p) : x->n) - p->n_rest;
    float way = second ? -1.0f : 1.0f;
    way = j < p->n_pulse ? way : -way;
    return j >= 0 && j < 2 * p->n_pulse ? way : 0.0f;
}

/* Reads by how much a pulse of POLE moves the d current i_d [A]: the sample at its peak less the
 * mean of those before it and after it is undone. An EMF that is not known well moves both by the
 * same. */
CORE_INLINE void start_peak(const start_params_t *p, start_state_t *x, float i_d) {
    int32_t half = start_half(p);
    int32_t j = x->n - p->n_rest;
    j = j > 2 * p->n_pulse + 1 ? j - half : j;
    x->i_0 = j == 1 ? i_d : x->i_0;
    x->i_pole += j == p->n_pulse + 1 ? i_d : 0.0f;
    x->i_pole -= j == 2 * p->n_pulse + 1 ? 0.5f * (x->i_0 + i_d) : 0.0f;
}

#endif
