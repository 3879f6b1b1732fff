/* The flux map at many points. */
#include "flux_map.h"

void flux_map_currents(const flux_map_t *p, int32_t extra, const double *psi, double *i,
                       int32_t n) {
    for (int32_t j = 0; j < n; j++) {
        dq64_t at = {psi[2 * j], psi[2 * j + 1]};
        dq64_t y = flux_map_current(p, at, extra);
        i[2 * j] = y.d;
        i[2 * j + 1] = y.q;
    }
}
