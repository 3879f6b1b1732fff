/* Stages of the start sequence against what they are defined to do. */
#include "checks.h"

static void axis(void) {
    start_params_t p = {0};
    p.n_scan = 12;
    for (int j = 0; j < 40; j++) {
        /* Answers of a salient machine: the inverse inductance at the rotor's angle. */
        double at = draw(-M_PI, M_PI), sum = 0.7, diff = 0.4;
        start_state_t x;
        start_begin(&x);
        x.phase = START_SCAN;
        float sign[40];
        ab_t i = {0.0f, 0.0f};
        for (x.n = 0; x.n < 2 * p.n_scan + 2; x.n++) {
            sign[x.n] = x.n % 2 ? -1.0f : 1.0f;
            int acted = x.n - 2; /* the command that acted over [k-1, k] */
            if (acted >= 0) {
                vec_t along = acted < p.n_scan ? 1.0 : I;
                vec_t step =
                    (double)sign[acted] * (sum * along + diff * conj(along) * cexp(2.0 * I * at));
                i.a += (float)creal(step), i.b += (float)cimag(step);
            }
            start_scan(&p, &x, i, acted >= 0 ? sign[acted] : 0.0f);
            x.i_2 = x.i_1;
            x.i_1 = i;
        }
        float found = start_axis(&x, (float)wrapped(at + (j % 2 ? 1.5 : -1.5)));
        check("axis", fabs(wrapped((double)found - at)) < 0.02);
        double samples = 0.5 * (double)(2 * (p.n_scan - 1)); /* half a step is a sample's part */
        check("answers that count", near(cabs(of_ab(x.axis)) / diff, samples, 0.03));
    }
}

static void pulse_pairs(void) {
    start_params_t p = {0};
    const int rest = 12, pulse = 11, half = 34, pair = 70;
    p.n_rest = rest, p.n_pulse = pulse;
    start_state_t x;
    start_begin(&x);
    check("length of a pair", start_half(&p) == half && start_pair(&p) == pair);
    double sum = 0.0, before = 0.0;
    for (x.n = 0; x.n < pair; x.n++) {
        int second = x.n >= half, j = x.n - (second ? half : 0) - rest;
        float way = j < 0 || j >= 2 * pulse ? 0.0f : (j < pulse ? 1.0f : -1.0f);
        check("pulse", start_pulse(&p, &x) == (second ? 0.0f - way : way));
        float i_d = (float)(x.n * x.n) * 0.01f;
        start_peak(&p, &x, i_d);
        /* A command acts a period later: from one period after its start to one after its end. */
        int begins = x.n == rest + 1 || x.n == half + rest + 1;
        int peaks = x.n == rest + pulse + 1 || x.n == half + rest + pulse + 1;
        int ends = x.n == half + 1 || x.n == pair - 1;
        before = begins ? (double)i_d : before;
        sum += peaks ? (double)i_d : (ends ? -0.5 * (before + (double)i_d) : 0.0);
        check("peaks", near((double)x.i_pole, sum, 1e-5));
    }
}

static void emf(void) {
    start_params_t p = {0};
    double T_s = 1e-4;
    p.alpha_e = 0.2f, p.k_turn = 110.0f, p.e_turn_sq = 900.0f, p.k_hold = 50.0f;
    for (int j = 0; j < 300; j++) {
        start_state_t x;
        start_begin(&x);
        x.phase = j % 3 == 0 ? START_QUIET : START_CATCH;
        x.omega = draw_f(-2000, 2000);
        x.e_f.a = draw_f(-90, 90), x.e_f.b = draw_f(-90, 90);
        x.e_1.a = draw_f(-90, 90), x.e_1.b = draw_f(-90, 90);
        x.i_1.a = draw_f(-5, 5), x.i_1.b = draw_f(-5, 5);
        ab_t e = {draw_f(-90, 90), draw_f(-90, 90)}, i = {draw_f(-5, 5), draw_f(-5, 5)};
        double turns = T_s * (double)x.omega;
        vec_t ahead = of_ab(x.e_f) * cexp(I * 1.5 * turns);
        vec_t hold = ahead - 50.0 * 0.5 * (of_ab(i) + of_ab(x.i_1));
        check("hold", near_v(of_ab(start_hold(&p, &x, i, (float)T_s)), hold, 1e-5));
        vec_t was = of_ab(x.e_f) * cexp(I * turns);
        vec_t now = 0.5 * (of_ab(e) + of_ab(x.e_1));
        double size = creal(was * conj(was));
        double sine = cimag(conj(was) * now) / (size > 900.0 ? size : 900.0);
        sine = sine > 1.0 ? 1.0 : (sine < -1.0 ? -1.0 : sine);
        double to = (double)x.omega + (x.phase == START_QUIET ? 0.0 : 110.0 * sine);
        vec_t follows = was + (double)p.alpha_e * (now - was);
        start_emf(&p, &x, e, (float)T_s);
        check("EMF of a start",
              near_v(of_ab(x.e_f), follows, 1e-5) && x.e_1.a == e.a && x.e_1.b == e.b);
        check("speed of a start", near((double)x.omega, to, 1e-4));
    }
}

static void begin(void) {
    start_state_t x = {5, 6, 7, 8, {1, 1}, {1, 1}, {1, 1}, {1, 1}, {1, 1}, 1, 1, 1, 1};
    start_begin(&x);
    check("begin", x.phase == START_CATCH && x.n == 0 && x.tries == 0 && x.i_1.a == 0.0f &&
                       x.i_1.b == 0.0f && x.i_2.a == 0.0f && x.i_2.b == 0.0f && x.e_1.a == 0.0f &&
                       x.e_f.a == 0.0f && x.e_f.b == 0.0f && x.again == 0 && x.axis.a == 0.0f &&
                       x.axis.b == 0.0f && x.omega == 0.0f && x.i_0 == 0.0f && x.i_pole == 0.0f);
    x.n = 9;
    start_enter(&x, START_POLE);
    check("enter", x.phase == START_POLE && x.n == 0);
}

void check_start(void) {
    axis();
    pulse_pairs();
    emf();
    begin();
}
