/* block.h for AVX-512. */
#include "vectorise.h"

#include "block_avx512.h"
#include "simd.h"

#ifdef SIMD_BLOCKS
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx512f,avx512vl,avx512dq,avx512bw"))),        \
                             apply_to = function)
#else
#pragma GCC target("avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512")
#pragma GCC optimize("schedule-insns", "sched-pressure") /* a tenth faster with the 32 registers */
#endif
#define BLOCK_RUN block_avx512
#include "block.h"
#ifdef __clang__
#pragma clang attribute pop
#endif
#endif

typedef int not_empty; /* C requires a declaration in every file */
