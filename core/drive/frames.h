/* Space vectors and the two frames of the drive.
 *
 * Amplitude-invariant (peak-valued) vectors. ab: stator frame alpha-beta, alpha on phase a.
 * dq: a rotor frame, d on the magnet flux. Angles are electrical [rad] in [-pi, pi]; an angle
 * error is always truth minus estimate, wrapped.
 *
 * Choices are selects, but for the short cuts that firmware takes, see vector.h.
 */
#ifndef SENSORLESS_FRAMES_H
#define SENSORLESS_FRAMES_H

#include <stdint.h>

#include "vector.h"

#define PI_F 3.14159265358979f
#define HALF_PI_F 1.57079632679490f
#define TWO_PI_F 6.28318530717959f
#define INV_SQRT3_F 0.577350269189626f
#define HALF_SQRT3_F 0.866025403784439f

typedef struct {
    float a; /* alpha */
    float b; /* beta */
} ab_t;

typedef struct {
    float d;
    float q;
} dq_t;

/* Unit vector of an angle. */
typedef struct {
    float c; /* cosine */
    float s; /* sine */
} rot_t;

CORE_INLINE float min_f(float x, float y) { return x < y ? x : y; }
CORE_INLINE float max_f(float x, float y) { return x > y ? x : y; }
CORE_INLINE float abs_f(float x) { return CORE_FABSF(x); }
CORE_INLINE float sign_f(float x) { return x < 0.0f ? -1.0f : 1.0f; }

/* x + n modulo 2^32: a damaged count may be the largest number, and is found after it counts. */
CORE_INLINE int32_t count_i(int32_t x, int32_t n) { return (int32_t)((uint32_t)x + (uint32_t)n); }

/* sign_f(y) x, without the product. */
CORE_INLINE float times_sign_f(float x, float y) { return y < 0.0f ? -x : x; }

/* x limited to [lo, hi]; NaN gives lo, so that a NaN never passes. */
CORE_INLINE float clamp_f(float x, float lo, float hi) {
    float y = x > lo ? x : lo;
    return y < hi ? y : hi;
}

/* Whether x is neither NaN nor infinite. */
CORE_INLINE int finite_f(float x) { return abs_f(x) <= 3.40282347e38f; }

/* x limited to [-limit, limit]; NaN gives -limit. */
CORE_INLINE float bound_f(float x, float limit) {
    if (SHORTCUT(abs_f(x) <= limit)) {
        return x;
    }
    float end = x > 0.0f ? limit : -limit;
    return abs_f(x) <= limit ? x : end;
}

/* x where |x| <= limit, else 0 (also for NaN and infinity): guards every measured input. */
CORE_INLINE float sane_f(float x, float limit) { return abs_f(x) <= limit ? x : 0.0f; }

/* Square root: the only library function in use; correctly rounded on every IEEE-754 machine, and a
 * single instruction (no call, no errno) with -fno-math-errno. */
CORE_INLINE float sqrt_f(float x) { return CORE_SQRTF(x); }

/* The bits of a float without breaking the aliasing rules. */
CORE_INLINE uint32_t bits_of(float x) {
    union {
        float f;
        uint32_t u;
    } y;
    y.f = x;
    return y.u;
}

#define BITS_OF_ONE 0x3F800000U /* as unsigned numbers, at most these: floats from 0 to 1 */

/* Wraps an angle in (-3 pi, 3 pi), such as a sum of two wrapped angles, to [-pi, pi]. */
CORE_INLINE float wrap_pi(float x) {
    if (SHORTCUT(abs_f(x) <= PI_F)) {
        return x;
    }
    float turn = x > 0.0f ? TWO_PI_F : -TWO_PI_F;
    return abs_f(x) <= PI_F ? x : x - turn;
}

/* Stator frame to a rotor frame at angle r (Park). */
CORE_INLINE dq_t ab_to_dq(ab_t x, rot_t r) {
    dq_t y = {r.c * x.a + r.s * x.b, r.c * x.b - r.s * x.a};
    return y;
}

/* Rotor frame at angle r to the stator frame (inverse Park). */
CORE_INLINE ab_t dq_to_ab(dq_t x, rot_t r) {
    ab_t y = {r.c * x.d - r.s * x.q, r.s * x.d + r.c * x.q};
    return y;
}

/* Two phase values with a + b + c = 0 to the stator frame (Clarke). */
CORE_INLINE ab_t phases_to_ab(float x_a, float x_b) {
    ab_t y = {x_a, INV_SQRT3_F * (x_a + 2.0f * x_b)};
    return y;
}

/* Phase values b and c of a vector with a + b + c = 0 (inverse Clarke); a is x.a. */
CORE_INLINE float phase_b(ab_t x) { return -0.5f * x.a + HALF_SQRT3_F * x.b; }
CORE_INLINE float phase_c(ab_t x) { return -0.5f * x.a - HALF_SQRT3_F * x.b; }

CORE_INLINE float norm_ab(ab_t x) { return sqrt_f(x.a * x.a + x.b * x.b); }

/* Stator voltage of three legs at u a, u b, u c; the part common to all legs drops out. */
CORE_INLINE ab_t legs_to_stator(float u, float a, float b, float c) {
    ab_t y = {u * 0.333333333f * (2.0f * a - b - c), u * INV_SQRT3_F * (b - c)};
    return y;
}

#endif
