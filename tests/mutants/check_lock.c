/* Lost lock: its tests. */
#include <string.h>

#include "checks.h"
#include "params.h"

static void speed(void) {
    check("reasons", LOCK_EMF == 1 && LOCK_SPEED == 2 && LOCK_CURRENT == 4 && LOCK_ANSWER == 8 &&
                         LOCK_STALL == 16);
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
        lock_judge(&p, &x, (float)now, 1e9f);
        check("speed: low-pass", near((double)x.omega, to, 1e-5));
        if (fabs(beyond) > 0.01) {
            check("speed: told", x.alarm == (beyond > 0.0) && x.reason == (beyond > 0.0 ? 2 : 0));
        }
    }
}

/* An EMF that agrees with the estimate, on both axes, vouches for its speed; a small one does not. */
static void agrees(void) {
    lock_params_t p = PARAMS[4].lock;
    p.i_off = 1e9f, p.e_share = 1e9f, p.e_least = 1e9f;
    const struct {
        float emf, along, across; /* over a quarter of e_floor, over that EMF */
        int told;
    } cases[] = {{1.01f, 0.0f, 0.0f, 0},  {0.99f, 0.0f, 0.0f, 1},  {2.0f, 0.39f, 0.0f, 0},
                 {2.0f, 0.41f, 0.0f, 1},  {2.0f, -0.41f, 0.0f, 1}, {2.0f, -0.39f, 0.39f, 0},
                 {2.0f, 0.39f, 0.41f, 1}, {2.0f, 0.0f, -0.41f, 1}};
    for (int j = 0; j < 8; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        lock_begin(&p, &x, 0.0f);
        x.bad = p.n_alarm;
        x.emf = cases[j].emf * 0.25f * p.e_floor;
        x.residual = cases[j].along * x.emf;
        x.across = cases[j].across * x.emf;
        lock_judge(&p, &x, 3.0f * p.jump, 1e9f);
        check("speed: vouched for", x.reason == (cases[j].told ? LOCK_SPEED : 0));
    }
}

/* An estimate at its bound, of either sign, does not tell how fast the shaft is. */
static void bound(void) {
    lock_params_t p = PARAMS[4].lock;
    p.e_floor = 1e9f;
    const float at[4] = {300.0f, -300.0f, 299.9f, -299.9f};
    for (int j = 0; j < 4; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        lock_begin(&p, &x, at[j]);
        x.bad = p.n_alarm;
        lock_judge(&p, &x, at[j], 300.0f);
        check("speed: bound", x.reason == (j < 2 ? LOCK_SPEED : 0));
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
        lock_judge(&p, &x, 0.0f, 1e9f);
        check("answer: told", x.reason == (j == 0 ? LOCK_ANSWER : 0));
        lock_begin(&p, &x, 0.0f);
        check("answer: anew", x.answer == 0.0f);
    }
    for (int j = 0; j < 400; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        p.leads = j % 4 < 2 ? 0.5f : 0.0f;
        float k_s = j % 3 == 0 ? p.leads : draw_f(0, 1);
        k_s = j % 5 == 0 ? 1.0f : k_s;
        float u = draw_f(10, 90);
        lock_bounds(&p, u);
        double acts = fmax((double)u - (double)p.u_unsure, 0.0);
        double least = fmin((double)p.beside * (double)u, (double)p.along * acts);
        double most = (double)p.above * ((double)u + (double)p.u_unsure);
        double rest = fmin(least, (double)p.along * fmax((double)u - (double)p.u_taken, 0.0));
        check("answer: at rest", near((double)p.rest, rest, 1e-6));
        check("answer: least", near((double)p.answer, least, 1e-6));
        check("answer: most", near((double)p.most, most, 1e-6));
        float was = draw_f(-1, 1), seen = draw_f(-1, 2) * p.most;
        x.answer = was, x.i.q = draw_f(-2, 2) * p.i_loaded;
        int loaded = fabs((double)x.i.q) > (double)p.i_loaded, upper = k_s >= 1.0f && loaded;
        least = loaded ? least : rest;
        lock_answer(&p, &x, seen, j % 2 ? 1.0f : 0.0f, k_s);
        double more = (double)seen - least;
        more = upper ? fmin(more, most - (double)seen) : more;
        more = j % 2 && k_s >= p.leads ? more : least;
        double to = (double)was + (double)p.alpha * (more - (double)was);
        check("answer: low-pass", fabs((double)x.answer - to) < 1e-6);
    }
}

/* The EMF fails by its size on the q axis, or by its direction. */
static void direction(void) {
    lock_params_t p = PARAMS[4].lock;
    int told[3] = {0, 0, 0};
    for (int j = 0; j < 4000; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        double e = (j % 2 ? 4.0 : 1.2) * (double)p.e_floor;
        x.residual = (float)draw(-e, e), x.across = (float)draw(-e, e),
        x.emf = (float)draw(0, j % 2 ? e : 0.3 * e);
        x.i.q = j % 2 ? draw_f(-5, 5) : draw_f(-1, 1);
        float omega = draw_f(-300, 300);
        double along = (double)x.emf + (omega < 0 ? -1.0 : 1.0) * (double)x.residual;
        x.late = j % 7 ? draw_f(-0.5, 0.5) * p.e_late : draw_f(-2, 2) * p.e_late;
        double size = fabs((double)x.residual) - 0.5 * (double)x.emf - (double)p.e_floor;
        double late = fabs((double)x.late) - (double)p.e_late;
        double beside = fabs((double)x.across) - fabs((double)(p.d_share * x.i.q));
        beside -= 0.35 * (double)p.e_least;
        double least = fmax(fabs((double)x.across), -along) - (double)p.e_least;
        double turned = beside - fmax(along, 0.0) * sqrt(3.0);
        double edge = 1e-3 * e;
        if (fabs(size) < edge || fabs(least) < edge || fabs(turned) < edge || fabs(late) < edge) {
            continue;
        }
        int by_size = size > 0, by_direction = least > 0 && turned > 0;
        check("EMF: fails", lock_emf_fails(&p, &x, omega) == (by_size || by_direction || late > 0));
        told[by_size ? 1 : by_direction ? 2 : 0] += 1;
    }
    check("EMF: each case", told[0] > 99 && told[1] > 99 && told[2] > 99);
}

/* The EMF's part of an evaluation: r and the EMF expected, both low-passed, from a drive's state. */
static void sums(void) {
    drive_params_t p = PARAMS[4];
    for (int j = 0; j < 300; j++) {
        drive_state_t x;
        drive_init(&p, &x, 0.0f, 0.0f, 0.5f);
        x.est.omega = draw_f(-500, 500);
        x.control.i.d = draw_f(-5, 5), x.control.i.q = draw_f(-5, 5);
        x.control.i_ref.q = draw_f(-5, 5);
        x.control.u_max = 250.0f, x.control.u_abs = draw_f(100, 400);
        x.k_s = draw_f(0, 1), x.hfi.answer = draw_f(-1, 1);
        x.hfi.valid = j % 2 ? 1.0f : 0.0f;
        double n = (double)p.lock.n;
        x.control.u_sum.d = draw_f(-2000, 2000), x.control.u_sum.q = draw_f(-2000, 2000);
        x.control.i_sum.d = draw_f(-50, 50), x.control.i_sum.q = draw_f(-50, 50);
        x.lock.i.d = draw_f(-5, 5), x.lock.i.q = draw_f(-5, 5);
        x.est.theta = draw_f(-3, 3), x.lock.theta = draw_f(-3, 3);
        x.lock.late = draw_f(-9, 9), x.lock.bad = j % 3 ? j % 2 : LOCK_GRACE + 1;
        x.lock.across = draw_f(-9, 9), x.lock.residual = draw_f(-9, 9), x.lock.emf = draw_f(0, 90);
        const lock_state_t was = x.lock;
        double omega = (double)x.est.omega;
        double i_d = (double)x.control.i_sum.d / n, i_q = (double)x.control.i_sum.q / n;
        double u_d = (double)x.control.u_sum.d / n, u_q = (double)x.control.u_sum.q / n;
        curve_pos_t pos = curve_locate(x.control.i.q, p.control.curve_inv_step);
        double L_q = (double)(p.lock.L_q_true * curve_at(&p.L_q, pos)), L_d = (double)p.control.L_d;
        double psi_0 = (double)curve_at(&p.coupled.psi_d, pos);
        double d_d = (double)x.control.i.d - (double)was.i.d;
        double d_q = (double)x.control.i.q - (double)was.i.q;
        double beside =
            u_d - (double)p.lock.R_s * i_d + omega * L_q * i_q - (double)p.lock.inv_t * L_d * d_d;
        double r = u_q - (double)p.lock.R_s * i_q - omega * (psi_0 + L_d * i_d) -
                   (double)p.lock.inv_t * L_q * d_q;
        double psi_a = fmin(psi_0 + (L_d - L_q) * i_d, 2.0 * psi_0);
        double emf = fabs(omega * psi_a), alpha = (double)p.lock.alpha;
        drive_watch(&p, &x);
        double to = (double)was.residual + alpha * (r - (double)was.residual);
        check("EMF: residual", near((double)x.lock.residual, to, 1e-4));
        to = (double)was.across + alpha * (beside - (double)was.across);
        check("EMF: across", near((double)x.lock.across, to, 1e-4));
        to = (double)was.emf + alpha * (emf - (double)was.emf);
        check("EMF: expected", near((double)x.lock.emf, to, 1e-4));
        double T = n * (double)p.T_s,
               ahead = wrapped((double)x.est.theta - (double)was.theta - omega * T);
        double lasting = r - ahead / T * (psi_0 + L_d * i_d);
        double free = 0.5 * (double)x.lock.emf + (double)p.lock.R_warm * fabs(i_q);
        double rest = fmax(fabs(lasting) - free, 0.0) * sgn(lasting);
        to = (double)was.late + (double)p.lock.alpha_late * (rest - (double)was.late);
        to = j % 3 ? to : (double)was.late;
        check("EMF: what lasts", fabs((double)x.lock.late - to) < 2e-3);
        check("EMF: angle", x.lock.theta == x.est.theta);
        check("EMF: current", x.lock.i.d == x.control.i.d && x.lock.i.q == x.control.i.q);
        lock_state_t answer = was;
        lock_answer(&p.lock, &answer, x.hfi.answer, x.hfi.valid, x.k_s);
        check("answer: of the drive", x.lock.answer == answer.answer);
        int short_of = x.control.u_abs > x.control.u_max;
        double off = short_of ? 0.0 : fabs(i_q - (double)x.control.i_ref.q);
        to = (double)was.i_off + alpha * (off - (double)was.i_off);
        check("tests: current", near((double)x.lock.i_off, to, 1e-5));
        check("sums: anew", x.control.u_sum.d == 0.0f && x.control.u_sum.q == 0.0f);
        check("sums: anew", x.control.i_sum.d == 0.0f && x.control.i_sum.q == 0.0f);
        drive_judge(&p, &x);
        check("tests: the next", x.lock.wait == p.lock.n);
    }
}

/* Alarms count once, end after n_clear good evaluations, and good ones alone never begin one. */
static void told_once(void) {
    lock_params_t p = PARAMS[4].lock;
    lock_state_t x;
    memset(&x, 0, sizeof x);
    for (int k = 0; k < 60; k++) {
        lock_judge(&p, &x, 0.0f, 1e9f);
        check("alarm: none", x.alarm == 0 && x.bad == 0 && x.alarms == 0);
    }
    for (int n = 1; n <= 3; n++) {
        for (int k = 0; k < 9; k++) {
            x.residual = 2.0f * p.e_floor;
            lock_judge(&p, &x, 0.0f, 1e9f);
            check("alarm: begins",
                  x.alarm == (k + 1 >= p.n_alarm) && x.reason == LOCK_EMF * x.alarm);
        }
        x.residual = 0.0f;
        for (int k = 1; k <= p.n_clear + 9; k++) {
            lock_judge(&p, &x, 0.0f, 1e9f);
            check("alarm: ends", x.alarm == (k < p.n_clear));
        }
        check("alarm: counted", x.alarms == n);
        x.reason = 0;
    }
    for (int n = 1; n <= p.n_grace + 1; n++) { /* counts down, nothing is judged; damage ends it */
        memset(&x, 0, sizeof x);
        x.bad = LOCK_GRACE + n, x.residual = 2.0f * p.e_floor;
        lock_judge(&p, &x, 0.0f, 1e9f);
        check("grace", x.bad == (n == 1 || n > p.n_grace ? 0 : LOCK_GRACE + n - 1) && !x.alarm);
    }
    for (int n = 0; n <= 1; n++) { /* an alarm lasts beyond the counter's end */
        memset(&x, 0, sizeof x);
        x.bad = LOCK_GRACE - n, x.alarm = 1;
        x.residual = 2.0f * p.e_floor;
        lock_judge(&p, &x, 0.0f, 1e9f);
        check("alarm: lasts", x.bad == LOCK_GRACE && x.alarm == 1);
    }
    for (int n = -2; n <= 1; n++) { /* restarts are forgotten once it was calm for n_calm */
        memset(&x, 0, sizeof x);
        x.calm = p.n_calm + n, x.restarts = 2, x.omega = 0.99f * p.slow;
        lock_stall(&p, &x, 0.0f);
        check("restarts: kept", x.restarts == 2);
        x.omega = -1.01f * p.slow;
        lock_stall(&p, &x, 0.0f);
        check("restarts: forgotten", x.restarts == (n >= 0 ? 0 : 2));
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

void check_lock(void) {
    speed();
    agrees();
    bound();
    injected();
    direction();
    sums();
    first();
    told_once();
}
