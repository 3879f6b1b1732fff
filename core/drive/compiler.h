/* Everything that depends on the compiler. */
#ifndef SENSORLESS_COMPILER_H
#define SENSORLESS_COMPILER_H

/* NaN has to compare as such: every check of a measured number and of the state needs it. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0)
#error "arithmetic: compiled with -ffast-math; leave it out, and -Ofast and -ffinite-math-only"
#endif

/* With compilers other than gcc and clang, define CORE_SQRTF as their square root of a float.
 * CORE_FABSF is the magnitude of a float: 0 also for -0. */
#if defined(__GNUC__)
#ifndef CORE_INLINE
#define CORE_INLINE static inline __attribute__((always_inline))
#endif
#define CORE_APART static __attribute__((noinline))
#define CORE_COLD __attribute__((cold)) /* runs rarely: small rather than fast */
#define CORE_LIKELY(x) __builtin_expect(x, 1)
/* Without -fno-math-errno __builtin_sqrtf calls the library to set errno; these do not. */
#if defined(__clang_major__) && __clang_major__ >= 17
#define CORE_SQRTF __builtin_elementwise_sqrt
#elif defined(__SSE__) && !defined(__NO_MATH_ERRNO__)
static inline __attribute__((always_inline)) float core_sqrtf(float x) {
    typedef float four_t __attribute__((vector_size(16)));
    four_t y = {x, 0.0f, 0.0f, 0.0f};
    y = __builtin_ia32_sqrtss(y);
    return y[0];
}
#define CORE_SQRTF core_sqrtf
#else
#define CORE_SQRTF __builtin_sqrtf
#endif
#define CORE_FABSF __builtin_fabsf
#else
#define CORE_INLINE static inline
#define CORE_APART static
#define CORE_COLD
#define CORE_LIKELY(x) (x)
#define CORE_FABSF(x) ((x) > 0.0f ? (x) : 0.0f - (x))
#ifndef CORE_SQRTF
#error "define CORE_SQRTF: the square root of a float, correctly rounded"
#endif
#endif

#endif
