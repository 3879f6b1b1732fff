/* Counter-based noise: a pure function of (seed, counter), so no run depends on another. */
#ifndef SENSORLESS_NOISE_H
#define SENSORLESS_NOISE_H

#include <stdint.h>

#include "drive/frames.h"

/* 32-bit integer mix ("lowbias32" of C. Wellons' hash-prospector search). */
CORE_INLINE uint32_t noise_mix(uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352dU;
    x ^= x >> 15;
    x *= 0x846ca68bU;
    x ^= x >> 16;
    return x;
}

/* Nearly normal number of unit variance: the sum of four uniform 16-bit numbers (Irwin-Hall),
 * limited to +-3.46; kurtosis -0.3 against the normal's 0. */
CORE_INLINE float noise_normal(uint32_t seed, uint32_t counter) {
    uint32_t a = noise_mix(seed ^ noise_mix(2U * counter));
    uint32_t b = noise_mix(seed ^ noise_mix(2U * counter + 1U));
    int32_t sum = (int32_t)((a & 0xffffU) + (a >> 16) + (b & 0xffffU) + (b >> 16)) - 131070;
    return (float)sum * 2.64295e-5f; /* 1 / sqrt(4 (65536^2 - 1) / 12) */
}

#endif
