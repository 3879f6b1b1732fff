/* How compilers are told to turn a loop over drives into vector instructions. The first header of a
 * file that includes block.h. */
#ifndef SENSORLESS_VECTORISE_H
#define SENSORLESS_VECTORISE_H

#define CORE_VECTOR /* see drive/vector.h */

/* LANES_LOOP stands before a loop in which no lane depends on another. */
#ifdef __clang__
#define LANES_LOOP _Pragma("clang loop vectorize(assume_safety) interleave(disable)")
#else
#define LANES_LOOP _Pragma("GCC ivdep")
#endif

#if defined(__clang__) && defined(__x86_64__)
/* By default clang hands over two floats as one vector, which it cannot widen. */
#define CORE_INLINE static inline __attribute__((always_inline, regcall))
#endif

#endif
