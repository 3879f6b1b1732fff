/* The per-period step as a linkable function, and the state to start from. */
#include "drive.h"

ab_t drive_step(const drive_params_t *p, drive_state_t *x, const drive_in_t *in) {
    return drive_step_inline(p, x, in);
}

void drive_init(const drive_params_t *p, drive_state_t *x, float theta, float omega, float k_s) {
    drive_state_t zero = {0};
    float at = wrap_pi(theta);
    *x = zero;
    x->hfi.pll.theta = at;
    x->hfi.pll.omega = omega;
    x->smo.pll.theta = at;
    x->smo.pll.omega = omega;
    x->smo.omega_f = omega;
    x->est.theta = at;
    x->est.omega = omega;
    x->theta_hfi = at;
    x->theta_smo = at;
    x->k_s = k_s;
    x->signal.omega = omega;
    x->signal.omega_2 = omega;
    x->signal.omega_ref = omega;
    x->signal.k_s = k_s;
    /* an IP controller at speed omega without load: its integrator carries the proportional part */
    x->control.i_int = p->control.k_p_speed * (1.0f - p->control.weight_ref) * omega;
    x->control.u_max = 1.0f;
}
