/* Comparison with the golden vectors, bit by bit, where a schedule also sets gains. */
#include "gain_selftest.h"

#include "ks_lookup.h"

/* NaN, which stands for the static gain, has many words. */
static int differs(float x, uint32_t expected) {
    return bits_of(x) != expected && (x == x || float_of(expected) == float_of(expected));
}

uint32_t gain_table_selftest(const gain_table_t *t, const ks_table_t *axes, const void *k_s,
                             const void *values, const gain_vector_t *v, uint32_t n,
                             uint32_t *first) {
    uint32_t bad = 0;
    if (ks_table_check(axes, k_s, 0) != KS_OK || gain_table_check(t, axes, values) != KS_OK) {
        *first = 0; /* a look-up would read beyond them */
        return n;
    }
    *first = n;
    for (uint32_t j = 0; j < n; j++) {
        float y[SIGNAL_N];
        ks_cell_t cell;
        int wrong = 0;
        for (int i = 0; i < SIGNAL_N; i++) {
            y[i] = 0.0f;
        }
        for (uint32_t a = 0; a < axes->n_axes; a++) {
            y[axes->axis[a].signal] = float_of(v[j].y[a]);
        }
        ks_table_place(axes, y, &cell);
        for (uint32_t g = 0; g < t->n_gains; g++) {
            wrong |= differs(gain_table_at(t, axes, values, &cell, g), v[j].value[g]);
        }
        *first = wrong && bad == 0 ? j : *first;
        bad += wrong ? 1U : 0U;
    }
    return bad;
}

uint32_t gain_drive_selftest(const drive_params_t *p, drive_params_t *live,
                             const gain_schedule_params_t *schedule, const drive_start_t *start,
                             const drive_vector_t *v, uint32_t n, uint32_t *first) {
    drive_state_t x;
    gain_schedule_state_t s;
    uint32_t bad = 0;
    *first = n;
    drive_init(p, &x, start->theta, start->omega, start->k_s);
    gain_schedule_init(schedule, &s, p, live);
    for (uint32_t j = 0; j < n; j++) {
        drive_in_t in = {
            float_of(v[j].i_a),       float_of(v[j].i_b),     float_of(v[j].u_dc),
            float_of(v[j].omega_ref), float_of(v[j].k_s_ref),
        };
        if (j == start->find[0] || j == start->find[1]) {
            drive_find_rotor(&x);
        }
        float k_s_ref = gain_schedule_step(schedule, &s, p, live, &x.signal);
        ab_t u = drive_step(live, &x, &in);
        if (differs(k_s_ref, v[j].k_s_ref) || differs(u.a, v[j].u_a) || differs(u.b, v[j].u_b) ||
            differs(x.est.theta, v[j].theta) || differs(x.est.omega, v[j].omega)) {
            *first = bad == 0 ? j : *first;
            bad++;
        }
    }
    return bad;
}
