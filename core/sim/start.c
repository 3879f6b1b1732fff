/* Puts drives into the state that a scenario begins with. */
#include "start.h"

#include "harmonics.h"
#include "plant.h"

/* d flux at zero current [Vs]: secant iteration from two guesses around the magnet's flux. */
static double flux_at_rest(const plant_params_t *p) {
    dq64_t psi = {p->map.i_f / p->map.a_d0, 0.0};
    double i_1 = flux_map_current(&p->map, psi, p->extra).d;
    double psi_1 = psi.d;
    psi.d = 0.9 * psi_1 + 1.0e-3;
    for (int j = 0; j < 60; j++) {
        double i_d = flux_map_current(&p->map, psi, p->extra).d;
        double slope = (i_d - i_1) / (psi.d - psi_1);
        if (i_d == i_1 || !(slope > 0.0)) {
            break;
        }
        psi_1 = psi.d;
        i_1 = i_d;
        psi.d -= i_d / slope;
    }
    return psi.d;
}

static void start_one(sim_t *s) {
    plant_state_t y = {0};
    sums_t none = {0};
    ab_t zero = {0.0f, 0.0f};
    const start_t *at = &s->start;
    y.psi_d = flux_at_rest(&s->plant);
    s->plant.harmonics.psi_0 = y.psi_d;
    y.omega_m = (double)at->omega_m;
    y.theta_e = (double)at->theta_e;
    plant_start(&s->plant, &y);
    if (s->plant.detail != 0) { /* no current with harmonics either */
        dq64_t m = magnet_harmonic(&s->plant.harmonics, sixth_power(y.cos_e, y.sin_e));
        y.psi_d += m.d;
        y.psi_q += m.q;
        plant_output(&s->plant, &y, s->plant.extra, 1);
    }
    float omega_e = s->omega_scale * at->omega_m;
    int seek = at->seek != 0 && s->sensored == 0;
    drive_init(&s->control, &s->drive.x, at->theta_e - at->theta_err, seek ? 0.0f : omega_e,
               at->k_s);
    if (seek) {
        drive_find_rotor(&s->drive.x);
    }
    drive_init(&s->control, &s->twin.x, at->theta_e, omega_e, at->k_s);
    s->drive.y = y;
    s->twin.y = y;
    s->drive.u = zero;
    s->twin.u = zero;
    s->now.omega_ref = omega_e;
    s->now.tau_load = 0.0f;
    s->now.u_dc = s->profile.u_dc[0];
    s->now.segment = 0;
    s->sums = none;
    s->tau_1 = 0.0f;
    s->dev_1 = 0.0f;
    s->err_count = 0;
    s->k = 0;
    s->lost = 0;
    s->begun = 0;
    s->k_lost = 0;
}

void sim_start(sim_t *s, int32_t n) {
    for (int32_t i = 0; i < n; i++) {
        start_one(&s[i]);
    }
}
