/* Lost lock: its tests, the pole by the EMF, and a damaged drive that must not start. */
#include <string.h>

#include "checks.h"
#include "params.h"

static void speed(void) {
    check("reasons", LOCK_EMF == 1 && LOCK_SPEED == 2 && LOCK_CURRENT == 4 && LOCK_ANSWER == 8);
    check("actions", LOCK_REPORT == 0 && LOCK_RESTART == 1 && LOCK_STOP == 2);
    lock_params_t p = PARAMS[4].lock;
    p.i_off = 1e9f, p.e_floor = 1e9f;
    for (int j = 0; j < 400; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        lock_begin(&p, &x, draw_f(-300, 300));
        x.bad = p.n_alarm;
        double was = (double)x.omega, now = was + draw(-2, 2) * (double)p.jump;
        double to = was + (double)p.alpha * ((double)(float)now - was);
        double beyond = fabs((double)(float)now - to) / (double)p.jump - 1.0;
        lock_judge(&p, &x, (float)now, 0.0f);
        check("speed: low-pass", near((double)x.omega, to, 1e-5));
        if (fabs(beyond) > 0.01) {
            check("speed: told", x.alarm == (beyond > 0.0) && x.reason == (beyond > 0.0 ? 2 : 0));
        }
    }
}

/* The first test of a drive in control comes LOCK_FIRST periods after it began, then one every n. */
static void first(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.5f};
    drive_state_t x;
    drive_init(p, &x, 0.0f, 0.0f, 0.5f);
    for (int k = 1; k < 4 * p->lock.n; k++) {
        drive_step(p, &x, &in);
        int left = LOCK_FIRST - k;
        check("tests: in turn",
              x.lock.wait == (left > 0 ? left : p->lock.n - (k - LOCK_FIRST) % p->lock.n));
    }
    x.lock.wait = p->lock.n + LOCK_FIRST + 2; /* damage */
    drive_step(p, &x, &in);
    check("tests: damaged", x.lock.wait == p->lock.n);
}

/* The answer to the injection, less the least one, low-passed; told below 0. */
static void injected(void) {
    lock_params_t p = PARAMS[4].lock;
    const float limit[3] = {-1e-30f, 0.0f, 1e-30f};
    for (int j = 0; j < 3; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        x.bad = p.n_alarm, x.answer = limit[j];
        lock_judge(&p, &x, 0.0f, 0.0f);
        check("answer: told", x.reason == (j == 0 ? LOCK_ANSWER : 0));
        lock_begin(&p, &x, 0.0f);
        check("answer: anew", x.answer == 0.0f);
    }
    for (int j = 0; j < 100; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        p.leads = j % 4 < 2 ? 0.5f : 0.0f;
        float k_s = j % 3 == 0 ? p.leads : draw_f(0, 1);
        float was = draw_f(-1, 1), seen = draw_f(-1, 1), u = draw_f(10, 90);
        double least = (double)p.answer * (double)u;
        x.answer = was;
        lock_answer(&p, &x, seen, j % 2 ? 1.0f : 0.0f, u, k_s);
        double more = j % 2 && k_s >= p.leads ? (double)seen - least : least;
        double to = (double)was + (double)p.alpha * (more - (double)was);
        check("answer: low-pass", fabs((double)x.answer - to) < 1e-6);
    }
}

/* The EMF's part of an evaluation: r and the EMF expected, both low-passed, from a drive's state. */
static void sums(void) {
    drive_params_t p = PARAMS[4];
    for (int j = 0; j < 300; j++) {
        drive_state_t x;
        drive_init(&p, &x, 0.0f, 0.0f, 0.5f);
        x.est.omega = draw_f(-500, 500);
        x.control.i.d = draw_f(-5, 5), x.control.i.q = draw_f(-5, 5);
        x.control.i_ref.q = draw_f(-5, 5), x.control.u_int.q = draw_f(-50, 50);
        x.control.u_max = 250.0f, x.control.u_abs = draw_f(100, 400);
        x.k_s = draw_f(0, 1), x.hfi.answer = draw_f(-1, 1);
        x.hfi.valid = j % 2 ? 1.0f : 0.0f;
        x.lock.i_q = draw_f(-5, 5), x.lock.residual = draw_f(-9, 9), x.lock.emf = draw_f(0, 90);
        const lock_state_t was = x.lock;
        const control_params_t *c = &p.control;
        double omega = (double)x.est.omega, i_d = (double)x.control.i.d,
               i_q = (double)x.control.i.q;
        curve_pos_t pos = curve_locate(x.control.i.q, c->curve_inv_step);
        double L_q = (double)(p.lock.L_q_true * curve_at(&p.L_q, pos)), L_d = (double)c->L_d;
        double psi_0 = (double)curve_at(&p.coupled.psi_d, pos);
        double u_q = (double)(c->k_t_q * x.control.i_ref.q - c->k_p_q * x.control.i.q) +
                     (double)x.control.u_int.q + omega * (L_d * i_d + (double)c->psi_f);
        u_q *= fmin(1.0, 250.0 / (double)x.control.u_abs);
        double r = u_q - (double)p.lock.R_s * i_q - omega * (psi_0 + L_d * i_d) -
                   (double)p.lock.inv_t * L_q * (i_q - (double)was.i_q);
        double psi_a = fmin(psi_0 + (L_d - L_q) * i_d, 2.0 * psi_0);
        double emf = fabs(omega * psi_a), alpha = (double)p.lock.alpha;
        drive_watch(&p, &x);
        double to = (double)was.residual + alpha * (r - (double)was.residual);
        check("EMF: residual", near((double)x.lock.residual, to, 1e-4));
        to = (double)was.emf + alpha * (emf - (double)was.emf);
        check("EMF: expected", near((double)x.lock.emf, to, 1e-4) && x.lock.i_q == x.control.i.q);
        lock_state_t answer = was;
        lock_answer(&p.lock, &answer, x.hfi.answer, x.hfi.valid, p.hfi.u_inj, x.k_s);
        check("answer: of the drive", x.lock.answer == answer.answer);
        double share = fmin(1.0, fmax(0.75, (double)x.control.u_max / (double)x.control.u_abs));
        double off = share * fabs((double)x.control.i.q - (double)x.control.i_ref.q);
        drive_judge(&p, &x);
        to = (double)was.i_off + alpha * (off - (double)was.i_off);
        check("tests: current", near((double)x.lock.i_off, to, 1e-5));
        check("tests: the next", x.lock.wait == p.lock.n);
    }
}

/* Alarms count once, end after n_clear good evaluations, and good ones alone never begin one. */
static void told_once(void) {
    lock_params_t p = PARAMS[4].lock;
    lock_state_t x;
    memset(&x, 0, sizeof x);
    for (int k = 0; k < 60; k++) {
        lock_judge(&p, &x, 0.0f, 0.0f);
        check("alarm: none", x.alarm == 0 && x.bad == 0 && x.alarms == 0);
    }
    for (int n = 1; n <= 3; n++) {
        for (int k = 0; k < 9; k++) {
            x.residual = 2.0f * p.e_floor;
            lock_judge(&p, &x, 0.0f, 0.0f);
            check("alarm: begins",
                  x.alarm == (k + 1 >= p.n_alarm) && x.reason == LOCK_EMF * x.alarm);
        }
        x.residual = 0.0f;
        for (int k = 1; k <= p.n_clear + 9; k++) {
            lock_judge(&p, &x, 0.0f, 0.0f);
            check("alarm: ends", x.alarm == (k < p.n_clear));
        }
        check("alarm: counted", x.alarms == n);
        x.reason = 0;
    }
    for (int n = 1; n <= p.n_grace + 1; n++) { /* counts down, nothing is judged; damage ends it */
        memset(&x, 0, sizeof x);
        x.bad = LOCK_GRACE + n, x.residual = 2.0f * p.e_floor;
        lock_judge(&p, &x, 0.0f, 0.0f);
        check("grace", x.bad == (n == 1 || n > p.n_grace ? 0 : LOCK_GRACE + n - 1) && !x.alarm);
    }
    for (int n = -2; n <= 1; n++) { /* restarts are forgotten once it was calm for n_calm */
        memset(&x, 0, sizeof x);
        x.calm = p.n_calm + n, x.restarts = 2;
        lock_judge(&p, &x, 0.0f, 0.0f);
        check("restarts: forgotten", x.restarts == (n >= -1 ? 0 : 2));
    }
    for (int n = -1; n <= 1; n++) {
        memset(&x, 0, sizeof x);
        p.action = LOCK_STOP, x.bad = p.n_act + n;
        check("acts", lock_acts(&p, &x, 0) == (n >= 0) && lock_acts(&p, &x, 1) == (n >= 0));
        p.action = LOCK_RESTART;
        check("acts: restart", lock_acts(&p, &x, 0) == (n >= 0) && lock_acts(&p, &x, 1));
        x.bad = p.n_alarm + n;
        check("acts: change", !lock_acts(&p, &x, 0) && lock_acts(&p, &x, 1) == (n >= 0));
        p.action = LOCK_REPORT;
        check("acts: report", !lock_acts(&p, &x, 1));
        p.action = LOCK_STOP, x.bad = p.n_act + n, x.calm = 1;
        check("calm", !lock_acts(&p, &x, 0));
    }
}

/* One period at the end of LOCK, without current; turns: speed of the injection estimator, e: EMF
 * over psi_f. */
static void pole(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 3000; j++) {
        drive_state_t x = seeking(p, START_LOCK, 1);
        x.start.n = p->start.n_lock - 1;
        x.start.again = j % 4 != 0;
        double turns = draw(-90, 90), theta = draw(-3, 3);
        vec_t e = (double)p->control.psi_f * draw(-110, 110) * I * cexp(I * theta);
        x.hfi.pll.theta = (float)theta, x.hfi.pll.omega = (float)turns;
        x.start.e_f.a = (float)creal(e), x.start.e_f.b = (float)cimag(e);
        drive_step(p, &x, &in);
        double at = theta + (double)p->T_s * turns;
        double by = cimag(of_ab(x.start.e_f) * cexp(-I * at)) / (double)p->control.psi_f;
        double far = fabs(fabs(by) / (double)p->start.omega_pole - 1.0);
        if (far < 1e-3 || fabs(fabs(turns) / fabs(by) - 0.5) < 1e-3) {
            continue;
        }
        int told = fabs(by) >= (double)p->start.omega_pole && fabs(turns) >= 0.5 * fabs(by);
        told = told && x.start.again;
        double south = told && by * turns < 0.0 ? M_PI : 0.0;
        check("pole: told", x.start.phase == (told ? START_DONE : START_POLE));
        check("pole: no fault", !told || x.fault == 0);
        check("pole: angle", fabs(wrapped((double)x.hfi.pll.theta - at - south)) < 1e-4);
        check("pole: speed", !told || near((double)x.emf.pll.omega, south > 0.0 ? -by : by, 1e-3));
    }
}

/* At the end of SETTLE the EMF has the last word, if the drive had lost its rotor. */
static void settles(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 4; j++) {
        drive_state_t x = seeking(p, START_SETTLE, 1);
        x.start.n = p->start.n_lock - 1;
        x.start.again = j % 2;
        float by = (j < 2 ? -3.0f : 3.0f) * p->start.omega_pole;
        x.start.e_f.b = by * p->control.psi_f;
        x.hfi.pll.omega = 3.0f * p->start.omega_pole;
        drive_step(p, &x, &in);
        double south = j == 1 ? M_PI : 0.0;
        check("settles", x.start.phase == START_DONE);
        check("settles: pole", fabs(wrapped((double)x.emf.pll.theta - south)) < 0.2);
    }
}

/* The last period of a pair of pulses, without current. */
static void pulses(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 200; j++) {
        drive_state_t x = seeking(p, START_POLE, 0);
        x.start.n = 2 * (p->start.n_rest + 2 * p->start.n_pulse) - 1;
        float theta = draw_f(-3, 3), sure = p->start.i_pole_sure * draw_f(1.01, 3);
        x.hfi.pll.theta = theta, x.start.i_pole = j % 2 ? sure : -sure;
        drive_step(p, &x, &in);
        double south = x.start.i_pole * p->start.i_pole < 0.0f ? M_PI : 0.0;
        check("pulses: no fault", x.fault == 0);
        check("pulses: pole", x.start.phase == START_SETTLE &&
                                  fabs(wrapped((double)(x.hfi.pll.theta - theta) - south)) < 1e-4);
    }
}

/* What a drive does that has to act. */
static void act(void) {
    for (int j = 0; j < 8; j++) {
        drive_params_t p = PARAMS[4];
        p.lock.action = j % 2 ? LOCK_STOP : LOCK_RESTART;
        int tried = p.lock.restarts - 2 + j / 2;
        drive_state_t x;
        drive_init(&p, &x, 0.0f, 0.0f, 0.5f);
        x.lock.restarts = tried;
        x.lock.bad = p.lock.n_act;
        drive_act(&p, &x);
        int stop = j % 2 || tried >= p.lock.restarts;
        check("act: phase", x.start.phase == (stop ? START_STOPPED : START_QUIET));
        check("act: fault", x.fault == (stop ? FAULT_STOPPED : 0U));
        check("act: tries", x.lock.restarts == tried + !stop);
        drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
        ab_t u = drive_step(&p, &x, &in);
        check("act: no voltage",
              u.a == 0.0f && u.b == 0.0f && x.fault == (stop ? FAULT_STOPPED : 0U));
    }
}

/* The coupled observer takes over: angle one period ahead, flux of the current, balanced torque. */
static void change(void) {
    for (int j = 0; j < 200; j++) {
        drive_params_t p = PARAMS[j % 4];
        const coupled_params_t *c = &p.coupled;
        p.lock.action = LOCK_RESTART;
        drive_state_t x;
        drive_init(&p, &x, draw_f(-3, 3), draw_f(-500, 500), 0.5f);
        x.control.i.d = draw_f(-4, 1), x.control.i.q = draw_f(-5, 5);
        x.lock.bad = p.lock.n_alarm, x.coupled.drift.even = 1.0f, x.coupled.eps_f = 1.0f;
        drive_act(&p, &x);
        check("change: on", x.start.phase == START_DONE && x.start.again == 1 && x.fault == 0);
        check("change: once", x.lock.bad == p.lock.n_alarm && x.lock.restarts == 0);
        double ahead = (double)x.est.theta + (double)(p.T_s * x.est.omega);
        check("change: angle", fabs(wrapped((double)x.emf.pll.theta - ahead)) < 1e-5);
        check("change: speed", x.emf.pll.omega == x.est.omega && x.emf.valid == 1.0f);
        curve_pos_t pos = curve_locate(x.control.i.q, p.control.curve_inv_step);
        vec_t i = of_dq(x.control.i),
              psi = (double)(curve_at(&c->psi_d, pos) + c->L_d * x.control.i.d);
        psi += I * (double)curve_at(&p.L_q, pos) * cimag(i);
        vec_t turned = psi * cexp(I * ahead);
        check("change: flux", near_v(of_ab(x.coupled.psi), turned, 1e-5));
        double load = -(double)c->k_tau * cimag(conj(psi) * i);
        load = bounded(load, (double)c->load_max);
        check("change: load", fabs((double)x.coupled.load - load) < 1e-4 * (double)c->load_max);
        check("change: anew", x.coupled.drift.even == 0.0f && x.coupled.eps_f == 0.0f);
        drive_act(&p, &x);
        check("change: then restarts", x.start.phase == START_QUIET && x.lock.restarts == 1);
    }
}

static void mend(void) {
    for (int j = 0; j < 12; j++) {
        drive_params_t p = PARAMS[4];
        p.lock.action = j % 3;
        drive_state_t x;
        drive_init(&p, &x, 0.0f, 0.0f, 0.5f);
        x.fault = j / 3 == 1 ? FAULT_STOPPED | FAULT_U_DC : FAULT_U_DC;
        x.start.phase = j / 3 == 2 ? START_STOPPED : x.start.phase;
        int stop = p.lock.action == LOCK_STOP || j / 3 == 1 || j / 3 == 2;
        ab_t u = drive_mend(&p, &x);
        check("mend: phase", x.start.phase == (stop ? START_STOPPED : START_CATCH));
        check("mend: faults", x.fault == (FAULT_U_DC | FAULT_STATE | (stop ? FAULT_STOPPED : 0)));
        check("mend: no voltage", u.a == 0.0f && u.b == 0.0f);
    }
}

void check_lock(void) {
    speed();
    injected();
    pole();
    settles();
    pulses();
    sums();
    first();
    told_once();
    act();
    change();
    mend();
}
