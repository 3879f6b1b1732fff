/* Dead time's share of the averaged inverter with edges. */
#include "edge_losses.h"

void edge_losses(const plant_slope_t *slope, const ab_t *u, const ab_t *i, const float *u_dc,
                 float u_lost, float T_s, int32_t n, ab_t *lost) {
    sensor_params_t without = {0};
    sensor_params_t with = {0};
    for (int32_t k = 0; k < n; k++) {
        with.dead_time_share = u_lost / max_f(u_dc[k], 1.0f);
        ab_t full = edges_voltage(&without, slope[k], u[k], u_dc[k], T_s, i[k]);
        ab_t left = edges_voltage(&with, slope[k], u[k], u_dc[k], T_s, i[k]);
        lost[k].a = full.a - left.a;
        lost[k].b = full.b - left.b;
    }
}
