/* Finds out by computing, since no macro tells all of it. */
#include "arithmetic.h"

#include <float.h>

/* What the compiler says itself. */
#ifdef __FAST_MATH__
enum { FAST_MATH = 1 };
#else
enum { FAST_MATH = 0 };
#endif

/* 1 + 2^-12: its square needs 25 bits, and rounds to 1 + 2^-11. */
#define NEARLY_ONE 1.000244140625f
#define ITS_SQUARE 1.00048828125f
#define TINY 9.31322575e-10f /* 2^-30, lost in a sum with 1 */

/* Volatile numbers, so that nothing is computed by the compiler. */
static int is_fused(void) {
    volatile float a = NEARLY_ONE;
    volatile float b = ITS_SQUARE;
    float x = a;
    float y = b;
    return x * x - y != 0.0f;
}

static int is_wide(void) {
    volatile float a = 1.0f;
    volatile float b = TINY;
    float x = a;
    float y = b;
    return (x + y) - x != 0.0f;
}

static int flushes(void) {
    volatile float a = FLT_MIN;
    float half = 0.5f * a;
    volatile float b = half;
    return b + b != a;
}

static int trusts_numbers(void) {
    volatile float zero = 0.0f;
    float a = zero / zero;
    return a == a;
}

const char *arithmetic_fault(void) {
    if (FAST_MATH) {
        return "compiled with -ffast-math; leave it out";
    }
    if (trusts_numbers()) {
        return "comparisons take a NaN for a number; leave out -ffinite-math-only and -ffast-math";
    }
    if (is_wide()) {
        return "sums are computed wider than 32 bits or in another order; leave out -ffast-math, "
               "and on 32-bit x86 compile with -msse2 -mfpmath=sse";
    }
    if (is_fused()) {
        return "products and sums are fused; compile with -ffp-contract=off";
    }
    if (flushes()) {
        return "small numbers are flushed to zero; leave out -ffast-math when linking, too";
    }
    return 0;
}
