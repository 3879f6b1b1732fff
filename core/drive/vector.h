/* The rule for code that also runs as vector code.
 *
 * The simulation compiles a period once more with CORE_VECTOR, for many drives side by side, and
 * has to give the same bits (core/sim/block.h). Loops over drives become vector instructions only
 * if one path serves all of them:
 *   - a choice is a select (x ? a : b), not a jump;
 *   - an element of an array is taken by pick_f, not by an index;
 *   - what only some drives do stands under `if (SCALAR_ONLY(condition))`, which is never true in
 *     vector code. Then batch_fits of core/sim/batch.c has to keep drives with that condition out.
 * Firmware does not define CORE_VECTOR: there, all of this is plain C.
 */
#ifndef SENSORLESS_VECTOR_H
#define SENSORLESS_VECTOR_H

#include "compiler.h"

#ifdef CORE_VECTOR
#define SCALAR_ONLY(condition) 0
#else
#define SCALAR_ONLY(condition) (condition)
#endif

/* y[j] of n values. */
CORE_INLINE float pick_f(const float *y, int j, int n) {
#ifdef CORE_VECTOR
    float x = y[0];
    for (int i = 1; i < n; i++) {
        x = i == j ? y[i] : x;
    }
    return x;
#else
    (void)n;
    return y[j];
#endif
}

#endif
