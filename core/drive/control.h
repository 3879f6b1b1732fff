/* Speed and current control in the estimated rotor frame.
 *
 * Speed: PI with weighted reference (weight 0 is an IP controller) and back-calculated anti-windup;
 * its output is the torque current i_q, limited in slope and magnitude, and not increased while the
 * current control lacks voltage. The d current follows the curve of maximum torque per ampere,
 * lowered by a voltage-driven field-weakening integrator.
 * Current: two-degree-of-freedom internal-model control (doi 10.1109/28.663477) on the mean of two
 * samples, which contains no injected current. It decouples the axes by that current, which is two
 * periods old when the voltage acts, or where the rotor turns far in them by its reference. The
 * voltage is limited to the circle u_dc / sqrt(3) minus the reserve for injection, and turned by
 * theta + 1.5 omega T_s: one period of computation, and half a period to the middle of the hold.
 */
#ifndef SENSORLESS_CONTROL_H
#define SENSORLESS_CONTROL_H

#include "blend.h"
#include "curve.h"
#include "dead_time.h"
#include "trig.h"

typedef struct {
    float k_p_speed;      /* [A s/rad], electrical speed */
    float k_i_speed;      /* [A/rad] */
    float weight_ref;     /* share of the reference in the proportional part, 0 ... 1 */
    float i_q_step;       /* largest change of i_q_ref per period [A] */
    float i_max;          /* current limit, peak [A] */
    float k_t_d;          /* reference gain, alpha_c L_d [V/A] */
    float k_t_q;          /* alpha_c L_q [V/A] */
    float k_p_d;          /* feedback gain, 2 alpha_c L_d - R_s [V/A] */
    float k_p_q;          /* 2 alpha_c L_q - R_s [V/A] */
    float k_i_d;          /* alpha_c^2 L_d times T_s [V/A] */
    float k_i_q;          /* alpha_c^2 L_q times T_s [V/A] */
    float L_d;            /* decoupling [H] */
    float L_q;            /* decoupling [H] */
    float psi_f;          /* decoupling [Vs] */
    float by_reference;   /* share of the decoupling by the current's reference, 0 ... 1 */
    float k_fw;           /* field-weakening gain times T_s [A/V] */
    float fw_margin;      /* share of the voltage limit that the fundamental may use */
    float i_d_min;        /* most negative d current [A] */
    float i_q_brake;      /* torque current that a generator keeps short of voltage [A] */
    float i_int_max;      /* bound that nothing but damage takes the integrator beyond [A] */
    float u_dt;           /* dead-time voltage of a leg to compensate [V], 0 = off */
    float inv_i_dt;       /* slope of its transition through zero current [1/A] */
    curve_t i_d_mtpa;     /* d current of maximum torque per ampere over |i_q| [A] */
    float curve_inv_step; /* nodes per ampere of all curves [1/A] */
} control_params_t;

typedef struct {
    dq_t i_1;        /* sample k-1 in the control frame [A] */
    dq_t i;          /* mean of samples k-1 and k [A] */
    dq_t i_ref;      /* [A] */
    dq_t u_int;      /* integrators of the current control [V] */
    float i_int;     /* integrator of the speed control [A] */
    float i_d_fw;    /* field-weakening part of i_d_ref, at most 0 [A] */
    dq_t u_sum;      /* voltages since lock.h looked, before injection [V] */
    dq_t i_sum;      /* currents since then [A] */
    float u_abs;     /* magnitude of the voltage before the limit [V] */
    float u_max;     /* voltage limit of the last period [V] */
    float i_d_end;   /* d current reference from which down the torque current gives way [A] */
    float i_q_least; /* torque current that it keeps then, as a magnitude [A] */
} control_state_t;

/* Torque-current reference from the speed error [A]. omega_ref, omega: electrical [rad/s].
 * What weakens the field adds reluctance torque, and the torque current falls by as much. Otherwise
 * the speed loop would have to take it back, and field weakening would act through that loop.
 * Without voltage to spare the reference waits for field weakening: short of voltage the flux falls
 * behind the rotor, which lowers the torque of a motor and raises that of a generator, until it
 * slips. Where the d current can weaken no more, the torque current gives way. */
CORE_INLINE float speed_control(const control_params_t *p, control_state_t *x, float omega_ref,
                                float omega, float T_s) {
    float i_d = x->i_ref.d;
    float less = min_f(p->L_d - p->L_q, 0.0f);
    float alone = p->psi_f + less * min_f(i_d - x->i_d_fw, 0.0f);
    float share = alone / (p->psi_f + less * i_d);
    float want = share * (p->k_p_speed * (p->weight_ref * omega_ref - omega) + x->i_int);
    float i_q_max = sqrt_f(p->i_max * p->i_max - i_d * i_d);
    float held = abs_f(x->i_ref.q);
    held = i_d > x->i_d_end ? held : max_f(held - p->i_q_step, x->i_q_least);
    i_q_max = x->u_abs > x->u_max ? min_f(i_q_max, held) : i_q_max;
    float step = bound_f(want - x->i_ref.q, p->i_q_step);
    float i_q = bound_f(x->i_ref.q + step, i_q_max);
    float cut = (i_q - want) / (share * p->k_p_speed);
    x->i_int += T_s * p->k_i_speed * (omega_ref - omega + cut);
    return i_q;
}

/* Where the torque current gives way until the next call, and what it keeps then. omega_ref, omega:
 * electrical [rad/s]; far [A]. To brake, a generator keeps i_q_brake, near the torque current with
 * which it needs the least voltage, and gives way too while the d current is `far` beyond its
 * reference: there the flux lies behind the rotor, and more torque current turns it further back. */
CORE_INLINE void control_ends(const control_params_t *p, control_state_t *x, float omega_ref,
                              float omega, float far) {
    int brakes = (omega_ref - omega) * omega < 0.0f;
    int beyond = x->i_ref.d - x->i.d > far;
    x->i_q_least = brakes ? p->i_q_brake : 0.0f;
    x->i_d_end = brakes && beyond ? 0.0f : p->i_d_min;
}

/* Direction of a frame of direction r, as it will be when the voltage now computed acts: over
 * [k+1, k+2], so 1.5 periods on. omega: electrical [rad/s]. */
CORE_INLINE rot_t control_when_acts(rot_t r, float omega, float T_s) {
    return rot_turn(r, 1.5f * T_s * omega);
}

/* Takes in sample k [A] in the frame r of the estimate at k; x->i becomes the mean with sample
 * k-1. */
CORE_INLINE void control_sample(control_state_t *x, rot_t r, ab_t i_ab) {
    dq_t i_k = ab_to_dq(i_ab, r);
    dq_t i = {0.5f * (i_k.d + x->i_1.d), 0.5f * (i_k.q + x->i_1.q)};
    x->i_1 = i_k;
    x->i = i;
}

/* Current control alone, for the torque current i_q_ref [A]; otherwise as control_step. */
CORE_INLINE ab_t current_control(const control_params_t *p, control_state_t *x, estimate_t est,
                                 rot_t r, ab_t i_ab, float u_dc, float i_q_ref, float reserve,
                                 float T_s) {
    control_sample(x, r, i_ab);
    dq_t i = x->i;
    x->i_sum.d += i.d;
    x->i_sum.q += i.q;

    float i_d_mtpa = curve_at(&p->i_d_mtpa, curve_locate(i_q_ref, p->curve_inv_step));
    x->i_ref.q = i_q_ref;
    x->i_ref.d = max_f(i_d_mtpa + x->i_d_fw, p->i_d_min);

    float omega = est.omega;
    dq_t off = {x->i_ref.d - i.d, x->i_ref.q - i.q};
    float emf_d = omega * p->L_q * (i.q + p->by_reference * off.q);
    float emf_q = omega * (p->L_d * (i.d + p->by_reference * off.d) + p->psi_f);
    dq_t u = {
        p->k_t_d * x->i_ref.d - p->k_p_d * i.d + x->u_int.d - emf_d,
        p->k_t_q * x->i_ref.q - p->k_p_q * i.q + x->u_int.q + emf_q,
    };
    float u_abs = sqrt_f(u.d * u.d + u.q * u.q);
    float u_max = max_f(u_dc * INV_SQRT3_F - reserve, 1.0f);
    float scale = u_abs > u_max ? u_max / u_abs : 1.0f;
    dq_t u_lim = {scale * u.d, scale * u.q};
    x->u_sum.d += u_lim.d;
    x->u_sum.q += u_lim.q;
    x->u_int.d += p->k_i_d * (off.d + (u_lim.d - u.d) / p->k_t_d);
    x->u_int.q += p->k_i_q * (off.q + (u_lim.q - u.q) / p->k_t_q);
    x->i_d_fw = clamp_f(x->i_d_fw + p->k_fw * (p->fw_margin * u_max - u_abs), p->i_d_min, 0.0f);
    x->u_abs = u_abs;
    x->u_max = u_max;
    return dq_to_ab(u_lim, control_when_acts(r, omega, T_s));
}

/* One period: fundamental voltage that becomes active at k+1, stator frame [V]. est: angle and
 * speed to use, r: direction of that angle; i_ab: sample k [A]; u_dc [V]; reserve: voltage left for
 * injection [V]. */
CORE_INLINE ab_t control_step(const control_params_t *p, control_state_t *x, estimate_t est,
                              rot_t r, ab_t i_ab, float u_dc, float omega_ref, float reserve,
                              float T_s) {
    float i_q_ref = speed_control(p, x, omega_ref, est.omega, T_s);
    return current_control(p, x, est, r, i_ab, u_dc, i_q_ref, reserve, T_s);
}

/* Begins the sums for lock.h again. */
CORE_INLINE void control_sum_anew(control_state_t *x) {
    x->u_sum.d = 0.0f;
    x->u_sum.q = 0.0f;
    x->i_sum.d = 0.0f;
    x->i_sum.q = 0.0f;
}

/* Sets the speed controller to its state at speed omega without load: the integrator cancels the
 * proportional part, and no torque is requested. */
CORE_INLINE void control_ready(const control_params_t *p, control_state_t *x, float omega) {
    x->i_ref.q = 0.0f;
    x->i_int = p->k_p_speed * (1.0f - p->weight_ref) * omega;
    x->i_d_end = p->i_d_min;
    x->i_q_least = 0.0f;
}

#endif
