/* Asks the processor which vector instructions it has. */
#include "simd.h"

#ifdef SIMD_BLOCKS

int32_t sim_simd(void) {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")) {
        return SIMD_AVX512;
    }
    return __builtin_cpu_supports("avx2") ? SIMD_AVX2 : SIMD_NONE;
}

#else

int32_t sim_simd(void) { return SIMD_NONE; }

#endif
