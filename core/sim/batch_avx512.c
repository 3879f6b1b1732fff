/* Blocks with AVX-512: one vector of sixteen floats, two of eight doubles. */
#define CORE_VECTOR /* before the first header: lookups by comparison, see curve.h */
#include "batch.h"

#ifdef BATCH_BLOCKS
#pragma GCC target("avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512")
#pragma GCC optimize("schedule-insns", "sched-pressure") /* a tenth faster with its 32 registers */
#define BLOCK_RUN batch_avx512
#include "block.h"
#endif

typedef int not_empty; /* C wants a declaration in every file */
