/* Machine and mechanics over one PWM period, in double precision.
 *
 * Rotor frame, voltage constant in the stator frame over the period:
 *   dpsi_d/dt = u_d - R_s i_d + omega_e psi_q      dpsi_q/dt = u_q - R_s i_q - omega_e psi_d
 *   J domega_m/dt = tau - B omega_m - tau_load     dtheta_e/dt = omega_e = n_p omega_m
 *   tau = 3/2 n_p (psi_d i_q - psi_q i_d)
 * With `detail`, the machine has the harmonics of harmonics.h and an iron loss g_iron |e|^2 3/2,
 * where e is the time derivative of the flux linkage in the stator frame. The current g_iron e adds
 * to that of the flux map at the terminals, so that e = (u - R_s i) k_iron. Sensors see its mean
 * over the period, because an averaged voltage has no instants. Integration is classical
 * fourth-order Runge-Kutta. The held voltage turns backwards in the rotor frame as the rotor moves;
 * the stages get it from a power series in the angle travelled.
 */
#ifndef SENSORLESS_PLANT_H
#define SENSORLESS_PLANT_H

#include "harmonics.h"

typedef struct {
    flux_map_t map;
    harmonics_t harmonics;
    double R_s;     /* [ohm] */
    double n_p;     /* pole pairs */
    double inv_J;   /* 1 / inertia [1/(kg m^2)]; 0 holds the speed */
    double B;       /* viscous friction [N m s/rad] */
    double h;       /* sub-step: period / n_sub [s] */
    double g_iron;  /* iron loss: conductance across the EMF [S] */
    double k_iron;  /* share of the voltage behind R_s that drives the flux: 1 / (1 + R_s g_iron) */
    int32_t n_sub;  /* sub-steps a period */
    int32_t extra;  /* EXTRA_*: what the flux map has beyond saturation */
    int32_t detail; /* 1: harmonics, iron loss, edges.h, link ripple; 0: all of them are off */
    int32_t reserved;
} plant_params_t;

typedef struct {
    double psi_d; /* [Vs] */
    double psi_q;
    double omega_m; /* mechanical speed [rad/s] */
    double theta_e; /* electrical angle in [-pi, pi] [rad] */
    double cos_e;   /* of theta_e */
    double sin_e;
    double i_d; /* currents at the terminals at the sampling instant [A] */
    double i_q;
    double tau;      /* torque at the sampling instant [N m] */
    double i_flux_d; /* with detail, the currents without that of the iron loss [A] */
    double i_flux_q;
    int32_t turns; /* electrical turns beyond theta_e */
    int32_t reserved;
} plant_state_t;

#define PI_D 3.14159265358979323846

/* Cosine and sine of a small angle |x| < 0.5: Taylor series to x^11 and x^12, error below 1e-15 up
 * to 0.35 and 2e-14 at 0.5. */
CORE_INLINE void small_angle(double x, double *c, double *s) {
    double z = x * x;
    double odd =
        -1.0 / 6.0 +
        z * (1.0 / 120.0 + z * (-1.0 / 5040.0 + z * (1.0 / 362880.0 + z * (-1.0 / 39916800.0))));
    double even =
        -0.5 + z * (1.0 / 24.0 +
                    z * (-1.0 / 720.0 +
                         z * (1.0 / 40320.0 + z * (-1.0 / 3628800.0 + z * (1.0 / 479001600.0)))));
    *s = x + x * z * odd;
    *c = 1.0 + z * even;
}

typedef struct {
    double psi_d, psi_q, omega_m, delta;
} plant_rate_t;

/* Constant over a period: voltage in the rotor frame of its start [V], that frame, load [N m]. */
typedef struct {
    dq64_t u;
    dq64_t frame; /* cos and sin of theta_e */
    double tau_load;
} plant_held_t;

/* Currents of the flux, and torque over 3/2 n_p, at the angle with cosine c and sine s. */
CORE_INLINE response_t plant_response(const plant_params_t *p, dq64_t psi, double c, double s,
                                      int extra, int detail) {
    if (detail) {
        return harmonics_response(&p->harmonics, &p->map, psi, sixth_power(c, s), extra);
    }
    dq64_t i = flux_map_current(&p->map, psi, extra);
    response_t y = {i, psi.d * i.q - psi.q * i.d};
    return y;
}

/* Time derivative under the voltage u [V] with the currents i [A] and the torque tau [N m]. */
CORE_INLINE plant_rate_t plant_rate(const plant_params_t *p, plant_rate_t x, dq64_t u, dq64_t i,
                                    double tau, double tau_load, int detail) {
    double omega = p->n_p * x.omega_m;
    double e_d = u.d - p->R_s * i.d;
    double e_q = u.q - p->R_s * i.q;
    if (detail) {
        e_d *= p->k_iron;
        e_q *= p->k_iron;
    }
    plant_rate_t y = {
        e_d + omega * x.psi_q,
        e_q - omega * x.psi_d,
        p->inv_J * (tau - p->B * x.omega_m - tau_load),
        omega,
    };
    return y;
}

/* The same at a stage; x.delta: angle travelled since the period's start [rad]. */
CORE_INLINE plant_rate_t plant_stage(const plant_params_t *p, const plant_held_t *held,
                                     plant_rate_t x, int extra, int detail) {
    double c, s;
    small_angle(x.delta, &c, &s);
    dq64_t psi = {x.psi_d, x.psi_q};
    dq64_t f = held->frame;
    response_t r = plant_response(p, psi, f.d * c - f.q * s, f.q * c + f.d * s, extra, detail);
    dq64_t u = {c * held->u.d + s * held->u.q, c * held->u.q - s * held->u.d};
    return plant_rate(p, x, u, r.i, 1.5 * p->n_p * r.tau, held->tau_load, detail);
}

CORE_INLINE plant_rate_t plant_along(plant_rate_t x, double h, plant_rate_t k) {
    plant_rate_t y = {x.psi_d + h * k.psi_d, x.psi_q + h * k.psi_q, x.omega_m + h * k.omega_m,
                      x.delta + h * k.delta};
    return y;
}

/* One Runge-Kutta step of length h [s]; k1: time derivative at its start. */
CORE_INLINE plant_rate_t plant_substep(const plant_params_t *p, const plant_held_t *held,
                                       plant_rate_t x, plant_rate_t k1, double h, int extra,
                                       int detail) {
    double w = h * (1.0 / 6.0);
    plant_rate_t k2 = plant_stage(p, held, plant_along(x, 0.5 * h, k1), extra, detail);
    plant_rate_t k3 = plant_stage(p, held, plant_along(x, 0.5 * h, k2), extra, detail);
    plant_rate_t k4 = plant_stage(p, held, plant_along(x, h, k3), extra, detail);
    plant_rate_t y = {
        x.psi_d + w * (k1.psi_d + 2.0 * (k2.psi_d + k3.psi_d) + k4.psi_d),
        x.psi_q + w * (k1.psi_q + 2.0 * (k2.psi_q + k3.psi_q) + k4.psi_q),
        x.omega_m + w * (k1.omega_m + 2.0 * (k2.omega_m + k3.omega_m) + k4.omega_m),
        x.delta + w * (k1.delta + 2.0 * (k2.delta + k3.delta) + k4.delta),
    };
    return y;
}

/* Currents of the flux, and torque, at the present state. */
CORE_INLINE void plant_output(const plant_params_t *p, plant_state_t *x, int extra, int detail) {
    dq64_t psi = {x->psi_d, x->psi_q};
    response_t r = plant_response(p, psi, x->cos_e, x->sin_e, extra, detail);
    x->i_d = r.i.d;
    x->i_q = r.i.q;
    if (detail) {
        x->i_flux_d = r.i.d;
        x->i_flux_q = r.i.q;
    }
    x->tau = 1.5 * p->n_p * r.tau;
}

/* Currents of the flux at the present state, as plant_output left them. */
CORE_INLINE dq64_t plant_current(const plant_state_t *x, int detail) {
    dq64_t y = {detail ? x->i_flux_d : x->i_d, detail ? x->i_flux_q : x->i_q};
    return y;
}

/* Slope of the stator current: di/dt = gamma u + drift, in the stator frame at the present
 * instant. With detail it leaves out k_iron and how the harmonics change as the rotor turns. */
typedef struct {
    float aa, ab, bb; /* gamma, the inverse of the incremental inductance [1/H] */
    float drift_a;    /* [A/s] */
    float drift_b;
} plant_slope_t;

#define SLOPE_STEP 1.0e-6 /* step of the flux linkages for the slope [Vs] */

CORE_INLINE plant_slope_t plant_slope(const plant_params_t *p, const plant_state_t *x, int extra,
                                      int detail) {
    double c = x->cos_e;
    double s = x->sin_e;
    dq64_t psi = {x->psi_d, x->psi_q};
    dq64_t psi_1 = {x->psi_d + SLOPE_STEP, x->psi_q};
    dq64_t psi_2 = {x->psi_d, x->psi_q + SLOPE_STEP};
    dq64_t i = plant_current(x, detail);
    dq64_t i_1 = plant_response(p, psi_1, c, s, extra, detail).i;
    dq64_t i_2 = plant_response(p, psi_2, c, s, extra, detail).i;
    double dd = (i_1.d - i.d) * (1.0 / SLOPE_STEP);
    double qq = (i_2.q - i.q) * (1.0 / SLOPE_STEP);
    double dq = (i_2.d - i.d) * (1.0 / SLOPE_STEP);
    double omega = p->n_p * x->omega_m;
    double e_d = omega * psi.q - p->R_s * i.d;
    double e_q = -omega * psi.d - p->R_s * i.q;
    double r_d = dd * e_d + dq * e_q - omega * i.q;
    double r_q = dq * e_d + qq * e_q + omega * i.d;
    double mean = 0.5 * (dd + qq);
    double half = 0.5 * (dd - qq);
    double cos2 = c * c - s * s;
    double sin2 = 2.0 * c * s;
    double along = half * cos2 - dq * sin2;
    plant_slope_t y = {
        (float)(mean + along),      (float)(half * sin2 + dq * cos2), (float)(mean - along),
        (float)(c * r_d - s * r_q), (float)(s * r_d + c * r_q),
    };
    return y;
}

/* Flux linkage in the stator frame [Vs]. */
CORE_INLINE dq64_t plant_flux_ab(const plant_state_t *x) {
    dq64_t y = {x->cos_e * x->psi_d - x->sin_e * x->psi_q,
                x->sin_e * x->psi_d + x->cos_e * x->psi_q};
    return y;
}

/* Adds the current of the iron loss: its mean over the last `period` [s], at whose start the flux
 * was psi_ab. */
CORE_INLINE void plant_add_iron(const plant_params_t *p, plant_state_t *x, dq64_t psi_ab,
                                double period) {
    dq64_t now = plant_flux_ab(x);
    double g = p->g_iron / period;
    double i_a = g * (now.d - psi_ab.d);
    double i_b = g * (now.q - psi_ab.q);
    x->i_d += x->cos_e * i_a + x->sin_e * i_b;
    x->i_q += x->cos_e * i_b - x->sin_e * i_a;
}

/* n_sub Runge-Kutta steps of length h [s] under the stator-frame voltage (u_a, u_b) [V] and a
 * constant load torque [N m], from where plant_output left the currents and the torque; a period is
 * n_sub steps of p->h. n_sub, extra, detail: p's own, passed so that they can be constants. Leaves
 * the currents of the flux alone, without the iron's. */
CORE_INLINE void plant_move(const plant_params_t *p, plant_state_t *x, double u_a, double u_b,
                            double tau_load, double h, int n_sub, int extra, int detail) {
    plant_held_t held = {
        {x->cos_e * u_a + x->sin_e * u_b, x->cos_e * u_b - x->sin_e * u_a},
        {x->cos_e, x->sin_e},
        tau_load,
    };
    plant_rate_t y = {x->psi_d, x->psi_q, x->omega_m, 0.0};
    plant_rate_t k1 = plant_rate(p, y, held.u, plant_current(x, detail), x->tau, tau_load, detail);
    y = plant_substep(p, &held, y, k1, h, extra, detail);
    if (n_sub != 1) { /* no loop in the usual case, so that loops over drives vectorise */
        for (int j = 1; j < n_sub; j++) {
            k1 = plant_stage(p, &held, y, extra, detail);
            y = plant_substep(p, &held, y, k1, h, extra, detail);
        }
    }
    double c, s;
    small_angle(y.delta, &c, &s);
    double cos_e = x->cos_e * c - x->sin_e * s;
    double sin_e = x->sin_e * c + x->cos_e * s;
    double fix = 1.5 - 0.5 * (cos_e * cos_e + sin_e * sin_e); /* keeps the vector's length at 1 */
    x->cos_e = cos_e * fix;
    x->sin_e = sin_e * fix;
    double theta = x->theta_e + y.delta;
    int32_t turn = theta > PI_D ? 1 : (theta < -PI_D ? -1 : 0);
    x->theta_e = theta - (double)turn * (2.0 * PI_D);
    x->turns += turn;
    x->psi_d = y.psi_d;
    x->psi_q = y.psi_q;
    x->omega_m = y.omega_m;
    plant_output(p, x, extra, detail);
}

/* A whole period: plant_move, and the current of the iron loss. */
CORE_INLINE void plant_step(const plant_params_t *p, plant_state_t *x, double u_a, double u_b,
                            double tau_load, int n_sub, int extra, int detail) {
    dq64_t psi_ab = plant_flux_ab(x);
    plant_move(p, x, u_a, u_b, tau_load, p->h, n_sub, extra, detail);
    if (detail) {
        plant_add_iron(p, x, psi_ab, p->h * (double)n_sub);
    }
}

/* Columns of a row of plant_run. */
enum {
    PLANT_I_D = 0, /* [A] */
    PLANT_I_Q,
    PLANT_PSI_D, /* [Vs] */
    PLANT_PSI_Q,
    PLANT_TAU,     /* [N m] */
    PLANT_OMEGA_M, /* [rad/s] */
    PLANT_THETA_E, /* unwrapped [rad] */
    PLANT_N
};

/* The machine alone over n periods under u[3 j]: u_alpha, u_beta [V], tau_load [N m]. Writes rows
 * of PLANT_N numbers for j = 0 ... n to out. */
void plant_run(const plant_params_t *p, plant_state_t *x, const double *u, double *out, int32_t n);

/* Sets cos_e, sin_e, currents and torque from theta_e, flux and speed. */
void plant_start(const plant_params_t *p, plant_state_t *x);

#endif
