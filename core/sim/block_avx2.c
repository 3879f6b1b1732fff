/* block.h for AVX2. */
#include "vectorise.h"

#include "block_avx2.h"
#include "simd.h"

#ifdef SIMD_BLOCKS
#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC target("avx2")
#pragma GCC optimize("no-gcse") /* a twentieth faster with the 16 registers */
#endif
#define BLOCK_RUN block_avx2
#include "block.h"
#ifdef __clang__
#pragma clang attribute pop
#endif
#endif

typedef int not_empty; /* C requires a declaration in every file */
