/* Which drives run as a block of vector code, and with which instructions. */
#include "batch.h"

#ifdef BATCH_BLOCKS

int32_t sim_simd(void) {
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")) {
        return SIMD_AVX512;
    }
    return __builtin_cpu_supports("avx2") ? SIMD_AVX2 : SIMD_NONE;
}

int batch_fits(const sim_t *sims, int32_t count, int most) {
    int fits = count >= LANES_WORTH && (sims->control.estimator == ESTIMATE_ANGLES ||
                                        sims->control.estimator == ESTIMATE_FLUX);
    for (int l = 0; l < count; l++) {
        const sim_t *s = &sims[l];
        fits = fits && s->sensored == 0 && s->with_twin == sims->with_twin && s->plant.n_sub == 1 &&
               s->plant.bridge == 0 && s->control.hfi.scheme == HFI_ROTATING &&
               s->control.estimator == sims->control.estimator &&
               s->drive.x.start.phase == START_DONE && !(s->inv_stick > 0.0f) &&
               s->sensor.carrier == 0;
    }
    int simd = fits ? sim_simd() : SIMD_NONE;
    return simd < most ? simd : most;
}

void batch_run(sim_t *sims, int32_t count, int32_t periods, int simd, const float *k_s_ref) {
    if (simd == SIMD_AVX512) {
        batch_avx512(sims, count, periods, k_s_ref);
    } else {
        batch_avx2(sims, count, periods, k_s_ref);
    }
}

#else

int32_t sim_simd(void) { return SIMD_NONE; }

int batch_fits(const sim_t *sims, int32_t count, int most) {
    (void)sims;
    (void)count;
    (void)most;
    return SIMD_NONE;
}

void batch_run(sim_t *sims, int32_t count, int32_t periods, int simd, const float *k_s_ref) {
    (void)sims;
    (void)count;
    (void)periods;
    (void)simd;
    (void)k_s_ref;
}

#endif
