/* Sine, cosine and hyperbolic tangent in plain float32 arithmetic.
 *
 * These polynomials replace the C library's functions, because libraries differ in the last bit and
 * this code must give the same bits on the host and on the target.
 */
#ifndef SENSORLESS_TRIG_H
#define SENSORLESS_TRIG_H

#include <stdint.h>

#include "frames.h"

/* 1.5 * 2^23: a float near it has no fraction, and its last bits are those of the integer that is
 * its distance. */
#define ROUNDER_F 12582912.0f

/* Wraps an angle of at most some thousand turns to [-pi, pi]. */
CORE_INLINE float wrap_far(float x) {
    float turns = x * (0.5f / PI_F) + ROUNDER_F;
    return x - (turns - ROUNDER_F) * TWO_PI_F;
}

/* Cosine and sine of x [rad], |x| <= 8; absolute error below 2e-7.
 * Reduction to a quarter turn with pi/2 split in two floats, then minimax polynomials of degree 7
 * and 8 (coefficients of the Cephes library's sinf and cosf). A sum with ROUNDER_F rounds to the
 * nearest number of quarter turns, without a conversion, which C does not define for every float.
 * Beyond the range the result is still finite for finite x up to 1e9. */
CORE_INLINE rot_t rot_of(float x) {
    float t = x * 0.636619772367581f + ROUNDER_F;
    uint32_t n = bits_of(t);
    float k = t - ROUNDER_F;
    float r = (x - k * 1.5707963705062866f) + k * 4.371139000186241e-8f;
    float r2 = r * r;
    float s = r + r * r2 * ((-1.9515295891e-4f * r2 + 8.3321608736e-3f) * r2 - 1.6666654611e-1f);
    float c =
        1.0f - 0.5f * r2 +
        r2 * r2 *
            ((2.443315711809948e-5f * r2 - 1.388731625493765e-3f) * r2 + 4.166664568298827e-2f);
    float sc = (n & 1U) != 0U ? s : c;
    float ss = (n & 1U) != 0U ? c : s;
    rot_t y = {((n + 1U) & 2U) != 0U ? -sc : sc, (n & 2U) != 0U ? -ss : ss};
    return y;
}

/* r turned by a small angle x [rad]: reuses one sine-cosine pair; Taylor series to x^3 and x^4, whose
 * remainder is below |x|^5 / 120: 1e-5 at 0.25, 6e-4 at 0.6, 2e-2 at 1.2. */
CORE_INLINE rot_t rot_turn(rot_t r, float x) {
    float x2 = x * x;
    float s = x - x * x2 * 0.166666667f;
    float c = 1.0f - 0.5f * x2 + x2 * x2 * 0.0416666667f;
    rot_t y = {r.c * c - r.s * s, r.s * c + r.c * s};
    return y;
}

/* Angle of a vector in [-pi, pi], error below 1e-6; 0 for the zero vector. The octant, then the
 * polynomial of the Cephes library's atanf. */
CORE_INLINE float angle_of(ab_t x) {
    float a = abs_f(x.a);
    float b = abs_f(x.b);
    float t = min_f(a, b) / max_f(max_f(a, b), 1.0e-30f);
    int far = t > 0.414213562373095f; /* tan(pi / 8) */
    float v = far ? (t - 1.0f) / (t + 1.0f) : t;
    float z = v * v;
    float y = ((8.05374449538e-2f * z - 1.38776856032e-1f) * z + 1.99777106478e-1f) * z;
    y = v + v * z * (y - 3.33329491539e-1f) + (far ? 0.25f * PI_F : 0.0f);
    y = b > a ? 0.5f * PI_F - y : y;
    y = x.a < 0.0f ? PI_F - y : y;
    return x.b < 0.0f ? -y : y;
}

/* tanh(x): continued fraction of order 7/6, limited to [-1, 1]; absolute error below 1e-4 (worst
 * near |x| = 5), near 1e-6 for |x| < 3. Odd, exactly +-1 for large |x|, monotone
 * within 3e-7. */
CORE_INLINE float tanh_f(float x) {
    float y = bound_f(x, 5.0f);
    float y2 = y * y;
    float num = y * (135135.0f + y2 * (17325.0f + y2 * (378.0f + y2)));
    float den = 135135.0f + y2 * (62370.0f + y2 * (3150.0f + y2 * 28.0f));
    return bound_f(num / den, 1.0f);
}

#endif
