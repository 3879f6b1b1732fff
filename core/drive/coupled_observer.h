/* Rotor angle from flux and injection together: one angle, one speed, one flux.
 *
 * The voltage model gives the fast part. In the estimated rotor frame, the flux that follows from
 * the measured current minus the integrated flux is the error
 *   e = (error of the integrated flux) - j delta psi_a,   delta = theta_e - theta_e_hat,
 * psi_a the auxiliary flux (flux_model.h). Its part across psi_a, eps, drives angle, speed and load
 * (the load torque is a third state, besides the torque of current and flux). Its part along psi_a
 * corrects the flux through a sigmoid with a boundary layer: sliding mode far from the model, linear
 * near it.
 *
 * Injection gives the slow part with weight k_s. Its error e_h turns the angle, and moves the flux
 * by what such a turn does to e, j e_h psi_a: so its noise never reaches eps and the speed, whatever
 * the load. What errors of the voltages do to the flux is learned from it (voltage_drift.h).
 * Where the flux is trusted less (near zero current), eps says less of load and sensors.
 * Derivation, poles and gains: docs/coupled-observer.md.
 */
#ifndef SENSORLESS_COUPLED_OBSERVER_H
#define SENSORLESS_COUPLED_OBSERVER_H

#include "curve.h"
#include "emf_estimate.h"
#include "flux_model.h"
#include "sensor_match.h"
#include "trig.h"
#include "voltage_drift.h"

typedef struct {
    float R_s;         /* stator resistance of the model [ohm] */
    float L_d;         /* [H] */
    curve_t psi_d;     /* d flux without d current over |i_q| [Vs] */
    float psi_sq_min;  /* least square of the auxiliary flux that errors are divided by [(Vs)^2] */
    float gain_0;      /* half the correction of the flux at standstill [1/s] times T_s */
    float gain_w;      /* half its rise with speed, times T_s [s] */
    float brake;       /* resistance over what braking may lean the angle by and T_s [ohm/s] */
    float brake_least; /* least share of the correction in braking, without injection */
    float idle;        /* more correction without torque current, under injection [1/s] times T_s */
    float inv_i_idle;  /* 1 / torque current from which there is none of it [1/A] */
    float layer;       /* boundary layer of the correction, over the auxiliary flux */
    float inv_layer;   /* its inverse; 0: no sigmoid */
    float k_p;         /* from eps to angle [1/s] times T_s */
    float k_i;         /* from eps to speed [1/s^2] */
    float k_l;         /* from eps to load [1/s^3] times T_s */
    float k_tau;       /* share of the flux-current product that accelerates [rad/(s^2 Vs A)] */
    float load_max;    /* bound on the load [rad/s^2] */
    float alpha_rise;  /* low-pass on eps for the bandwidth's rise: 1 - exp(-w T_s) */
    float eps_rise;    /* |eps_f| above which the bandwidth rises [rad] */
    float rise;        /* its rise with |eps_f| above that [1/rad] */
    float rise_max;    /* its largest rise, as a share of the bandwidth */
    float inv_slope;   /* 1 / slope of the injection's error signal [rad] */
    float k_h;         /* from injection to angle and flux [1/s] times T_s */
    float omega_floor; /* below this speed the flux needs injection, electrical [rad/s] */
    float omega_max;   /* bound on the speed estimate, electrical [rad/s] */
    drift_params_t drift; /* of the voltages */
    match_params_t match; /* of the current sensors */
} coupled_params_t;

typedef struct {
    ab_t psi;     /* estimated stator flux [Vs] */
    ab_t i_1;     /* sample k-1, whichever observer is in use; the caller keeps it [A] */
    float load;   /* acceleration by load and friction [rad/s^2] */
    float eps_f;  /* low-passed error across the auxiliary flux, times the squared trust [rad] */
    float gain_0; /* correction of the flux at standstill [1/s] times T_s, see coupled_rates */
    float gain_w; /* its rise with speed, times T_s [s] */
    drift_state_t drift; /* what errors of the voltages do to the flux */
    match_state_t match; /* errors of the current sensors, kept by a new start */
} coupled_state_t;

/* Weight at or below which injection does not lead the flux below omega_floor [1]. */
#define COUPLED_LED 0.01f

/* Corrects the flux with a share of its rate; 1: all of it. */
CORE_INLINE void coupled_correct(const coupled_params_t *p, coupled_state_t *x, float share) {
    x->gain_0 = 2.0f * share * p->gain_0;
    x->gain_w = 2.0f * share * p->gain_w;
}

/* How fast the flux is corrected until the next evaluation of lock.h. emf: magnitude of the
 * auxiliary flux's EMF [V]; i_q: torque current [A]; omega: electrical [rad/s]; used: whether the
 * drive runs on this observer; otherwise the rates stay as they were.
 * Less in braking: a generator with little voltage has no angle at which a wrong resistance comes
 * to rest, if the flux is corrected faster than that allows. More without torque current, where
 * nobody knows what dead time takes: docs/coupled-observer.md. */
CORE_INLINE void coupled_rates(const coupled_params_t *p, coupled_state_t *x, float k_s, float emf,
                               float i_q, float omega, int used) {
    if (SHORTCUT(!used)) {
        return;
    }
    float w = abs_f(omega);
    float takes = p->brake * -times_sign_f(i_q, omega) * (p->gain_0 + p->gain_w * w);
    float has = w * emf;
    float share = has < takes ? has / takes : 1.0f;
    share = max_f(share, p->brake_least + (1.0f - p->brake_least) * k_s);
    coupled_correct(p, x, used ? share : 1.0f);
    if (SHORTCUT(!(p->idle > 0.0f))) {
        return;
    }
    float idle = k_s * p->idle * max_f(1.0f - abs_f(i_q) * p->inv_i_idle, 0.0f);
    x->gain_0 += used ? idle : 0.0f;
}

/* One period. i_ab: measured current at k [A]; u_ab: voltage applied over [k-1, k] without
 * dead-time compensation [V]; k_s: weight of injection; err: angle error that it sees [rad]; learn:
 * 0, or what to learn besides the drift: odd the gain of the sensors, even their offsets. y: angle
 * and speed, advanced to k+1; r = rot_of(the angle of y at k). Returns how far the angle turns
 * beyond its speed [rad]. */
CORE_INLINE float coupled_observe(const coupled_params_t *p, const flux_model_t *m,
                                  coupled_state_t *x, emf_estimate_t *y, rot_t r, ab_t i_ab,
                                  ab_t u_ab, float k_s, float err, int learn, float T_s) {
    float rate = x->gain_0 + x->gain_w * abs_f(y->pll.omega);
    int led = abs_f(y->pll.omega) >= p->omega_floor || k_s > COUPLED_LED;
    int fresh = !led || !(y->valid > 0.0f);
    ab_t i_m = {0.5f * (i_ab.a + x->i_1.a), 0.5f * (i_ab.b + x->i_1.b)};
    const drift_params_t *d = &p->drift;
    float loss = x->drift.loss;
    ab_t u_x = dead_time_excess(d->u_dt, d->u_dt_i, loss, d->inv_i_true * loss, i_m);
    ab_t psi_ab = {x->psi.a + T_s * (u_ab.a + u_x.a - m->R_s * i_m.a),
                   x->psi.b + T_s * (u_ab.b + u_x.b - m->R_s * i_m.b)};

    dq_t i = ab_to_dq(i_ab, r);
    flux_of_current_t model = flux_of_current(m, i);
    dq_t aux = model.aux;
    dq_t psi = ab_to_dq(psi_ab, r);
    psi.d = fresh ? model.psi.d : psi.d;
    psi.q = fresh ? model.psi.q : psi.q;
    dq_t e = {model.psi.d - psi.d, model.psi.q - psi.q};
    float eps = flux_across(&model, e);
    float along = flux_along(&model, e);
    float slide = p->inv_layer > 0.0f ? p->layer * tanh_f(along * p->inv_layer) : along;
    float gain = rate * slide;

    float e_h = k_s * err;
    float trust = x->drift.trust;
    float told = trust * trust * eps; /* a load leaves an error that is larger by the inverse */
    float load = bound_f(x->load + p->k_l * told, p->load_max);
    x->load = fresh ? 0.0f : load;
    x->eps_f += p->alpha_rise * (told - x->eps_f);
    float rise = clamp_f(p->rise * (abs_f(x->eps_f) - p->eps_rise), 0.0f, p->rise_max);
    float f = trust * (1.0f + rise); /* of the bandwidth in force */
    float f_eps = f * eps;

    float motion = p->k_tau * (psi.d * i.q - psi.q * i.d) + x->load;
    float omega = y->pll.omega + T_s * (p->k_i * f * f_eps + motion);
    float turn = p->k_h * e_h;
    float jump = p->k_p * f_eps + turn;
    float share = drift_load(d, i.q);
    float nu = T_s * drift_turn(&x->drift, share);
    y->pll.omega = bound_f(omega, p->omega_max);
    y->pll.theta = wrap_pi(y->pll.theta + (T_s * y->pll.omega + jump));
    dq_t next = {psi.d + gain * aux.d - turn * aux.q - nu * psi.q,
                 psi.q + gain * aux.q + turn * aux.d + nu * psi.d};
    x->psi = dq_to_ab(next, r);

    float emf = y->pll.omega * aux.d;
    y->e.a = -r.s * emf;
    y->e.b = r.c * emf;
    y->err = eps;
    y->valid = led ? 1.0f : 0.0f;
    drift_learn(d, &x->drift, learn > 0, k_s, e_h, i.q, share, y->pll.omega);
    if (SHORTCUT(learn <= 0)) {
        return jump;
    }
    match_gain(&p->match, &x->match, learn > 0 && (learn & 1) != 0, i_ab, r, aux, model.inv, m->L_d,
               m->L_qq, along, y->pll.omega, k_s);
    float square = x->drift.trust * x->drift.trust; /* as for load; and for the error's variance */
    match_offset(&p->match, &x->match, learn > 0 && (learn & 1) == 0, r, aux, model.inv,
                 square * square * y->err, y->pll.omega);
    return jump;
}

#endif
