/* One period of a drive that may be lost or at its end. */
#ifndef SENSORLESS_SIM_ADVANCE_H
#define SENSORLESS_SIM_ADVANCE_H

#include "sim_period.h"

/* One period; that of a lost drive changes neither sums nor verdict. extra: that of the plant,
 * passed so that it can be constant. Returns the inputs of the drive's controller. */
CORE_INLINE drive_in_t sim_advance(sim_t *s, float k_s_ref, int extra) {
    sums_t sums = s->sums;
    int32_t lost = s->lost;
    int32_t k_lost = s->k_lost;
    drive_in_t in =
        sim_period(s, k_s_ref, s->sensored, s->with_twin, s->plant.n_sub, extra, s->plant.detail);
    if (lost != 0) {
        s->k = (s->lost & LOST_NONFINITE) != 0 ? s->k_end : s->k;
        s->sums = sums;
        s->lost = lost;
        s->k_lost = k_lost;
    }
    return in;
}

#endif
