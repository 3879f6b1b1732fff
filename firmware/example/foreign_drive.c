/* The schedule in a drive that has its own observers: two calls, nothing else of this folder.
 *
 * What stands between the lines is a stub of that drive: a ramp through the hand-over, with two
 * observers that disagree a little. Build it with `make example`.
 */
#include <stdio.h>

#include "../ks_hook_params.h"

/* ---- the foreign drive ---- */
typedef struct {
    float omega;     /* speed estimate in use, electrical [rad/s] */
    float i_q;       /* torque current [A] */
    float theta_hfi; /* angle by injection [rad] */
    float theta_emf; /* angle by its own observer [rad] */
} foreign_t;

static void foreign_observe(foreign_t *x, float share) {
    x->omega = share * 0.5f * ks_hook_params.omega_full; /* omega_full is twice rated speed */
    x->i_q = 0.25f * ks_hook_params.i_full;              /* i_full is twice rated current */
    x->theta_emf = 0.3f;
    x->theta_hfi = 0.35f;
}

/* Its own blend: the weighted angle, across the seam at half a turn. */
static float foreign_blend(const foreign_t *x, float k_s) {
    return wrap_pi(x->theta_emf + k_s * wrap_pi(x->theta_hfi - x->theta_emf));
}
/* ---------------------------- */

int main(void) {
    enum { PERIODS = 20000 };
    foreign_t foreign;
    ks_hook_state_t hook;
    ks_hook_state_t hook_q15;
    int check = ks_hook_init(&ks_hook_params, &hook); /* once */
    ks_hook_init(&ks_hook_params, &hook_q15);
    for (int k = 0; k < PERIODS; k++) { /* every PWM period */
        foreign_observe(&foreign, (float)k / (float)PERIODS);
        float k_s = ks_hook_step(&ks_hook_params, &hook, foreign.omega, foreign.i_q,
                                 wrap_pi(foreign.theta_hfi - foreign.theta_emf));
        float theta = foreign_blend(&foreign, k_s);

        /* The same from fixed-point numbers. */
        float q = 32768.0f;
        int16_t k_s_q15 = ks_hook_step_q15(
            &ks_hook_params, &hook_q15, (int16_t)(q * foreign.omega / ks_hook_params.omega_full),
            (int16_t)(q * foreign.i_q / ks_hook_params.i_full), (int16_t)(q * 0.05f / PI_F));
        if (k % 1000 == 0) {
            printf("speed %.2f of rated: k_s %.3f, Q15 %5d, angle %.3f rad\n",
                   (double)(2.0f * foreign.omega / ks_hook_params.omega_full), (double)k_s,
                   (int)k_s_q15, (double)theta);
        }
    }
    return check != KS_OK || hook.schedule.fault != 0;
}
