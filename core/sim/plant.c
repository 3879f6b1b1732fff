/* The machine without a drive. */
#include "plant.h"

/* cos and sin of any angle in [-pi, pi] by halving into the range of the series. */
static void angle_vector(double theta, double *c, double *s) {
    small_angle(theta * 0.125, c, s);
    for (int j = 0; j < 3; j++) {
        double c2 = *c * *c - *s * *s;
        *s = 2.0 * *c * *s;
        *c = c2;
    }
}

void plant_start(const plant_params_t *p, plant_state_t *x) {
    angle_vector(x->theta_e, &x->cos_e, &x->sin_e);
    x->turns = 0;
    plant_output(p, x, p->extra, p->detail);
}

void plant_run(const plant_params_t *p, plant_state_t *x, const double *u, double *out, int32_t n) {
    for (int32_t j = 0;; j++) {
        double *row = &out[(long)j * PLANT_N];
        row[PLANT_I_D] = x->i_d;
        row[PLANT_I_Q] = x->i_q;
        row[PLANT_PSI_D] = x->psi_d;
        row[PLANT_PSI_Q] = x->psi_q;
        row[PLANT_TAU] = x->tau;
        row[PLANT_OMEGA_M] = x->omega_m;
        row[PLANT_THETA_E] = x->theta_e + (double)x->turns * (2.0 * PI_D);
        if (j == n) {
            return;
        }
        plant_step(p, x, u[3 * j], u[3 * j + 1], u[3 * j + 2], p->n_sub, p->extra, p->detail);
    }
}
