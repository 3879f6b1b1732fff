/* Makes the inputs of a period safe. */
#ifndef SENSORLESS_DRIVE_GUARD_H
#define SENSORLESS_DRIVE_GUARD_H

#include "drive_types.h"

#define LIMIT_CURRENT 1.0e4f /* largest plausible magnitude of a sample [A] */
#define LIMIT_VOLTAGE 1.0e5f /* [V] */
#define LIMIT_SPEED 1.0e5f   /* [rad/s] electrical */

/* Replaces bad values and sets their fault bits. */
CORE_INLINE drive_in_t drive_guard(drive_state_t *x, const drive_in_t *in) {
    drive_in_t y;
    y.i_a = sane_f(in->i_a, LIMIT_CURRENT);
    y.i_b = sane_f(in->i_b, LIMIT_CURRENT);
    y.u_dc = max_f(sane_f(in->u_dc, LIMIT_VOLTAGE), 0.0f);
    y.omega_ref = sane_f(in->omega_ref, LIMIT_SPEED);
    y.k_s_ref = in->k_s_ref <= 1.0f && in->k_s_ref >= 0.0f ? in->k_s_ref : x->k_s;
    x->fault |= (y.i_a == in->i_a ? 0 : FAULT_CURRENT) | (y.i_b == in->i_b ? 0 : FAULT_CURRENT) |
                (y.u_dc == in->u_dc ? 0 : FAULT_U_DC) |
                (y.omega_ref == in->omega_ref ? 0 : FAULT_COMMAND) |
                (y.k_s_ref == in->k_s_ref ? 0 : FAULT_COMMAND);
    return y;
}

#endif
