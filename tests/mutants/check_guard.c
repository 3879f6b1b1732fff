/* Limits of a drive's inputs: what passes, what is replaced, which fault it sets. */
#include <string.h>

#include "checks.h"
#include "faults.h"
#include "params.h"

void check_guard(void) {
    const guard_params_t *g = &PARAMS[4].guard;
    drive_state_t x;
    drive_init(&PARAMS[4], &x, 0.0f, 0.0f, 0.25f);
    /* All that is beside a bad value is good, and just so. */
    const float good[2][5] = {{g->i_sample, -g->i_sample, g->u_dc_max, g->omega, 1.0f},
                              {-g->i_sample, g->i_sample, g->u_dc_min, -g->omega, 0.0f}};
    const struct {
        int field, fault;
        float value, becomes;
    } bad[] = {
        {0, FAULT_CURRENT, 11.1f, 0.0f},
        {0, FAULT_CURRENT, -11.1f, 0.0f},
        {1, FAULT_CURRENT, 11.1f, 0.0f},
        {1, 0, 10.9f, 10.9f},
        {2, FAULT_U_DC, 811.0f, 0.0f},
        {2, FAULT_U_DC, 269.0f, 269.0f},
        {2, FAULT_U_DC, -9.0f, 0.0f},
        {2, 0, 809.0f, 809.0f},
        {2, 0, 270.0f, 270.0f},
        {3, FAULT_COMMAND, 1.001f * g->omega, g->omega},
        {3, FAULT_COMMAND, -1e30f, -g->omega},
        {3, FAULT_COMMAND, INFINITY, 0.0f},
        {3, FAULT_COMMAND, (float)NAN, 0.0f},
        {3, 0, -0.999f * g->omega, -0.999f * g->omega},
        {4, FAULT_COMMAND, 1.01f, 0.25f},
        {4, FAULT_COMMAND, -0.01f, 0.25f},
        {4, 0, 1.0f, 1.0f},
        {4, 0, 0.0f, 0.0f},
        {4, FAULT_COMMAND, (float)NAN, 0.25f},
    };
    for (unsigned k = 0; k < 2 * (sizeof bad / sizeof bad[0]); k++) {
        const unsigned j = k / 2;
        float v[5], w[5];
        memcpy(v, good[k % 2], sizeof v);
        v[bad[j].field] = bad[j].value;
        drive_in_t in, out;
        memcpy(&in, v, sizeof in);
        x.fault = 0;
        out = drive_guard(g, &x, &in);
        memcpy(w, &out, sizeof w);
        v[bad[j].field] = bad[j].becomes;
        check("guard", x.fault == bad[j].fault && memcmp(v, w, sizeof v) == 0);
    }
    for (int j = 0; j < 40; j++) {
        double beyond = j % 2 ? 1.001 : 0.999;
        vec_t way = beyond * cexp(I * j), was = draw(-9, 9) + I * draw(-9, 9);
        vec_t next = was + sqrt((double)g->i_step_sq) * way;
        ab_t i_ab = {9.8f * (float)creal(way), 9.8f * (float)cimag(way)};
        ab_t jump = {(float)creal(next), (float)cimag(next)};
        x.fault = 0;
        drive_guard_current(g, &x, i_ab);
        check("over-current", x.fault == (j % 2 ? FAULT_OVER_CURRENT : 0));
        x.coupled.i_1.a = (float)creal(was), x.coupled.i_1.b = (float)cimag(was), x.fault = 0;
        drive_guard_step(g, &x, jump);
        check("step of the current", x.fault == (j % 2 ? FAULT_CURRENT : 0));
    }
    drive_in_t in = {0.0f, 0.0f, g->u_dc_max, 0.0f, 2.0f};
    x.k_s = 1.5f;
    check("weight in force beyond 1", drive_guard(g, &x, &in).k_s_ref == 1.0f);
    x.k_s = -0.5f;
    check("weight in force below 0", drive_guard(g, &x, &in).k_s_ref == 0.0f);
    float least = 0.5f * g->u_dc_min;
    check("link",
          guard_inv_link(g, least) == 1.0f / least && guard_inv_link(g, 0.99f * least) == 0.0f);
    check("link above", guard_inv_link(g, g->u_dc_max) == 1.0f / g->u_dc_max &&
                            guard_inv_link(g, 1.01f * g->u_dc_max) == 0.0f);
    check("no link", guard_inv_link(g, NAN) == 0.0f && guard_inv_link(g, 0.0f) == 0.0f);
    check("inputs", faults_inputs(&PARAMS[4]) == 0);
    check("angles", faults_angles(&PARAMS[4]) == 0);
    check("weights", faults_weights(&PARAMS[4]) == 0);
}
