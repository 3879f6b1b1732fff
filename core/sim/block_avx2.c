/* block.h for AVX2. */
#define CORE_VECTOR /* before the first header, see drive/vector.h */
#include "block_avx2.h"
#include "simd.h"

#ifdef SIMD_BLOCKS
#pragma GCC target("avx2")
#define BLOCK_RUN block_avx2
#include "block.h"
#endif

typedef int not_empty; /* C requires a declaration in every file */
