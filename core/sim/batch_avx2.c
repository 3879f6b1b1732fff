/* Blocks with AVX2: two vectors of eight floats, four of four doubles. */
#define CORE_VECTOR /* before the first header: lookups by comparison, see curve.h */
#include "batch.h"

#ifdef BATCH_BLOCKS
#pragma GCC target("avx2")
#define BLOCK_RUN batch_avx2
#include "block.h"
#endif

typedef int not_empty; /* C wants a declaration in every file */
