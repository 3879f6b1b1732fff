/* Lost lock: the test of the speed, the pole by the EMF, and a damaged drive that must not start. */
#include <string.h>

#include "checks.h"
#include "params.h"

static void speed(void) {
    check("reasons", LOCK_EMF == 1 && LOCK_SPEED == 2 && LOCK_CURRENT == 4);
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

/* One period at the end of LOCK, without current; turns: speed of the injection estimator, e: EMF
 * over psi_f. */
static void pole(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 3000; j++) {
        drive_state_t x;
        drive_init(p, &x, 0.0f, 0.0f, 0.5f);
        drive_find_again(&x);
        start_enter(&x.start, START_LOCK);
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
        check("pole: angle", fabs(wrapped((double)x.hfi.pll.theta - at - south)) < 1e-4);
        check("pole: speed", !told || near((double)x.emf.pll.omega, south > 0.0 ? -by : by, 1e-3));
    }
}

/* The last period of a pair of pulses, without current. */
static void pulses(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 200; j++) {
        drive_state_t x;
        drive_init(p, &x, 0.0f, 0.0f, 0.5f);
        drive_find_rotor(&x);
        start_enter(&x.start, START_POLE);
        x.start.n = 2 * (p->start.n_rest + 2 * p->start.n_pulse) - 1;
        float theta = draw_f(-3, 3), sure = p->start.i_pole_sure * draw_f(1.01, 3);
        x.hfi.pll.theta = theta, x.start.i_pole = j % 2 ? sure : -sure;
        drive_step(p, &x, &in);
        double south = x.start.i_pole * p->start.i_pole < 0.0f ? M_PI : 0.0;
        check("pulses: pole", x.start.phase == START_SETTLE &&
                                  fabs(wrapped((double)(x.hfi.pll.theta - theta) - south)) < 1e-4);
    }
}

/* FLY ends sooner after lost lock. */
static void fly(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int again = 0; again < 2; again++) {
        drive_state_t x;
        drive_init(p, &x, 0.0f, 0.0f, 0.5f);
        drive_find_again(&x);
        start_enter(&x.start, START_FLY);
        x.start.again = again;
        int n = 0;
        x.flux.psi.a = x.flux.psi.b = 1.0f, x.emf.pll.omega = 70.0f;
        for (; n < 1000 && x.start.phase == START_FLY; n++) {
            drive_step(p, &x, &in);
            check("injection follows",
                  x.start.phase != START_FLY || x.hfi.pll.omega == x.est.omega);
        }
        check("length of FLY", n == (again ? p->start.n_again : p->start.n_fly));
        check("flux starts again", x.flux.psi.a == 0.0f && x.flux.psi.b == 0.0f);
    }
    drive_state_t x;
    drive_init(p, &x, 0.0f, 0.0f, 0.5f);
    x.control.u_int.d = x.control.u_int.q = x.control.i_d_fw = -9.0f;
    x.smo.z.a = x.smo.z.b = x.emf.e.a = x.emf.e.b = x.control.i_ref.q = 7.0f;
    drive_find_again(&x);
    check("no kick",
          x.control.u_int.d == 0.0f && x.control.u_int.q == 0.0f && x.control.i_d_fw == 0.0f);
    check("nothing of before", x.smo.z.a == 0.0f && x.smo.z.b == 0.0f && x.emf.e.a == 0.0f &&
                                   x.emf.e.b == 0.0f && x.control.i_ref.q == 0.0f);
}

/* SCAN injects n_scan periods along each axis, and waits for two answers. */
static void scan(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    drive_state_t x;
    drive_init(p, &x, 0.0f, 0.0f, 0.5f);
    drive_find_rotor(&x);
    start_enter(&x.start, START_SCAN);
    int n = 0;
    for (; n < 1000 && x.start.phase == START_SCAN; n++) {
        drive_step(p, &x, &in);
    }
    check("length of SCAN", n == 2 * p->start.n_scan + 2);
}

/* Dead time is compensated by the mean of two samples, also while the drive seeks its rotor. */
static void compensated(void) {
    const drive_params_t *p = &PARAMS[4];
    for (int j = 0; j < 40; j++) {
        drive_state_t x;
        drive_init(p, &x, 0.0f, 0.0f, 0.5f);
        drive_find_rotor(&x);
        start_enter(&x.start, START_SCAN);
        drive_in_t in = {draw_f(-1, 1), draw_f(-1, 1), 540.0f, 0.0f, 0.0f};
        ab_t was = {draw_f(-1, 1), draw_f(-1, 1)}, i = phases_to_ab(in.i_a, in.i_b);
        x.start.i_1 = was;
        ab_t u = drive_step(p, &x, &in);
        ab_t mean = dq_to_ab((dq_t){0.5f * (i.a + was.a), 0.5f * (i.b + was.b)}, rot_of(0.0f));
        ab_t comp = dead_time_voltage(p->control.u_dt, p->control.inv_i_dt, mean);
        check("seeking: dead time", near_v(of_ab(u) - of_ab(x.u_1), of_ab(comp), 1e-4));
    }
}

/* A start sequence whose counters or phase it never writes is damaged. */
static void unsound(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 4; j++) {
        drive_state_t x;
        drive_init(p, &x, 0.0f, 0.0f, 0.5f);
        drive_find_rotor(&x);
        x.start.n = j == 1 ? -1 : x.start.n;
        x.start.tries = j == 2 ? -1 : x.start.tries;
        x.start.phase = j == 3 ? START_END : x.start.phase;
        ab_t u = drive_step(p, &x, &in);
        check("seeking: damaged", (x.fault == FAULT_STATE) == (j > 0));
        check("seeking: no voltage", j == 0 || (u.a == 0.0f && u.b == 0.0f));
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
    pole();
    pulses();
    fly();
    scan();
    compensated();
    unsound();
    act();
    mend();
}
