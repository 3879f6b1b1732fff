/* Which drives run as a block of vector code, and with which instructions. */
#include "batch.h"

#include "block_avx2.h"
#include "block_avx512.h"
#include "simd.h"

#ifdef SIMD_BLOCKS

#define LANES_WORTH 4 /* fewest drives for which a block is faster */

static int lane_fits(const sim_t *s, const sim_t *first) {
    int constant = s->sensored == 0 && s->plant.n_sub == 1 && s->plant.extra == EXTRA_NONE;
    int alike = s->with_twin == first->with_twin && s->plant.detail == first->plant.detail &&
                s->control.estimator == first->control.estimator;
    int scalar_only = s->control.hfi.scheme == HFI_STATIONARY ||
                      s->control.smo.switching != SMO_SIGMOID || s->inv_stick > 0.0f ||
                      s->sensor.carrier != 0;
    return constant && alike && !scalar_only;
}

int batch_fits(const sim_t *sims, int32_t count, int most) {
    int estimator = sims->control.estimator;
    int known =
        estimator == ESTIMATE_SMO || estimator == ESTIMATE_FLUX || estimator == ESTIMATE_COUPLED;
    int fits = known;
    int moving = 0; /* the others advance one by one */
    for (int l = 0; l < count; l++) {
        fits = fits && lane_fits(&sims[l], sims);
        moving += sims[l].drive.x.start.phase == START_DONE && sims[l].lost == 0;
    }
    fits = fits && moving >= LANES_WORTH;
    int simd = fits ? sim_simd() : SIMD_NONE;
    return simd < most ? simd : most;
}

int32_t batch_run(const block_run_t *run, int simd) {
    return simd == SIMD_AVX512 ? block_avx512(run) : block_avx2(run);
}

#else

int batch_fits(const sim_t *sims, int32_t count, int most) {
    (void)sims;
    (void)count;
    (void)most;
    return SIMD_NONE;
}

int32_t batch_run(const block_run_t *run, int simd) {
    (void)simd;
    return run->done;
}

#endif
