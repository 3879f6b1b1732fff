/* Sets of vector instructions: which are known, which this machine has. */
#ifndef SENSORLESS_SIMD_H
#define SENSORLESS_SIMD_H

#include <stdint.h>

/* Each set includes those before. */
enum { SIMD_NONE = 0, SIMD_AVX2 = 1, SIMD_AVX512 = 2 };

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SIMD_BLOCKS /* the compiler knows how to use them in block.h */
#endif

/* Most of SIMD_* that this machine has and the compiler knows how to use. */
int32_t sim_simd(void);

#endif
