/* What of a state passes as sound: both sides of every bound. */
#include "checks.h"
#include "drive_check.h"
#include "params.h"
#include <string.h>

static drive_state_t idle_drive(const drive_params_t *p) {
    drive_state_t x;
    drive_init(p, &x, 0.0f, 0.0f, 0.5f);
    return x;
}

static int finite_u(ab_t u) { return isfinite(u.a) && isfinite(u.b); }

/* Angles of both estimators within two turns together, weight and sign within 1. */
static void state_angles(void) {
    const drive_params_t *p = &PARAMS[4];
    const struct {
        float hfi, smo, k_s;
        int sound;
    } cases[] = {
        {3.1f, -3.1f, 0.0f, 1},      {6.28f, 6.28f, 1.0f, 1},     {-6.28f, -6.28f, 0.5f, 1},
        {6.29f, 6.29f, 0.5f, 0},     {-6.3f, 6.3f, 0.5f, 0},      {1e5f, 0.0f, 0.5f, 0},
        {0.0f, -1e5f, 0.5f, 0},      {(float)NAN, 0.0f, 0.5f, 0}, {0.0f, INFINITY, 0.5f, 0},
        {0.0f, 0.0f, 1.0000002f, 0}, {0.0f, 0.0f, -1e-9f, 0},     {0.0f, 0.0f, (float)NAN, 0},
    };
    for (unsigned j = 0; j < sizeof cases / sizeof cases[0]; j++) {
        drive_state_t x = idle_drive(p);
        x.hfi.pll.theta = cases[j].hfi, x.emf.pll.theta = cases[j].smo, x.k_s = cases[j].k_s;
        check("angles", drive_angles_sound(&x) == cases[j].sound);
        x.lock.wait = 1;
        ab_t u = {1.0f, -2.0f}, v = drive_lock(p, &x, u);
        check("angles: passed on", (v.a == 1.0f && v.b == -2.0f) == cases[j].sound);
        check("angles: refused", drive_sound(&p->guard, &x, v) == 0 || cases[j].sound);
        for (int k = 0; k < 4 && cases[j].sound; k++) {
            x.coupled.drift.sign = (k < 2 ? 1.0f : -1.0f) * (k % 2 ? 1.0f : 1.0001f);
            check("sign", drive_angles_sound(&x) == k % 2);
        }
    }
}

/* The speed integrator within its invariant set, trust within 1. */
static void state_loops(void) {
    for (int j = 0; j < 400; j++) {
        drive_params_t p = PARAMS[4];
        p.lock.action = LOCK_REPORT;
        p.control.i_int_max = draw_f(1, 20);
        double most = (double)p.control.i_int_max;
        drive_state_t x = idle_drive(&p);
        int good = j % 2;
        x.control.i_int = (float)((j % 4 < 2 ? 1 : -1) * most * (good ? 0.9999 : 1.0001));
        check("integrator", drive_loops_sound(&p, &x) == good);
        x.lock.wait = 0;
        ab_t u = {1.0f, -2.0f}, v = drive_lock(&p, &x, u);
        check("integrator: passed on", (v.a == 1.0f && v.b == -2.0f) == good);
        check("integrator: refused", drive_sound(&p.guard, &x, v) == 0 || good);
        x.control.i_int = 0.0f;
        x.coupled.drift.trust = good ? (j % 4 < 2 ? 0.0f : 1.0f) : (j % 4 < 2 ? -0.01f : 1.01f);
        check("trust", drive_loops_sound(&p, &x) == good);
    }
}

/* A drive that seeks: phase, counters, weight, and each word that its observer starts from. */
static void state_seeks(void) {
    const drive_params_t *p = &PARAMS[4];
    for (int32_t phase = -2; phase < START_STOPPED + 20; phase++) {
        drive_state_t x = seeking(p, phase, 0);
        int sound = phase > START_DONE && phase <= START_STOPPED && phase % 17 == 0;
        check("seeks: phase", drive_seek_sound(&x) == sound);
        x.start.n = -1;
        check("seeks: count", !drive_seek_sound(&x));
        x.start.n = 0, x.start.tries = -1;
        check("seeks: tries", !drive_seek_sound(&x));
    }
    drive_state_t x = seeking(p, START_CATCH, 0);
    const float weights[] = {0.0f, -0.0f, 1.0f, -1e-9f, 1.0000002f, (float)NAN};
    for (int j = 0; j < 6; j++) {
        x.k_s = weights[j];
        check("seeks: weight", drive_seek_sound(&x) == (j < 3));
    }
    x.k_s = 1.0f;
    float *const words[] = {&x.u_1.a,       &x.u_1.b,       &x.u_2.a,   &x.u_2.b,
                            &x.smo.i_hat.a, &x.smo.i_hat.b, &x.smo.z.a, &x.smo.z.b};
    for (unsigned j = 0; j < 2 * (sizeof words / sizeof words[0]); j++) {
        float *w = words[j / 2];
        *w = j % 2 ? (float)NAN : 1.1e15f;
        check("seeks: words", !drive_seek_sound(&x));
        *w = 0.9e15f;
        check("seeks: large words", drive_seek_sound(&x));
        drive_state_t y = x;
        *w = 0.0f;
        drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
        check("seeks: voltage", finite_u(drive_step(p, &y, &in)));
    }
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    drive_state_t blank = {0};
    (void)drive_step(p, &blank, &in);
    check("seeks: drive_init is missing",
          blank.fault == FAULT_STATE && blank.start.phase == START_CATCH);
    x.u_2.b = (float)NAN;
    ab_t u = drive_step(p, &x, &in);
    check("seeks: mends", u.a == 0.0f && u.b == 0.0f && x.fault == FAULT_STATE);
}

/* Both sums have each of their words once, none that is the other's, and nothing else. */
static void state_sums(void) {
    enum { WORDS = sizeof(drive_state_t) / sizeof(float), IN_CONTROL = 75, SEEKING = 28 };
    int ours = 0, besides = 0;
    for (int w = 0; w < WORDS; w++) {
        float words[WORDS] = {0.0f};
        drive_state_t x;
        words[w] = 1.0f;
        memcpy(&x, words, sizeof x);
        float sum = drive_sum(&x), seeks = drive_seek_sum(&x);
        check("sums", (sum == 0.0f || sum == 1.0f) && (seeks == 0.0f || seeks == 1.0f));
        check("sums: once", sum * seeks == 0.0f);
        ours += sum == 1.0f;
        besides += seeks == 1.0f;
    }
    check("sums: in control", ours == IN_CONTROL);
    check("sums: seeking", besides == SEEKING);
}

/* Counters and bits, each at both ends; each is looked at in one of the two parts of a test. */
static void state_counts(void) {
    const drive_params_t *p = &PARAMS[4];
    const ab_t u = {1.0f, -2.0f};
    const struct {
        int32_t count;
        int sound;
    } cases[] = {{0, 1}, {(1 << 30) - 1, 1}, {1 << 30, 0}, {-1, 0}};
    for (int j = 0; j < 40; j++) {
        drive_state_t x = idle_drive(p);
        int32_t *const counts[] = {&x.start.n,     &x.start.tries, &x.start.again,   &x.fault,
                                   &x.lock.bad,    &x.lock.calm,   &x.lock.restarts, &x.lock.alarms,
                                   &x.lock.turned, &x.lock.reason};
        int k = j % 10, sound = cases[j / 10].sound;
        *counts[k] = cases[j / 10].count;
        check("counts", drive_start_counts(&x) == (sound || k > 3));
        check("counts: of the lock", drive_lock_counts(&x) == (sound || k < 4));
        x.lock.wait = k < 4;
        ab_t v = drive_lock(p, &x, u);
        int left = k < 4 ? drive_start_counts(&x) : drive_lock_counts(&x); /* some heal */
        check("counts: refused", (v.a == u.a && v.b == u.b) == left);
    }
}

/* Memory without drive_init is seen with the next test of the lock. */
static void state_begun(void) {
    const drive_params_t *p = &PARAMS[4];
    for (int j = 0; j < 2; j++) {
        drive_state_t x = idle_drive(p);
        x.begun ^= j;
        x.lock.wait = 0;
        ab_t u = {1.0f, -2.0f}, v = drive_lock(p, &x, u);
        check("begun", (v.a == 1.0f && v.b == -2.0f) == (j == 0));
    }
}

/* The voltage, and each sum's limit. */
static void state_sound(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_state_t x = idle_drive(p);
    ab_t zero = {0.0f, 0.0f};
    for (int j = 0; j < 4; j++) {
        x.lock.emf = (j % 2 ? 1.0f : -1.0f) * (j / 2 ? 1.01e15f : 0.99e15f);
        check("sound: limit", drive_sound(&p->guard, &x, zero) == (j < 2));
    }
    x.lock.emf = 0.0f;
    for (int j = 0; j < 4; j++) {
        float v = (j % 2 ? 1.0f : -1.0f) * p->guard.u_out;
        ab_t in = {j / 2 ? v : 0.0f, j / 2 ? 0.0f : v};
        ab_t out = {1.001f * in.a, 1.001f * in.b};
        check("sound: voltage", drive_sound(&p->guard, &x, in) && !drive_sound(&p->guard, &x, out));
    }
}

void check_state(void) {
    state_angles();
    state_loops();
    state_seeks();
    state_sums();
    state_counts();
    state_begun();
    state_sound();
}
