/* Errors of the current sensors that a drive learns, against their definitions with complex
 * numbers, and when it learns. */
#include <string.h>

#include "checks.h"
#include "params.h"

static match_params_t params(int j) {
    match_params_t p = {0};
    p.k_gain = 0.4f, p.k_offset = 0.05f, p.alpha = 0.2f, p.err_max = 0.3f;
    p.gain_max = j % 3 ? 0.5f : 0.02f, p.offset_max = j % 3 ? 3.0f : 0.02f;
    p.omega_gain = 100.0f, p.omega_offset = 60.0f, p.alone = j % 2 ? 1.0f : 0.0f;
    return p;
}

/* What is known of the errors is taken off each channel. */
static void correct(void) {
    match_state_t x = {draw_f(-0.1, 0.1), draw_f(-1, 1), draw_f(-1, 1), 0.0f};
    double i_a = draw(-9, 9), i_b = draw(-9, 9);
    double a = (1.0 - (double)x.gain) * i_a - (double)x.offset_a;
    double b = (1.0 + (double)x.gain) * i_b - (double)x.offset_b;
    vec_t i = of_ab(match_correct(&x, (float)i_a, (float)i_b));
    check("sensors: corrected", near_v(i, a + I * (a + 2.0 * b) / sqrt(3.0), 1e-5));
}

static void learn(int j) {
    match_params_t p = params(j);
    match_state_t x = {draw_f(-0.01, 0.01), draw_f(-0.01, 0.01), draw_f(-0.01, 0.01),
                       draw_f(-0.2, 0.2)};
    const match_state_t was = x;
    vec_t i = draw(-9, 9) + I * draw(-9, 9), aux = draw(0.1, 0.6) + I * draw(-0.4, 0.4);
    ab_t i_ab = {(float)creal(i), (float)cimag(i)};
    dq_t aux_dq = {(float)creal(aux), (float)cimag(aux)};
    double size = creal(aux * conj(aux)), theta = draw(-3, 3), L_d = 0.02, L_qq = 0.05;
    float err = draw_f(-0.6, 0.6), omega = draw_f(-300, 300);
    float k_s = j % 5 < 2 ? draw_f(0, 0.02) : draw_f(0, 1);
    rot_t r = {(float)cos(theta), (float)sin(theta)};

    match_gain(&p, &x, 1, i_ab, r, aux_dq, (float)(1.0 / size), (float)L_d, (float)L_qq, err, omega,
               k_s);
    vec_t n = conj(i) * (1.0 + I / sqrt(3.0)) * cexp(-I * theta); /* of negative sequence */
    double slope = (L_d * creal(n) * creal(aux) + L_qq * cimag(n) * cimag(aux)) / size;
    double swing = bounded((double)(err - was.mean), 0.3);
    double fast = fabs((double)omega) >= 100.0 && (j % 2 == 0 || k_s <= 0.01f);
    double gain = bounded((double)was.gain + fast * 0.4 * slope * swing, (double)p.gain_max);
    check("sensors: gain", near((double)x.gain, gain, 1e-5));
    check("sensors: mean",
          near((double)x.mean, (double)(was.mean + 0.2f * (err - was.mean)), 1e-6));
    check("sensors: offsets apart", x.offset_a == was.offset_a && x.offset_b == was.offset_b);

    match_state_t y = was;
    match_offset(&p, &y, 1, r, aux_dq, (float)(1.0 / size), err, omega);
    double k = fabs((double)omega) >= 60.0 ? sgn((double)omega) * 0.05 : 0.0;
    vec_t step = k / size * bounded((double)err, 0.3) * conj(aux) * cexp(I * theta);
    double most = (double)p.offset_max;
    double a = bounded((double)was.offset_a + creal(step), most);
    double b = bounded((double)was.offset_b + creal(step * cexp(-2.0 * I * M_PI / 3.0)), most);
    check("sensors: offset a", near((double)y.offset_a, a, 1e-6));
    check("sensors: offset b", near((double)y.offset_b, b, 1e-6));
    check("sensors: gain apart", y.gain == was.gain && y.mean == was.mean);

    y = was;
    match_gain(&p, &y, 0, i_ab, r, aux_dq, 1.0f, 1.0f, 1.0f, err, omega, k_s);
    match_offset(&p, &y, 0, r, aux_dq, 1.0f, err, omega);
    check("sensors: not now", memcmp(&y, &was, sizeof y) == 0);
}

/* A drive with errors so large that each use moves what it learns: only in periods far enough from
 * the next test of the lock, the gain in odd and the offsets in even ones. */
static void turns(void) {
    for (unsigned d = 0; d < sizeof PARAMS / sizeof PARAMS[0]; d++) {
        drive_params_t p = PARAMS[d];
        if (p.estimator != ESTIMATE_COUPLED) {
            continue;
        }
        p.coupled.match.omega_gain = p.coupled.match.omega_offset = 0.0f;
        drive_state_t x;
        drive_init(&p, &x, 0.0f, 200.0f, 0.5f);
        drive_in_t in = {3.0f, -2.0f, 540.0f, 200.0f, 0.0f};
        for (int k = 0; k < 200; k++) {
            const match_state_t was = x.coupled.match;
            int wait = x.lock.wait, now = wait > p.coupled.match.after;
            drive_step(&p, &x, &in);
            check("sensors: turn of the gain",
                  (x.coupled.match.mean != was.mean) == (now && wait % 2));
            check("sensors: turn of the offsets",
                  (x.coupled.match.offset_a != was.offset_a) <= (now && wait % 2 == 0));
        }
        check("sensors: learned", x.coupled.match.offset_a != 0.0f && x.coupled.match.mean != 0.0f);
    }
}

void check_match(void) {
    for (int j = 0; j < 400; j++) {
        correct();
        learn(j);
    }
    turns();
}
