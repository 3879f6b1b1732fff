/* block.h for AVX-512. */
#define CORE_VECTOR /* before the first header, see drive/vector.h */
#include "block_avx512.h"
#include "simd.h"

#ifdef SIMD_BLOCKS
#pragma GCC target("avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512")
#pragma GCC optimize("schedule-insns", "sched-pressure") /* a tenth faster with the 32 registers */
#define BLOCK_RUN block_avx512
#include "block.h"
#endif

typedef int not_empty; /* C requires a declaration in every file */
