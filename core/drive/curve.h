/* A quantity over the magnitude of the torque current: evenly spaced nodes, linear between them. */
#ifndef SENSORLESS_CURVE_H
#define SENSORLESS_CURVE_H

#include "frames.h"
#include "vector.h"

enum { CURVE_N = 9 }; /* nodes of every curve */

typedef struct {
    float y[CURVE_N]; /* value at |i_q| = j / inv_step */
} curve_t;

/* Position of |i_q| among the nodes, common to all curves. */
typedef struct {
    int j;   /* left node, 0 ... CURVE_N - 2 */
    float f; /* fraction between node j and j + 1 */
} curve_pos_t;

/* inv_step: nodes per ampere [1/A]. Beyond the last node, the last value applies. */
CORE_INLINE curve_pos_t curve_locate(float i_q, float inv_step) {
    float t = abs_f(i_q * inv_step);          /* not below 0, whatever was damaged */
    if (SHORTCUT(t < (float)(CURVE_N - 2))) { /* before the last interval: no ends to look at */
        int left = (int)t;
        curve_pos_t inside = {left, t - (float)left};
        return inside;
    }
    t = min_f(t, (float)(CURVE_N - 1)); /* NaN: the last */
    /* the shortcut leaves no other */
    int j = SHORTCUT(1) || (int)t > CURVE_N - 2 ? CURVE_N - 2 : (int)t;
    curve_pos_t pos = {j, t - (float)j};
    return pos;
}

/* The values at both ends of an interval. */
typedef struct {
    float y0;
    float y1;
} curve_ends_t;

CORE_INLINE curve_ends_t curve_ends(const curve_t *c, curve_pos_t pos) {
    curve_ends_t x = {PICK_F(c->y, 0, pos.j, CURVE_N - 1), PICK_F(c->y, 1, pos.j, CURVE_N - 1)};
    return x;
}

CORE_INLINE float curve_at(const curve_t *c, curve_pos_t pos) {
    curve_ends_t x = curve_ends(c, pos);
    return x.y0 + pos.f * (x.y1 - x.y0);
}

/* d(|i_q| y) / d|i_q|: turns an apparent inductance into the incremental one. */
CORE_INLINE float curve_incremental(const curve_t *c, curve_pos_t pos) {
    curve_ends_t x = curve_ends(c, pos);
    return x.y0 + ((float)pos.j + 2.0f * pos.f) * (x.y1 - x.y0);
}

#endif
