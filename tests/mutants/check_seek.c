/* A drive that seeks its rotor: lengths of its phases, what it keeps, what it refuses. */
#include "checks.h"
#include "params.h"

/* FLY ends sooner after lost lock. */
static void fly(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int again = 0; again < 2; again++) {
        drive_state_t x = seeking(p, START_FLY, 1);
        x.start.again = again;
        int n = 0;
        x.flux.psi.a = x.flux.psi.b = 1.0f, x.emf.pll.omega = 70.0f;
        x.control.i_int = 3.0f, x.lock.turned = 7;
        for (; n < 1000 && x.start.phase == START_FLY; n++) {
            drive_step(p, &x, &in);
            check("load kept", (x.control.i_int == 3.0f) == again);
            check("pole kept", x.start.phase == START_FLY || x.lock.turned == 7 * again);
            check("injection follows",
                  x.start.phase != START_FLY || x.hfi.pll.omega == x.est.omega);
        }
        check("length of FLY", n == (again ? p->start.n_again : p->start.n_fly));
        check("sums anew", x.control.u_sum.q == 0.0f && x.control.i_sum.q == 0.0f);
        check("flux starts again", x.flux.psi.a == 0.0f && x.flux.psi.b == 0.0f);
    }
    drive_state_t x;
    drive_init(p, &x, 0.0f, 0.0f, 0.5f);
    x.control.u_int.d = x.control.u_int.q = x.control.i_d_fw = -9.0f;
    x.smo.z.a = x.smo.z.b = x.emf.e.a = x.emf.e.b = x.control.i_ref.q = 7.0f;
    drive_find_again(&x, START_OTHER_POLE);
    check("no kick",
          x.control.u_int.d == 0.0f && x.control.u_int.q == 0.0f && x.control.i_d_fw == 0.0f);
    check("nothing of before", x.smo.z.a == 0.0f && x.smo.z.b == 0.0f && x.emf.e.a == 0.0f &&
                                   x.emf.e.b == 0.0f && x.control.i_ref.q == 0.0f);
}

/* QUIET ends as soon as there is no current, and after n_quiet periods at the latest. */
static void quiet(void) {
    const drive_params_t *p = &PARAMS[4];
    for (int j = 0; j < 2; j++) {
        drive_in_t in = {2.0f * p->start.i_quiet * (float)j, 0.0f, 540.0f, 0.0f, 0.0f};
        drive_state_t x;
        drive_init(p, &x, 0.0f, 0.0f, 0.5f);
        drive_find_again(&x, START_OTHER_POLE);
        int n = 0;
        for (; n < 1000 && x.start.phase == START_QUIET; n++) {
            drive_step(p, &x, &in);
        }
        check("length of QUIET", n == (j ? p->start.n_quiet : 1));
    }
}

/* SCAN injects n_scan periods along each axis, and waits for two answers. */
static void scan(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    drive_state_t x = seeking(p, START_SCAN, 0);
    int n = 0;
    for (; n < 1000 && x.start.phase == START_SCAN; n++) {
        int wait = x.lock.wait;
        drive_step(p, &x, &in);
        check("tests in step", x.lock.wait == (wait > 1 ? wait - 1 : p->lock.n));
    }
    check("length of SCAN", n == 2 * p->start.n_scan + 2);
    start_enter(&x.start, START_SCAN);
    x.start.n = 2 * p->start.n_scan + 1, x.start.omega = 400.0f, x.start.e_f.a = 9.0f;
    x.est.theta = 1.5f, x.start.axis.a = 1.0f, x.start.axis.b = 0.0f;
    drive_step(p, &x, &in);
    check("the nearer end", fabs((double)x.hfi.pll.theta) < 1e-3);
    double most = cabs(of_ab(x.start.e_f)) / (double)p->control.psi_f;
    check("no faster than the EMF", near((double)x.hfi.pll.omega, most, 1e-4));
}

/* Dead time is compensated by the mean of two samples, also while the drive seeks its rotor. */
static void compensated(void) {
    const drive_params_t *p = &PARAMS[4];
    for (int j = 0; j < 40; j++) {
        drive_state_t x = seeking(p, START_SCAN, 0);
        drive_in_t in = {draw_f(-1, 1), draw_f(-1, 1), draw_f(9, 540), 0.0f, 0.0f};
        ab_t was = {draw_f(-1, 1), draw_f(-1, 1)}, i = phases_to_ab(in.i_a, in.i_b);
        x.start.i_1 = was;
        ab_t u = drive_step(p, &x, &in);
        ab_t mean = dq_to_ab((dq_t){0.5f * (i.a + was.a), 0.5f * (i.b + was.b)}, rot_of(0.0f));
        ab_t comp = dead_time_voltage(p->control.u_dt, p->control.inv_i_dt, mean);
        check("seeking: dead time", near_v(of_ab(u) - of_ab(x.u_1), of_ab(comp), 1e-4));
        check("seeking: voltage", cabs(of_ab(x.u_1)) < 1.00001 * (double)in.u_dc / sqrt(3.0));
    }
}

/* Injection goes on n_hold periods after the last weight that asked for it. */
static void injects(void) {
    hfi_params_t p = PARAMS[4].hfi;
    hfi_state_t x = {0};
    for (int k = 0; k < 9; k++) {
        check("injection: sign",
              hfi_inject(&p, &x, k == 0) == (k < p.n_hold ? (k % 2 ? -1.0f : 1.0f) : 0.0f));
        check("injection: held", x.hold == fmax(p.n_hold - k, 0.0));
    }
}

/* A shaft that spins: what the schedule reads is its speed at once, without a low-pass. */
static void spins(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 40; j++) {
        drive_state_t x;
        drive_init(p, &x, 0.0f, 0.0f, 0.5f);
        drive_find_rotor(&x);
        x.start.n = p->start.n_catch - 1;
        x.start.omega = draw_f(200, 400) * (j % 2 ? 1.0f : -1.0f);
        x.start.e_f.a = x.start.omega * p->control.psi_f;
        drive_step(p, &x, &in);
        double omega = (double)x.emf.pll.omega;
        check("spins", x.start.phase == START_FLY && omega * (double)x.start.omega > 0.0);
        double at = carg(of_ab(x.start.e_f) * (omega < 0.0 ? I : -I));
        at += (double)p->T_s * omega;
        check("spins: speed of the observer", x.smo.omega_f == x.emf.pll.omega);
        check("spins: angle", fabs(wrapped((double)x.emf.pll.theta - at)) < 1e-4);
        double kept = 1.0 - (double)p->signal.alpha; /* the estimate itself follows in FLY */
        check("spins: signal", near((double)x.signal.omega, kept * omega, 1e-4));
        kept = 1.0 - (double)p->signal.alpha * (double)p->signal.alpha;
        check("spins: second signal", near((double)x.signal.omega_2, kept * omega, 1e-4));
    }
}

/* LOCK injects along its axis, half a period on, and shows one angle; then POLE takes the EMF's speed. */
static void tracks(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    for (int j = 0; j < 40; j++) {
        drive_state_t x = seeking(p, START_LOCK, 1);
        x.start.n = j % 2 ? 0 : p->start.n_lock - 1;
        x.hfi.pll.theta = draw_f(-3, 3), x.hfi.pll.omega = draw_f(-90, 90);
        x.hfi.jump = 0.1f; /* left by the observer */
        x.start.e_f.a = draw_f(-9, 9), x.start.e_f.b = draw_f(-9, 9);
        float was = x.hfi.pll.theta;
        drive_step(p, &x, &in);
        check("tracks: no jump", x.hfi.jump == 0.0f);
        check("tracks: angles", x.est.theta == was && x.theta_hfi == was && x.theta_smo == was);
        if (x.start.phase == START_POLE) {
            vec_t e = of_ab(x.start.e_f) * cexp(-I * (double)x.hfi.pll.theta);
            double speed = fabs(cimag(e)) / (double)p->control.psi_f;
            check("pole: speed", near(fabs((double)x.hfi.pll.omega), speed, 1e-4));
            continue;
        }
        ab_t hold = start_turned(x.start.e_f, 1.5f * p->T_s * x.start.omega);
        double at = (double)x.hfi.pll.theta + 0.5 * (double)p->T_s * (double)x.hfi.pll.omega;
        vec_t inj = (of_ab(x.u_1) - of_ab(hold)) * cexp(-I * at) / (double)p->hfi.u_inj;
        check("tracks: injection", fabs(fabs(creal(inj)) - 1.0) < 1e-4 && fabs(cimag(inj)) < 1e-4);
    }
}

/* On a machine whose pulses cannot show the pole the guess decides, after as long as they take. */
static void guesses(void) {
    drive_params_t p = PARAMS[4];
    p.start.i_pole = 0.5f * p.start.i_pole_sure;
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    int pulses = p.start.n_tries * (2 * (p.start.n_rest + 2 * p.start.n_pulse) + 2);
    for (int last = 0; last < 2; last++) {
        drive_state_t x = seeking(&p, START_LOCK, 1);
        x.start.again = 1;
        x.start.n = 2 * p.start.n_lock + pulses - 2 + last;
        drive_step(&p, &x, &in);
        check("guess", x.start.phase == (last ? START_DONE : START_LOCK));
        check("guess: said", x.fault == (last ? FAULT_POLE : 0));
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
        x.start.phase = j == 3 ? START_CATCH ^ 1 : x.start.phase;
        ab_t u = drive_step(p, &x, &in);
        check("seeking: damaged", (x.fault == FAULT_STATE) == (j > 0));
        check("seeking: no voltage", j == 0 || (u.a == 0.0f && u.b == 0.0f));
    }
}

/* The axis that SCAN found, in the direction nearer to the angle of before, or to the other pole; and
 * turned on by the speed of the EMF, no faster than the EMF's magnitude allows. */
static void pole_after_scan(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    int turned[2] = {0, 0};
    for (int j = 0; j < 600; j++) {
        drive_state_t x = seeking(p, START_SCAN, j % 2);
        double at = draw(-3, 3), emf = draw(0, 1) * (double)p->start.e_fly;
        x.start.n = 2 * p->start.n_scan + 1, x.start.again = j % 3;
        x.start.axis.a = (float)cos(2.0 * at), x.start.axis.b = (float)sin(2.0 * at);
        x.start.e_f.a = (float)emf, x.start.omega = draw_f(-1, 1) * p->hfi.pll.omega_max * 0.1f;
        x.est.theta = draw_f(-3, 3);
        double was = (double)x.est.theta;
        drive_step(p, &x, &in);
        double most =
            hypot((double)x.start.e_f.a, (double)x.start.e_f.b) / (double)p->control.psi_f;
        double omega = bounded((double)x.start.omega, most);
        double on = (double)p->T_s * (p->start.n_catch + 2 * p->start.n_scan) * omega;
        double from = was + on + (j % 3 == 2 ? M_PI : 0.0);
        double off = wrapped(0.5 * atan2((double)x.start.axis.b, (double)x.start.axis.a) - from);
        if (fabs(fabs(off) - 0.5 * M_PI) < 1e-3) {
            continue;
        }
        double near_one = from + off + (fabs(off) > 0.5 * M_PI ? M_PI : 0.0);
        check("pole after SCAN", x.start.phase == START_LOCK &&
                                     fabs(wrapped((double)x.hfi.pll.theta - near_one)) < 1e-3);
        check("speed after SCAN", near((double)x.hfi.pll.omega, omega, 1e-4));
        turned[fabs(on) > 0.3] += 1;
    }
    check("pole after SCAN: each case", turned[0] > 99 && turned[1] > 99);
}

void check_seek(void) {
    fly();
    quiet();
    scan();
    pole_after_scan();
    compensated();
    injects();
    spins();
    tracks();
    guesses();
    unsound();
}
