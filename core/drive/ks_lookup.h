/* Lookup in a table: its signals, their place in its grid, and the mean of the nodes there. */
#ifndef SENSORLESS_KS_LOOKUP_H
#define SENSORLESS_KS_LOOKUP_H

#include "ks_types.h"
#include "signals.h"

/* The float that has these bits. */
CORE_INLINE float float_of(uint32_t u) {
    union {
        uint32_t u;
        float f;
    } y;
    y.u = u;
    return y.f;
}

#define BITS_OF_INFINITY 0x7F800000U

/* Fills those of y[SIGNAL_N] that the table reads. Returns whether all of them are finite: x - x is
 * 0 if x is finite and NaN if not. */
CORE_INLINE int ks_read_axes(const ks_table_t *t, const signal_params_t *p, const signal_state_t *x,
                             float *y) {
    float dir = signals_direction(x);
    float zero = 0.0f;
    for (uint32_t a = 0; a < t->n_axes; a++) {
        uint32_t which = t->axis[a].signal;
        float v = signal_at(p, x, dir, which);
        y[which] = v;
        zero += v - v;
    }
    return zero == 0.0f;
}

/* Left node *j and fraction *f of a signal v at position pos (in nodes) of an axis, clipped at both
 * ends; if v is not finite, *f is NaN or the result 0, else it is 1. As unsigned numbers, the bits of
 * positive floats have the order of the floats, and those of infinity, NaN and negative floats are
 * larger: one comparison finds positions inside, one more those beyond the last node. */
CORE_INLINE int place(const ks_axis_t *x, float v, float pos, uint32_t *j, float *f) {
    if (bits_of(pos) < bits_of(x->top)) {
        int32_t left = (int32_t)pos;
        *j = (uint32_t)left;
        *f = pos - (float)left;
    } else if (bits_of(pos) <= BITS_OF_INFINITY) {
        *j = x->n - 2;
        *f = 1.0f;
        return bits_of(pos) < BITS_OF_INFINITY || v - v == 0.0f;
    } else {
        *j = 0;
        *f = v - v;
    }
    return 1;
}

/* Pointer to the j-th node value. */
CORE_INLINE const void *ahead(const void *v, uint32_t j, int q15) {
    return q15 ? (const void *)((const int16_t *)v + j) : (const void *)((const float *)v + j);
}

/* Value of a node, times 32767 if values have 16 bits. */
CORE_INLINE float node(const void *v, uint32_t j, int q15) {
    return q15 ? (float)((const int16_t *)v)[j] : ((const float *)v)[j];
}

CORE_INLINE float mix(float x, float y, float f) { return x + f * (y - x); }

/* Interpolation over the last 1, 2, 3 and 4 axes, from the first node of v on; f: fraction on each
 * axis, step: nodes from one node of an axis to the next. With nodes and fractions in [0, 1], every
 * mix is in [0, 1], even after rounding. */
CORE_INLINE float mix_1(const void *v, const float *f, int q15) {
    return mix(node(v, 0, q15), node(v, 1, q15), f[0]);
}

CORE_INLINE float mix_2(const void *v, const float *f, const uint32_t *step, int q15) {
    return mix(mix_1(v, f + 1, q15), mix_1(ahead(v, step[0], q15), f + 1, q15), f[0]);
}

CORE_INLINE float mix_3(const void *v, const float *f, const uint32_t *step, int q15) {
    return mix(mix_2(v, f + 1, step + 1, q15), mix_2(ahead(v, step[0], q15), f + 1, step + 1, q15),
               f[0]);
}

CORE_INLINE float mix_4(const void *v, const float *f, const uint32_t *step, int q15) {
    return mix(mix_3(v, f + 1, step + 1, q15), mix_3(ahead(v, step[0], q15), f + 1, step + 1, q15),
               f[0]);
}

/* Kept apart: inlined, it would cost every lookup that falls back. */
CORE_APART float safe_weight(void) { return 1.0f; }

/* The weight of a signal that is not finite; 1 if it is damaged. */
CORE_INLINE float fallback(const ks_table_t *t) {
    return CORE_LIKELY(bits_of(t->fallback) <= BITS_OF_ONE) ? t->fallback : safe_weight();
}

/* The weight from interpolated nodes. NaN, which a signal that is not finite causes, or a number
 * beyond [0, 1], from nodes damaged since the check, becomes the fallback. */
CORE_INLINE float weight(const ks_table_t *t, float x, int q15) {
    float k_s = q15 ? x * (1.0f / 32767.0f) : x;
    return CORE_LIKELY(bits_of(k_s) <= BITS_OF_ONE) ? k_s : fallback(t);
}

#endif
