/* Rotor angle from the extended back-EMF, estimated by a sliding-mode current observer.
 *
 * Stator frame, J = [0 -1; 1 0]; with e = E [-sin theta, cos theta]:
 *   L_d d(i_hat)/dt = u - R_s i_hat + omega (L_d - L_q) J i_hat - z,   z = k f(x),   x = i_hat - i
 * (doi 10.12177/emca.2025.011, Eqs. 17-22; f = sign, or the sigmoid tanh(a x / 2) of Eq. 24), one
 * forward-Euler step a period. In steady state x is not zero and z lags e;
 *   e = z + (R_s + j omega L_q) x
 * removes that lag exactly, whatever f is. Forward Euler puts e half a period ahead of the sample.
 *
 * The sigmoid is a boundary layer as wide as 2/a: inside, the observer is linear and does not
 * slide. The signum slides in the first order. Super-twisting slides in the second order, per axis:
 *   z = k_1 |x|^(1/2) sign(x) + v,   dv/dt = k_2 sign(x)
 * (doi 10.1080/0020717031000099029). It needs |de/dt| <= L_d C for k_1 = 1.5 L_d C^(1/2) and k_2 =
 * 1.1 L_d C; as e turns with the rotor and its magnitude is omega psi, L_d C = omega^2 psi. So k_1
 * rises with the speed and k_2 with its square.
 */
#ifndef SENSORLESS_SLIDING_MODE_H
#define SENSORLESS_SLIDING_MODE_H

#include "emf_estimate.h"
#include "trig.h"
#include "vector.h"

/* The function f. */
enum { SMO_SIGMOID = 0, SMO_SIGN = 1, SMO_SUPER_TWISTING = 2 };

typedef struct {
    pll_params_t pll;
    float R_s;         /* stator resistance of the model [ohm] */
    float L_d;         /* [H] */
    float k;           /* bound on the estimated EMF [V] */
    float half_a;      /* half the sigmoid's slope [1/A]; gain at the origin g = k half_a [V/A] */
    float i_reach;     /* bound on the model's current error, beyond which it would run away [A] */
    int switching;     /* SMO_* */
    float root;        /* super-twisting: k_1 over the speed [V s/A^(1/2)] */
    float climb;       /* super-twisting: T_s k_2 over the square of the speed [V s^2] */
    float lag_cure;    /* 1: EMF from the exact steady-state relation, 0: EMF equal to z */
    float L_q_rise;    /* rise of L_q from generator to motor, over that of a generator */
    float alpha_omega; /* low-pass on the speed inside the model: 1 - exp(-w T_s) */
    float alpha_e;     /* low-pass on the EMF: 1 - exp(-w T_s); 1 switches it off */
    float e_floor;     /* least EMF magnitude that the error is divided by [V] */
    float omega_floor; /* below this speed the EMF is not used, electrical [rad/s] */
} smo_params_t;

typedef struct {
    ab_t i_hat;    /* model current [A] */
    ab_t z;        /* last correction voltage [V] */
    ab_t v;        /* the part of z that super-twisting integrates [V] */
    float omega_f; /* filtered speed of the cross term, electrical [rad/s] */
} smo_state_t;

/* Correction voltage that drives the current error d [A] to zero instead of into a layer around it.
 * omega: speed at which the EMF turns, electrical [rad/s]. */
CORE_INLINE void smo_slide(const smo_params_t *p, smo_state_t *x, ab_t d, float omega) {
    ab_t s = {sign_f(d.a), sign_f(d.b)};
    if (p->switching == SMO_SIGN) {
        x->z.a = p->k * s.a;
        x->z.b = p->k * s.b;
        return;
    }
    float w = max_f(abs_f(omega), p->omega_floor);
    float root = p->root * w;
    float climb = p->climb * w * w;
    x->v.a = bound_f(x->v.a + climb * s.a, p->k);
    x->v.b = bound_f(x->v.b + climb * s.b, p->k);
    x->z.a = root * sqrt_f(abs_f(d.a)) * s.a + x->v.a;
    x->z.b = root * sqrt_f(abs_f(d.b)) * s.b + x->v.b;
}

/* L_q of the observer as a motor or a generator: power > 0 as a motor; share of the rise, 0 without
 * torque current.
 *
 * Too large an L_q makes a generator unstable: the estimated speed stands in the cross term, and its
 * error omega_err comes back as an angle of -(L_q - L_d) i_q omega_err / E, which takes damping from
 * the PLL. As a motor the same term adds damping, and a low L_q only costs angle. */
CORE_INLINE float smo_L_q(const smo_params_t *p, float L_q, float power, float share) {
    float rise = power > 0.0f ? p->L_q_rise : 0.0f;
    return L_q + rise * share * L_q;
}

/* One period. y: the estimate, advanced to k+1; i_ab: measured current at k [A]; u_ab: voltage
 * applied over [k-1, k] [V]; L_q: [H]; omega: speed that the drive runs on [rad/s], for direction
 * and for the EMF's floor; theta_idle: angle to follow below the floor, at instant k [rad]. */
CORE_INLINE void smo_observe(const smo_params_t *p, smo_state_t *x, emf_estimate_t *y, ab_t i_ab,
                             ab_t u_ab, float L_q, float omega, float theta_idle, float T_s) {
    float w_l = x->omega_f * (p->L_d - L_q);
    float h = T_s / p->L_d;
    ab_t i_hat = {
        x->i_hat.a + h * (u_ab.a - p->R_s * x->i_hat.a - w_l * x->i_hat.b - x->z.a),
        x->i_hat.b + h * (u_ab.b - p->R_s * x->i_hat.b + w_l * x->i_hat.a - x->z.b),
    };
    ab_t d = {bound_f(i_hat.a - i_ab.a, p->i_reach), bound_f(i_hat.b - i_ab.b, p->i_reach)};
    if (SCALAR_ONLY(p->switching != SMO_SIGMOID)) {
        smo_slide(p, x, d, omega);
    } else {
        x->z.a = p->k * tanh_f(p->half_a * d.a);
        x->z.b = p->k * tanh_f(p->half_a * d.b);
    }
    x->i_hat.a = i_ab.a + d.a;
    x->i_hat.b = i_ab.b + d.b;
    float r = p->lag_cure * p->R_s;
    float w_q = p->lag_cure * y->pll.omega * L_q;
    ab_t e = {x->z.a + r * d.a - w_q * d.b, x->z.b + r * d.b + w_q * d.a};
    y->e.a += p->alpha_e * (e.a - y->e.a);
    y->e.b += p->alpha_e * (e.b - y->e.b);

    rot_t at = rot_of(y->pll.theta + 0.5f * T_s * y->pll.omega);
    float e_q = times_sign_f(-y->e.a * at.c - y->e.b * at.s, omega);
    int valid = abs_f(omega) >= p->omega_floor;
    y->err = valid ? e_q / max_f(norm_ab(y->e), p->e_floor) : 0.0f;
    y->valid = valid ? 1.0f : 0.0f;
    y->pll.theta = valid ? y->pll.theta : theta_idle;
    y->pll.omega = valid ? y->pll.omega : omega;
    pll_step(&p->pll, &y->pll, y->err, T_s);
    x->omega_f += p->alpha_omega * (y->pll.omega - x->omega_f);
}

#endif
