/* Rules for code that also runs as vector code.
 *
 * The simulation compiles a period a second time with CORE_VECTOR, for many drives side by side,
 * and must give the same bits (core/sim/block.h). Loops over drives become vector instructions only
 * if all drives take the same path:
 *   - a choice is a select (x ? a : b), not a jump;
 *   - an element of an array is read by pick_f or PICK_F, not by an index;
 *   - code for only some drives is in `if (SCALAR_ONLY(condition))`, which is never true in vector
 *     code; batch_fits of core/sim/batch.c must keep drives with that condition out;
 *   - `if (SHORTCUT(condition))` leads round work that would change nothing; vector code does it.
 * Firmware does not define CORE_VECTOR: there, all of this is plain C.
 */
#ifndef SENSORLESS_VECTOR_H
#define SENSORLESS_VECTOR_H

#include "compiler.h"

#ifdef CORE_VECTOR
#define SCALAR_ONLY(condition) 0
#define SHORTCUT(condition) 0
#else
#define SCALAR_ONLY(condition) (condition)
#define SHORTCUT(condition) CORE_LIKELY(condition)
#endif

/* y[j] of n values. */
CORE_INLINE float pick_f(const float *y, int j, int n) {
#ifdef CORE_VECTOR
    float x = y[0];
    for (int i = 1; i < n; i++) {
        float next = y[i]; /* read in any case: clang would choose between addresses */
        x = j >= i ? next : x;
    }
    return x;
#else
    (void)n;
    return y[j];
#endif
}

/* y[first + j] of an array, one of n values. As an element of an array, not behind a pointer, so that
 * all arrays of a structure that are read at j share one address. */
#ifdef CORE_VECTOR
#define PICK_F(y, first, j, n) pick_f((y) + (first), j, n)
#else
#define PICK_F(y, first, j, n) ((y)[(first) + (j)])
#endif

#endif
