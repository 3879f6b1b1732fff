/* The whole drive: damage, a closed loop with a machine of constant inductances, and the
 * sum over a trajectory of states. */
#include <string.h>

#include "checks.h"
#include "params.h" /* made by run.py: PARAMS[5] of the paper's machine, one per estimator */

typedef struct {
    vec_t psi; /* rotor frame */
    double theta, omega;
} machine_t;

static vec_t current(const machine_t *m) {
    return ((creal(m->psi) - 0.993) / 0.063 + I * cimag(m->psi) / 0.286);
}

/* One PWM period under the voltage u, in small steps; tau: load torque; J: 0 holds the speed. */
static void advance(machine_t *m, vec_t u, double tau, double J) {
    for (int k = 0; k < 20; k++) {
        double h = 1e-5;
        vec_t i = current(m);
        m->psi += h * (u * cexp(-I * m->theta) - 2.484 * i - I * m->omega * m->psi);
        m->theta = wrapped(m->theta + h * m->omega);
        double made = 3.0 * cimag(conj(m->psi) * i);
        m->omega += J > 0.0 ? 2.0 * h * (made - tau) / J : 0.0;
    }
}

/* Runs a drive; the sample of a period is taken before its voltage acts one period later. */
static void loop(const drive_params_t *p, drive_state_t *x, machine_t *m, int n, float w_ref,
                 float k_s, double tau, double J) {
    vec_t u = of_ab(x->u_1);
    for (int k = 0; k < n; k++) {
        vec_t i = current(m) * cexp(I * m->theta);
        drive_in_t in = {(float)creal(i), (float)creal(i * cexp(-I * 2.0 * M_PI / 3.0)), 540.0f,
                         w_ref, k_s};
        vec_t next = of_ab(drive_step(p, x, &in));
        advance(m, u, tau, J);
        u = next;
    }
}

static machine_t at(double theta, double omega) {
    machine_t m = {0.993, theta, omega};
    return m;
}

static void closed_loops(void) {
    for (int e = 0; e < 5; e++) {
        drive_params_t p = PARAMS[e];
        p.control.u_dt = 0.0f, p.coupled.drift.u_dt = 0.0f; /* an inverter without dead time */
        for (int case_ = 0; case_ < 4; case_++) {
            double w = case_ < 2 ? 20.0 : 200.0, sign = case_ % 2 ? -1.0 : 1.0;
            float k_s = case_ < 2 ? 1.0f : 0.0f;
            drive_state_t x;
            machine_t m = at(0.5, sign * w);
            drive_init(&p, &x, 0.4f, (float)m.omega, k_s);
            loop(&p, &x, &m, 2500, (float)(sign * w), k_s, sign * 5.0, 0.02);
            double err = wrapped(m.theta - (double)x.est.theta);
            check("closed loop: angle", fabs(err) < 0.25);
            check("closed loop: speed", fabs(m.omega - sign * w) < 3.0);
            check("closed loop: no fault", x.fault == 0);
            check("closed loop: weight", x.k_s == k_s);
        }
    }
}

static void starts(void) {
    for (int j = 0; j < 6; j++) {
        drive_params_t p = PARAMS[4];
        p.control.u_dt = 0.0f, p.coupled.drift.u_dt = 0.0f;
        machine_t m = at(-2.5 + j, j < 3 ? 250.0 - 250.0 * j : 0.0);
        drive_state_t x;
        drive_init(&p, &x, (float)(m.theta + (j < 3 ? 2.0 : 0.7)), 0.0f, 0.5f);
        drive_find_rotor(&x);
        int n = 0;
        for (; n < 900 && x.start.phase != START_DONE; n++) {
            loop(&p, &x, &m, 1, 0.0f, 1.0f, 0.0, 0.0);
        }
        double err = fabs(wrapped(m.theta - (double)x.est.theta));
        check("start: ends", x.start.phase == START_DONE);
        int knows = fabs(m.omega) > 100.0;
        check("start: angle", (knows || j >= 3 ? err : fmin(err, M_PI - err)) < 0.15);
        check("start: speed", fabs((double)x.est.omega - m.omega) < 15.0);
        check("start: pole", ((x.fault & FAULT_POLE) != 0) == !knows);
        check("start: flies", n == (knows ? p.start.n_catch + p.start.n_fly : n));
    }
}

/* Damage to each word: no voltage beyond the limit, and a sound state again after a period; counters
 * after a test of the lock. */
static void damage(void) {
    enum { WORDS = sizeof(drive_state_t) / sizeof(float) };
    const uint32_t bad[3] = {0x7FC00000U, 0x7F800000U, 0x7149F2CAU};
    for (int j = 0; j < 3 * WORDS; j++) {
        drive_state_t x;
        machine_t m = at(0.5, 100.0);
        drive_init(&PARAMS[j % 5], &x, 0.5f, 100.0f, 0.5f);
        loop(&PARAMS[j % 5], &x, &m, 20, 100.0f, 0.5f, 0.0, 0.02);
        uint32_t word[WORDS];
        memcpy(word, &x, sizeof x);
        word[j / 3] = bad[j % 3];
        memcpy(&x, word, sizeof x);
        drive_in_t in = {0.1f, 0.1f, 540.0f, 100.0f, 0.5f};
        for (int k = 0; k <= PARAMS[j % 5].lock.n; k++) {
            ab_t u = drive_step(&PARAMS[j % 5], &x, &in);
            check("damage: voltage", fabs((double)u.a) <= 1215.0 && fabs((double)u.b) <= 1215.0);
        }
        int sound = 1;
        memcpy(word, &x, sizeof x);
        for (int k = 0; k < WORDS; k++) {
            sound = sound && (word[k] & 0x7FFFFFFFU) < 0x58635FA9U;
        }
        check("damage: heals", sound);
    }
}

/* How the parts meet in a period, at a torque current with cross-coupling. */
static void meets(int j) {
    const int e = j % 5;
    drive_params_t p = PARAMS[e];
    drive_state_t x;
    drive_init(&p, &x, draw_f(-3, 3), j % 2 ? draw_f(60, 300) : draw_f(-300, -60), 0.5f);
    x.hfi.pll.theta = (float)wrapped((double)x.est.theta + draw(-0.3, 0.3));
    x.emf.pll.theta = (float)wrapped((double)x.est.theta + draw(-0.3, 0.3));
    x.control.i.q = draw_f(2, 6) * (j % 3 ? 1.0f : -1.0f), x.control.i_1.q = x.control.i.q;
    x.hfi.sign_2 = 1.0f, x.hfi.sign_3 = -1.0f;
    drive_state_t was = x;
    ab_t i = {draw_f(-5, 5), draw_f(-5, 5)};
    curve_pos_t pos = curve_locate(was.control.i.q, p.control.curve_inv_step);
    double cross = sgn((double)was.control.i.q) * (double)curve_at(&p.theta_cross, pos);
    rot_t r = drive_observe(&p, &x, i, 0.8f);
    check("meets: weight", near((double)x.k_s, 0.5 + fmin((double)p.k_s_step, 0.3), 1e-6));
    check("meets: direction",
          near_v((double)r.c + I * (double)r.s, cexp(I * (double)x.est.theta), 1e-6));
    double own = (double)was.emf.pll.theta;
    int one = e == ESTIMATE_COUPLED || e == ESTIMATE_ERRORS; /* one angle for both */
    double axis = one ? own - cross : (double)was.hfi.pll.theta;
    check("meets: frame of injection", near_v(of_dq(x.hfi.i_1), of_ab(i) * cexp(-I * axis), 3e-4));
    double both = one ? own : own + (double)x.k_s * wrapped(axis + cross - own);
    if (e != ESTIMATE_UNWRAPPED) {
        check("meets: estimate", fabs(wrapped((double)x.est.theta - both)) < 3e-6);
    }
    if (e == ESTIMATE_COUPLED) {
        double err = bounded((double)p.coupled.inv_slope * (double)x.hfi.err, 1.0);
        check("meets: one angle",
              fabs(wrapped((double)x.hfi.pll.theta - (double)x.emf.pll.theta + cross)) < 2e-6);
        double beyond = (double)x.emf.pll.theta - own - (double)p.T_s * (double)x.emf.pll.omega;
        check("meets: jump of the frame", fabs(wrapped(beyond) - (double)x.hfi.jump) < 2e-6);
        check("meets: angles shown",
              fabs(wrapped((double)x.theta_hfi - own - err)) < 2e-6 &&
                  fabs(wrapped((double)x.theta_smo - own - (double)x.emf.err)) < 2e-6);
    } else {
        check("meets: angles shown", fabs(wrapped((double)x.theta_hfi - axis - cross)) < 2e-6 &&
                                         x.theta_smo == was.emf.pll.theta);
    }
    if (e == ESTIMATE_FLUX) {
        flux_state_t flux = was.flux;
        emf_estimate_t y = was.emf;
        double lead = (double)x.k_s * wrapped(axis + cross - own);
        flux_model_t m = drive_flux_model(&p, pos);
        const coupled_params_t *c = &p.coupled;
        check("meets: flux of the machine",
              m.R_s == c->R_s && m.L_d == c->L_d && m.psi_sq_min == c->psi_sq_min &&
                  m.L_q == curve_at(&p.L_q, pos) && m.L_qq == curve_incremental(&p.L_q, pos) &&
                  m.psi_0 == curve_at(&c->psi_d, pos));
        flux_observe(&p.flux, &m, &flux, &y, i, was.coupled.i_1, was.u_2, x.est.omega, x.est.theta,
                     (float)lead, p.T_s);
        check("meets: lead", near_v(of_ab(flux.psi), of_ab(x.flux.psi), 1e-6));
    }
    drive_in_t in = {1, 1, 540.0f, 90.0f, 0.5f};
    ab_t before = x.u_1;
    ab_t u = drive_actuate(&p, &x, &in, i, x.est, r, 1.0f);
    rot_t at_hfi = hfi_direction(&p.hfi, &x.hfi, p.T_s);
    vec_t comp = of_ab(u) - of_ab(x.u_1);
    double acts = 1.5 * (double)p.T_s * (double)x.est.omega; /* turn until the voltage acts */
    vec_t mean = of_dq(x.control.i) * ((double)r.c + I * (double)r.s) * cexp(I * acts);
    ab_t along = {(float)creal(mean), (float)cimag(mean)};
    check("meets: dead time",
          near_v(comp, of_ab(dead_time_voltage(p.control.u_dt, p.control.inv_i_dt, along)), 1e-3));
    check("meets: queue", x.u_2.a == before.a && x.u_2.b == before.b);
    double limit = 540.0 / sqrt(3.0) - (double)p.hfi.u_inj;
    vec_t injected = (double)p.hfi.u_inj * ((double)at_hfi.c + I * (double)at_hfi.s);
    double size = fmin((double)x.control.u_abs, limit);
    check("meets: injection on top", near(cabs(of_ab(x.u_1) - injected), size, 1e-4));
}

static void begins(void) {
    drive_state_t x;
    for (int j = 0; j < 2; j++) {
        drive_init(&PARAMS[4], &x, j ? 1.05e4f : -1.05e4f, 0.0f, 0.5f);
        check("init: far angle", x.fault == FAULT_COMMAND && x.est.theta == 0.0f);
        drive_init(&PARAMS[4], &x, j ? 0.95e4f : -0.95e4f, 0.0f, 0.5f);
        check("init: many turns", x.fault == 0 && fabs((double)x.est.theta) <= 3.1416);
    }
    memset(&x, 0x7F, sizeof x);
    drive_init(&PARAMS[4], &x, 10.0f, -800.0f, 1.5f);
    check("init: clamps", fabs((double)x.est.theta - wrapped(10.0)) < 1e-5 &&
                              near((double)x.est.omega, (double)-PARAMS[4].guard.omega, 1e-6) &&
                              x.k_s == 1.0f);
    check("init: says so", x.fault == FAULT_COMMAND);
    memset(&x, 0x7F, sizeof x);
    drive_init(&PARAMS[4], &x, 1.0f, 50.0f, 0.25f);
    const float *w = (const float *)(const void *)&x;
    double sum = 0.0;
    for (unsigned k = 0; k < sizeof x / sizeof *w; k++) {
        sum += fabs((double)w[k]);
    }
    double ready = fabs((double)x.control.i_int);
    ready += fabs((double)x.control.i_d_end);
    check("init: gives way at its end", x.control.i_d_end == PARAMS[4].control.i_d_min);
    ready += (double)PARAMS[4].coupled.drift.u_dt;              /* lost as the drive compensates */
    ready += fabs((double)PARAMS[4].coupled.drift.ind_0) + 1.0; /* all trust in the flux */
    ready += 2.0 * (double)PARAMS[4].coupled.gain_0;            /* all of the flux correction */
    ready += 2.0 * (double)PARAMS[4].coupled.gain_w;
    check("init: low inductance", x.coupled.drift.ind == PARAMS[4].coupled.drift.ind_0);
    check("init: nothing else", near(sum, 5.0 * 1.0 + 8.0 * 50.0 + 2.0 * 0.25 + 1.0 + ready, 1e-5));
    check("init: no fault", x.fault == 0 && x.begun == DRIVE_BEGUN && x.start.phase == START_DONE);
}

static uint32_t mix_in(uint32_t sum, const void *data, size_t words) {
    const uint32_t *w = data;
    for (size_t k = 0; k < words; k++) {
        sum = (sum ^ w[k]) * 16777619U;
        sum ^= sum >> 15;
    }
    return sum;
}

/* States of all estimators over starts, hand-overs, light load and limits. */
uint32_t trajectory(void) {
    uint32_t sum = 2166136261U;
    for (int e = 0; e < 5; e++) {
        for (int seek = 0; seek < 2; seek++) {
            drive_state_t x;
            machine_t m = at(0.5, seek ? 0.0 : 60.0);
            drive_init(&PARAMS[e], &x, 0.4f, (float)m.omega, 1.0f);
            if (seek) {
                drive_find_rotor(&x);
            }
            for (int k = 0; k < 24; k++) {
                loop(&PARAMS[e], &x, &m, 40, k < 8 ? 60.0f : (k < 16 ? 330.0f : -40.0f),
                     (float)(k % 5) * 0.25f, k % 7 < 3 ? 8.0 : 0.0, 0.02);
                sum = mix_in(sum, &x, sizeof x / 4);
            }
        }
    }
    return sum;
}

void check_drive(void) {
    begins();
    for (int j = 0; j < 300; j++) {
        meets(j);
    }
    damage();
    closed_loops();
    starts();
}
