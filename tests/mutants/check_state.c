/* What of a state passes as sound: both sides of every bound. */
#include "checks.h"
#include "drive_check.h"
#include "params.h"

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

/* A drive that seeks: phase, counters, and each word that its observer starts from. */
static void state_seeks(void) {
    const drive_params_t *p = &PARAMS[4];
    for (int32_t phase = -2; phase < START_END + 3; phase++) {
        drive_state_t x = seeking(p, phase, 0);
        int sound = phase > START_DONE && phase < START_END;
        check("seeks: phase", drive_seek_sound(&x) == sound);
        x.start.n = -1;
        check("seeks: count", !drive_seek_sound(&x));
        x.start.n = 0, x.start.tries = -1;
        check("seeks: tries", !drive_seek_sound(&x));
    }
    drive_state_t x = seeking(p, START_CATCH, 0);
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

/* Every word of the state in turn, and the voltage. */
static void state_sound(void) {
    const drive_params_t *p = &PARAMS[4];
    drive_state_t x = idle_drive(p);
    ab_t zero = {0.0f, 0.0f};
    int32_t at = 0, seen = 0;
    for (int32_t k = 0; k <= CHECK_LAST + CHECK_WORDS; k += CHECK_WORDS) {
        seen += at == 0;
        at = check_next(at);
        check("place", at >= 0 && at <= CHECK_LAST);
    }
    check("place: a round", seen == 1 || seen == 2);
    check("place: damaged", check_next(-5) == 0 && check_next(1 << 30) == 0);
    float *words = (float *)(void *)&x;
    for (int32_t w = 0; w < CHECK_LAST + CHECK_WORDS; w++) {
        drive_state_t was = x;
        x.check = w < CHECK_LAST ? w : CHECK_LAST;
        int32_t own = (int32_t)((char *)&x.check - (char *)&x) / 4;
        if (w != own) {
            words[w] = (float)NAN;
            check("sound: a word", !drive_sound(&p->guard, &x, zero));
        }
        x = was;
    }
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
    state_sound();
}
