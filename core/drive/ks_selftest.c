/* Comparison with the golden vectors, bit by bit. */
#include "ks_selftest.h"

#include "ks_lookup.h"

static int differs(float x, uint32_t expected) { return bits_of(x) != expected; }

uint32_t ks_table_selftest(const ks_table_t *t, const void *values, const ks_vector_t *v,
                           uint32_t n, uint32_t *first) {
    uint32_t bad = 0;
    if (ks_table_check(t, values, 0) != KS_OK) { /* a look-up would read beyond it */
        *first = 0;
        return n;
    }
    *first = n;
    for (uint32_t j = 0; j < n; j++) {
        float y[SIGNAL_N];
        for (int i = 0; i < SIGNAL_N; i++) {
            y[i] = 0.0f;
        }
        for (uint32_t a = 0; a < t->n_axes; a++) {
            y[t->axis[a].signal] = float_of(v[j].y[a]);
        }
        if (differs(ks_table_eval(t, values, y), v[j].k_s)) {
            *first = bad == 0 ? j : *first;
            bad++;
        }
    }
    return bad;
}

uint32_t drive_selftest(const drive_params_t *p, const ks_schedule_params_t *schedule,
                        const drive_start_t *start, const drive_vector_t *v, uint32_t n,
                        uint32_t *first) {
    drive_state_t x;
    ks_schedule_state_t s;
    uint32_t bad = 0;
    *first = n;
    drive_init(p, &x, start->theta, start->omega, start->k_s);
    ks_schedule_init(schedule, &s);
    for (uint32_t j = 0; j < n; j++) {
        drive_in_t in = {
            float_of(v[j].i_a),       float_of(v[j].i_b),     float_of(v[j].u_dc),
            float_of(v[j].omega_ref), float_of(v[j].k_s_ref),
        };
        if (j == start->find[0] || j == start->find[1]) {
            drive_find_rotor(&x);
        }
        float k_s_ref = ks_schedule_step(schedule, &s, &p->signal, &x.signal);
        ab_t u = drive_step(p, &x, &in);
        if (differs(k_s_ref, v[j].k_s_ref) || differs(u.a, v[j].u_a) || differs(u.b, v[j].u_b) ||
            differs(x.est.theta, v[j].theta) || differs(x.est.omega, v[j].omega)) {
            *first = bad == 0 ? j : *first;
            bad++;
        }
    }
    return bad;
}
