/* Sets of vector instructions: those that the code can use, and those that this machine has. */
#ifndef SENSORLESS_SIMD_H
#define SENSORLESS_SIMD_H

#include <stdint.h>

/* Each set includes those before it. */
enum { SIMD_NONE = 0, SIMD_AVX2 = 1, SIMD_AVX512 = 2 };

#if defined(__x86_64__) && defined(__GNUC__)
#define SIMD_BLOCKS /* the compiler can use them in block.h */
#endif

/* The largest SIMD_* that this machine has and the compiler can use. */
int32_t sim_simd(void);

#endif
