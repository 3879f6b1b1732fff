/* Frames, trigonometry, curves, dead time, PLL, blend: against libm and the definitions. */
#include "checks.h"

static void angles(void) {
    for (int j = 0; j < 4000; j++) {
        double x = draw(-8.0, 8.0);
        rot_t r = rot_of((float)x);
        double f = (double)(float)x;
        check("cosine", fabs((double)r.c - cos(f)) < 3e-7 && fabs((double)r.s - sin(f)) < 3e-7);
        float small = draw_f(-0.25, 0.25);
        rot_t t = rot_turn(r, small);
        check("small turn", fabs((double)t.c - cos(f + (double)small)) < 1e-5 &&
                                fabs((double)t.s - sin(f + (double)small)) < 1e-5);
        float tiny = 0.2f * small;
        t = rot_turn(r, tiny);
        check("tiny turn", fabs((double)t.c - cos(f + (double)tiny)) < 4e-7 &&
                               fabs((double)t.s - sin(f + (double)tiny)) < 4e-7);
        ab_t v = {draw_f(-3, 3), draw_f(-3, 3)};
        check("angle",
              fabs(wrapped((double)angle_of(v) - atan2((double)v.b, (double)v.a))) < 1.2e-6);
        check("tanh", fabs((double)tanh_f((float)x) - tanh(f)) < 1e-4);
        check("tanh near 0",
              fabs((double)tanh_f((float)(0.3 * x)) - tanh((double)(float)(0.3 * x))) < 4e-6);
        float three = draw_f(-9.42, 9.42);
        check("wrap", fabs((double)wrap_pi(three) - wrapped((double)three)) < 2e-6 ||
                          fabs(fabs((double)wrap_pi(three)) - M_PI) < 2e-6);
        check("wrap keeps", fabs((double)three) > M_PI || wrap_pi(three) == three);
        double turns = floor(draw(-40, 40));
        check("wrap far", fabs(wrapped((double)wrap_far((float)(three + 2.0 * M_PI * turns)) -
                                       (double)three)) < 3e-5);
        check("wraps far", fabs((double)wrap_far(three)) < M_PI + 1e-5);
        rot_t far = rot_of((float)(1e8 * x));
        check("far angle", finite_f(far.c) && finite_f(far.s));
    }
    ab_t zero = {0.0f, 0.0f};
    check("angle of nothing", angle_of(zero) == 0.0f);
    check("tanh far", tanh_f(40.0f) <= 1.0f && tanh_f(40.0f) > 0.9998f && tanh_f(-9.0f) < -0.9998f);
}

static void scalars(void) {
    float n = (float)NAN;
    float inf = (float)INFINITY;
    for (int j = 0; j < 1000; j++) {
        float x = draw_f(-3, 3), y = draw_f(-3, 3), lo = draw_f(-2, 0), hi = draw_f(0, 2);
        check("min max", min_f(x, y) == fminf(x, y) && max_f(x, y) == fmaxf(x, y));
        check("clamp", clamp_f(x, lo, hi) == fminf(fmaxf(x, lo), hi));
        check("bound", bound_f(x, hi) == fminf(fmaxf(x, -hi), hi));
        check("sane", sane_f(x, hi) == (fabsf(x) <= hi ? x : 0.0f));
        ab_t v = {x, y};
        rot_t r = rot_of(lo);
        vec_t turned = of_ab(v) * cexp(-I * (double)lo);
        check("Park", near_v(of_dq(ab_to_dq(v, r)), turned, 1e-6));
        dq_t w = {x, y};
        check("inverse Park", near_v(of_ab(dq_to_ab(w, r)), of_ab(v) * cexp(I * (double)lo), 1e-6));
        double a = creal(of_ab(v)), b = creal(of_ab(v) * cexp(-I * 2.0 * M_PI / 3.0));
        check("Clarke", near_v(of_ab(phases_to_ab((float)a, (float)b)), of_ab(v), 1e-5));
        check("norm", near((double)norm_ab(v), cabs(of_ab(v)), 1e-6));
        float d = draw_f(-M_PI, M_PI);
        double half = M_PI / 2.0;
        double tent =
            fabs((double)d) < half ? (double)d : sgn((double)d) * (M_PI - fabs((double)d));
        check("disagreement", near((double)disagreement(d), tent, 1e-6));
    }
    check("NaN", clamp_f(n, -2.0f, 3.0f) == -2.0f && bound_f(n, 2.0f) == -2.0f &&
                     sane_f(n, 1.0f) == 0.0f && sane_f(inf, 1.0f) == 0.0f && !finite_f(n) &&
                     !finite_f(inf) && !finite_f(-inf) && finite_f(3.4e38f));
    check("sign", sign_f(-0.1f) == -1.0f && sign_f(0.1f) == 1.0f && sign_f(0.0f) == 1.0f);
    check("magnitude", abs_f(-2.0f) == 2.0f && abs_f(3.0f) == 3.0f);
    check("sane at its limit", sane_f(2.0f, 2.0f) == 2.0f && sane_f(-2.0f, 2.0f) == -2.0f);
    check("bound at its limit", bound_f(2.0f, 2.0f) == 2.0f && bound_f(-2.0f, 2.0f) == -2.0f);
}

static void curves(void) {
    curve_t c;
    for (int j = 0; j < CURVE_N; j++) {
        c.y[j] = draw_f(0.5, 1.5);
    }
    for (int j = 0; j < 1000; j++) {
        float i = draw_f(-6, 6);
        double t = fmin(fabs((double)i) * 2.0, CURVE_N - 1.0);
        int k = (int)fmin(floor(t), CURVE_N - 2.0);
        double slope = (double)c.y[k + 1] - (double)c.y[k];
        curve_pos_t pos = curve_locate(i, 2.0f);
        check("curve", near((double)curve_at(&c, pos), (double)c.y[k] + (t - k) * slope, 1e-5));
        check("curve's slope", near((double)curve_incremental(&c, pos),
                                    (double)c.y[k] + (t - k) * slope + t * slope, 1e-5));
    }
    curve_pos_t lost = curve_locate((float)NAN, 2.0f);
    check("nodes of a curve", CURVE_N == 9);
    check("curve of NaN", lost.j == CURVE_N - 2 && lost.f == 1.0f);
}

/* Leg voltages in the directions of the three phases. */
static vec_t legs(ab_t i, double inv, double u_dt) {
    vec_t sum = 0.0;
    for (int leg = 0; leg < 3; leg++) {
        vec_t axis = cexp(I * 2.0 * M_PI / 3.0 * leg);
        double along = creal(of_ab(i) * conj(axis));
        sum += 2.0 / 3.0 * u_dt * bounded(along * inv, 1.0) * axis;
    }
    return sum;
}

static void dead_time(void) {
    for (int j = 0; j < 500; j++) {
        ab_t i = {draw_f(-1, 1), draw_f(-1, 1)};
        vec_t u = legs(i, 2.0, 7.0);
        check("dead time", near_v(of_ab(dead_time_voltage(7.0f, 2.0f, i)), u, 2e-6));
        vec_t excess = u - legs(i, 5.0, 4.0);
        check("dead time's excess",
              near_v(of_ab(dead_time_excess(7.0f, 14.0f, 4.0f, 20.0f, i)), excess, 4e-6));
    }
}

static void loops(void) {
    pll_params_t p = {90.0f, 4000.0f, 300.0f};
    for (int j = 0; j < 1000; j++) {
        pll_state_t x = {draw_f(-3.1, 3.1), draw_f(-320, 320)};
        float err = draw_f(-1, 1), T = 2e-4f;
        double w = bounded((double)x.omega + 2e-4 * 4000.0 * (double)err, 300.0);
        double at = wrapped((double)x.theta + 2e-4 * (w + 90.0 * (double)err));
        pll_step(&p, &x, err, T);
        check("PLL's speed", near((double)x.omega, w, 1e-6));
        check("PLL's angle", fabs(wrapped((double)x.theta - at)) < 2e-6);
    }
    for (int j = 0; j < 1000; j++) {
        estimate_t h = {draw_f(-3.1, 3.1), draw_f(-300, 300)};
        estimate_t s = {draw_f(-3.1, 3.1), draw_f(-300, 300)};
        float k = draw_f(0, 1);
        double d = wrapped((double)h.theta - (double)s.theta);
        estimate_t y = ks_blend(h, s, k);
        check("blend", fabs(wrapped((double)y.theta - (double)s.theta - (double)k * d)) < 3e-6);
        double w = (double)s.omega + (double)k * ((double)h.omega - (double)s.omega);
        check("blend's speed", near((double)y.omega, w, 1e-5));
        y = ks_blend_unwrapped(h, s, k);
        double mean = (double)s.theta + (double)k * ((double)h.theta - (double)s.theta);
        check("published blend",
              fabs((double)y.theta - mean) < 3e-6 && near((double)y.omega, w, 1e-5));
        float target = draw_f(-0.5, 1.5), step = draw_f(0, 0.3);
        double to = fmin(fmax((double)target, 0.0), 1.0);
        check("slope of k_s", near((double)ks_slew(k, target, step),
                                   (double)k + bounded(to - (double)k, (double)step), 1e-6));
    }
    check("k_s below 0", ks_slew(0.0f, -0.1f, 1.0f) == 0.0f && ks_slew(0.05f, -0.1f, 1.0f) == 0.0f);
    check("k_s above 1", ks_slew(1.0f, 1.1f, 1.0f) == 1.0f && ks_limit((float)NAN) == 1.0f);
}

void check_math(void) {
    angles();
    scalars();
    curves();
    dead_time();
    loops();
}
