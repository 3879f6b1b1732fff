/* After lost lock: the pole by the EMF, what is done, and a damaged drive that must not start. */
#include "checks.h"
#include "params.h"

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
        x.start.n = 2 * (p->start.n_rest + 2 * p->start.n_pulse) + 1;
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
        dq_t i = {2.0f, 3.0f};
        x.control.i = i;
        x.hfi.err = 0.5f, x.hfi.amplitude = 2.0f, x.hfi.valid = 1.0f;
        drive_act(&p, &x);
        int stop = j % 2 || tried >= p.lock.restarts;
        check("act: phase", x.start.phase == (stop ? START_STOPPED : START_QUIET));
        check("act: signals rest",
              stop || (x.hfi.err == 0.0f && x.hfi.amplitude == 0.0f && x.hfi.valid == 0.0f &&
                       x.control.i.d == 0.0f && x.control.i.q == 0.0f));
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
        vec_t turned = psi * cexp(I * (double)x.est.theta); /* the next period goes on from k */
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
    for (int j = 0; j < 15; j++) {
        drive_params_t p = PARAMS[4];
        p.lock.action = j % 3;
        drive_state_t x;
        drive_init(&p, &x, 0.0f, 0.0f, 0.5f);
        x.fault = j / 3 == 1 ? FAULT_STOPPED | FAULT_U_DC : FAULT_U_DC;
        x.start.phase = j / 3 == 2 ? START_STOPPED : x.start.phase;
        x.begun = j / 3 == 3 ? 0 : j / 3 == 4 ? DRIVE_TRIPPED : x.begun;
        int32_t trip = j / 3 == 4 ? FAULT_OVER_CURRENT : 0;
        int stop = p.lock.action == LOCK_STOP || j / 3 == 1 || j / 3 == 2 || trip != 0;
        ab_t u = drive_mend(&p, &x);
        check("mend: phase", x.start.phase == (stop ? START_STOPPED : START_CATCH));
        int32_t bits = FAULT_U_DC | FAULT_STATE | (stop ? FAULT_STOPPED : 0);
        check("mend: faults", x.fault == (bits | trip));
        check("mend: trip", x.begun == (trip != 0 ? DRIVE_TRIPPED : DRIVE_BEGUN));
        check("mend: no voltage", u.a == 0.0f && u.b == 0.0f);
    }
}

/* Phase, bit or trip: each is enough to stop, and none goes back to seeking. */
static void stopped(void) {
    const drive_in_t in = {0.0f, 0.0f, PARAMS[4].guard.u_dc_max, 0.0f, 1.0f};
    for (int j = 0; j < 6; j++) {
        drive_state_t x;
        drive_init(&PARAMS[4], &x, 0.0f, 0.0f, 1.0f);
        x.start.phase = j == 0 ? START_STOPPED : j % 4 == 1 ? START_SCAN : START_DONE;
        x.fault = j == 1 || j == 2 ? FAULT_STOPPED : 0;
        x.begun = j == 3 ? 0 : j > 3 ? DRIVE_TRIPPED : x.begun;
        int32_t before = x.start.phase;
        drive_find_rotor(&x);
        check("stopped: find", x.start.phase == before && (x.fault & FAULT_COMMAND) != 0);
        if (j != 3) {
            x.lock.wait = j % 4 == 1 ? x.lock.wait : 1; /* in control: with the lock's next test */
            int32_t over = j > 3 ? FAULT_OVER_CURRENT : 0;
            drive_step(&PARAMS[4], &x, &in);
            ab_t u = drive_step(&PARAMS[4], &x, &in);
            check("stopped: step", x.start.phase == START_STOPPED && u.a == 0.0f && u.b == 0.0f);
            check("stopped: bits", (x.fault & (FAULT_STOPPED | over)) == (FAULT_STOPPED | over));
            check("stopped: trip", x.begun == (j > 3 ? DRIVE_TRIPPED : DRIVE_BEGUN));
        }
    }
}

void check_restart(void) {
    pole();
    settles();
    pulses();
    act();
    change();
    mend();
    stopped();
}
