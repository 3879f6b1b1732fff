/* One PWM period of a drive and of its twin: sample, control, advance, sum up. */
#ifndef SENSORLESS_SIM_PERIOD_H
#define SENSORLESS_SIM_PERIOD_H

#include "carrier.h"
#include "drive/vector.h"
#include "edges.h"
#include "sim.h"

/* Whether a drive does not advance any more. */
CORE_INLINE int sim_over(const sim_t *s) {
    return (s->lost != 0 && s->go_on == 0) || s->k >= s->k_end;
}

/* Current of the machine in the stator frame [A]. */
CORE_INLINE ab_t stator_current(const plant_state_t *y) {
    ab_t i = {(float)(y->cos_e * y->i_d - y->sin_e * y->i_q),
              (float)(y->sin_e * y->i_d + y->cos_e * y->i_q)};
    return i;
}

/* Sampled currents and present commands as the controller sees them. Drive and twin have the same
 * noise. */
CORE_INLINE drive_in_t sim_sample(const sim_t *s, const chain_t *c, float k_s_ref, int detail) {
    ab_t i_ab = stator_current(&c->y);
    const sensor_params_t *p = &s->sensor;
    uint32_t k = (uint32_t)s->k;
    drive_in_t in = {
        sensor_read(p, i_ab.a, p->gain_a, p->offset_a, s->seed, k, 0U),
        sensor_read(p, phase_b(i_ab), p->gain_b, p->offset_b, s->seed, k, 1U),
        detail ? s->now.u_dc * (1.0f + link_ripple(p, 2 * s->k)) : s->now.u_dc,
        s->now.omega_ref,
        k_s_ref,
    };
    return in;
}

/* Advances the machine over [k, k+1] under the waiting command, whose pulses were computed for the
 * DC link measured at k - 1; the new command takes its place. */
CORE_INLINE void chain_advance(const sim_t *s, chain_t *c, ab_t u_next, int n_sub, int extra,
                               int detail) {
    float tau = s->now.tau_load;
    if (SCALAR_ONLY(s->inv_stick > 0.0f)) { /* the load only resists motion */
        tau = abs_f(tau) * clamp_f(s->inv_stick * (float)c->y.omega_m, -1.0f, 1.0f);
    }
    double tau_load = (double)tau;
    float u_dc = s->now.u_dc;
    if (detail) {
        float link = 1.0f + link_ripple(&s->sensor, 2 * s->k + 1);
        float gain = link / (1.0f + link_ripple(&s->sensor, 2 * s->k - 2));
        u_dc *= link;
        c->u.a *= gain;
        c->u.b *= gain;
    }
    if (SCALAR_ONLY(s->sensor.carrier != 0)) {
        carrier_advance(&s->sensor, &s->plant, &c->y, c->u, u_dc, tau_load);
    } else {
        ab_t i_ab = stator_current(&c->y);
        ab_t u;
        if (detail) {
            plant_slope_t slope = plant_slope(&s->plant, &c->y, extra, detail);
            float T_s = (float)(s->plant.h * (double)n_sub);
            u = edges_voltage(&s->sensor, slope, c->u, u_dc, T_s, i_ab);
        } else {
            u = inverter_voltage(&s->sensor, c->u, u_dc, i_ab);
        }
        plant_step(&s->plant, &c->y, (double)u.a, (double)u.b, tau_load, n_sub, extra, detail);
    }
    c->u = u_next;
}

/* Control on the true angle and speed, without injection, as a reference. While the drive is
 * `starting`, its twin waits without torque, so that both take control in the same period. */
CORE_INLINE ab_t sensored_step(const drive_params_t *p, chain_t *c, const drive_in_t *raw,
                               float omega_scale, int starting) {
    drive_in_t in = drive_guard(&p->guard, &c->x, raw);
    ab_t i_ab = phases_to_ab(in.i_a, in.i_b);
    estimate_t truth = {(float)c->y.theta_e, omega_scale * (float)c->y.omega_m};
    c->x.est = truth;
    if (starting) {
        return drive_hold(p, &c->x, &in, i_ab, truth);
    }
    control_ends(&p->control, &c->x.control, in.omega_ref, truth.omega, p->lock.i_off);
    return drive_actuate(p, &c->x, &in, i_ab, truth, rot_of(truth.theta), 0.0f);
}

CORE_INLINE void sim_sum(sim_t *s, float theta_e, float tau, float tau_twin, float omega_m,
                         float omega_m_twin, float i_sq, float i_sq_twin, float k_s_was,
                         int starting, int sensored) {
    const drive_state_t *x = &s->drive.x;
    sums_t *m = &s->sums;
    float err = starting ? 0.0f : wrap_pi(theta_e - x->est.theta);
    float dev = s->with_twin != 0 ? tau - tau_twin : 0.0f;
    float tau_lf = 0.5f * (tau + s->tau_1);
    float dev_lf = 0.5f * (dev + s->dev_1);
    s->tau_1 = tau;
    s->dev_1 = dev;
    m->tau_min = m->n > 0.0f ? min_f(m->tau_min, tau_lf) : tau_lf;
    m->tau_max = m->n > 0.0f ? max_f(m->tau_max, tau_lf) : tau_lf;
    m->tau += tau;
    m->tau_sq += tau * tau;
    m->tau_lf_sq += tau_lf * tau_lf;
    m->tau_twin += tau_twin;
    m->dev_sq += dev * dev;
    m->dev_lf_sq += dev_lf * dev_lf;
    m->omega_m += omega_m;
    m->omega_m_twin += omega_m_twin;
    m->err += err;
    m->err_sq += err * err;
    m->err_max = max_f(m->err_max, abs_f(err));
    m->err_hfi += starting ? 0.0f : wrap_pi(theta_e - x->theta_hfi);
    m->err_smo += starting ? 0.0f : wrap_pi(theta_e - x->theta_smo);
    m->k_s += x->k_s;
    m->k_s_moved += abs_f(x->k_s - k_s_was);
    m->injecting += abs_f(x->hfi.sign_1);
    m->i_sq += i_sq;
    m->i_sq_twin += i_sq_twin;
    m->n += 1.0f;
    m->starting += starting ? 1.0f : 0.0f;

    s->err_count = abs_f(err) > s->err_limit ? s->err_count + 1 : 0;
    float trip = s->i_trip * s->i_trip;
    int finite = i_sq <= 1.0e12f && abs_f(omega_m) <= 1.0e6f && abs_f(err) <= 4.0f;
    float i_sq_true = sensored ? i_sq : i_sq_twin; /* of the machine that runs on the true angle */
    float omega_true = sensored ? omega_m : (s->with_twin != 0 ? omega_m_twin : 0.0f);
    int follows = i_sq_true <= trip && abs_f(omega_true) <= s->omega_limit;
    s->lost |= (s->err_count > s->err_periods ? LOST_ANGLE : 0) | (i_sq > trip ? LOST_CURRENT : 0) |
               (finite ? 0 : LOST_NONFINITE) | (follows ? 0 : LOST_TWIN);
    s->k_lost = s->lost != 0 ? s->k + 1 : 0;
}

/* One period. sensored, with_twin, n_sub, extra, detail: those of sim_t, passed so that they can
 * be constants. Returns the inputs of the drive's controller. */
CORE_INLINE drive_in_t sim_period(sim_t *s, float k_s_ref, int sensored, int with_twin, int n_sub,
                                  int extra, int detail) {
    profile_step(&s->profile, &s->now, s->k);
    float theta_e = (float)s->drive.y.theta_e;
    float tau = (float)s->drive.y.tau;
    float omega_m = (float)s->drive.y.omega_m;
    float i_sq = (float)(s->drive.y.i_d * s->drive.y.i_d + s->drive.y.i_q * s->drive.y.i_q);
    float k_s_was = s->drive.x.k_s;
    int starting = SCALAR_ONLY(s->drive.x.start.phase != START_DONE) && s->begun == 0;
    s->begun = starting ? 0 : 1;
    drive_in_t in = sim_sample(s, &s->drive, k_s_ref, detail);
    ab_t u;
    if (sensored) {
        u = sensored_step(&s->control, &s->drive, &in, s->omega_scale, 0);
        s->drive.x.theta_hfi = theta_e;
        s->drive.x.theta_smo = theta_e;
    } else {
        u = drive_step_inline(&s->control, &s->drive.x, &in);
    }
    chain_advance(s, &s->drive, u, n_sub, extra, detail);

    float tau_twin = 0.0f;
    float omega_m_twin = omega_m;
    float i_sq_twin = 0.0f;
    if (with_twin) {
        const plant_state_t *y = &s->twin.y;
        tau_twin = (float)y->tau;
        omega_m_twin = (float)y->omega_m;
        i_sq_twin = (float)(y->i_d * y->i_d + y->i_q * y->i_q);
        drive_in_t in_twin = sim_sample(s, &s->twin, 0.0f, detail);
        ab_t u_twin = sensored_step(&s->control, &s->twin, &in_twin, s->omega_scale, starting);
        chain_advance(s, &s->twin, u_twin, n_sub, extra, detail);
    }
    sim_sum(s, theta_e, tau, tau_twin, omega_m, omega_m_twin, i_sq, i_sq_twin, k_s_was, starting,
            sensored);
    s->k += 1;
    return in;
}

#endif
