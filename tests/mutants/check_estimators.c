/* Injection, sliding-mode and flux observer: one period against its equations in complex numbers. */
#include "checks.h"

static vec_t unit(double at) { return cexp(I * at); }

static void injection(void) {
    hfi_params_t p = {
        {100.0f, 5000.0f, 700.0f}, 50.0f, 0.02f, 3.0f, 0.5f, 0.1f, 0.3f, 3.0f, 0.8f, HFI_ROTATING};
    for (int j = 0; j < 600; j++) {
        p.scheme = j % 3 == 0 ? HFI_STATIONARY : HFI_ROTATING;
        float size = j % 5 == 0 ? 0.01f : 1.0f;
        hfi_state_t x = {{draw_f(-3, 3), draw_f(-600, 600)},
                         {draw_f(-1, 1), draw_f(-1, 1)},
                         {draw_f(-1, 1), draw_f(-1, 1)},
                         draw_f(-0.2, 0.2),
                         1,
                         j % 2 ? 1.0f : -1.0f,
                         j % 4 < 2 ? 1.0f : -1.0f,
                         0,
                         0,
                         draw_f(-1, 1),
                         0,
                         0,
                         0};
        x.i_1.d *= size, x.i_1.q *= size, x.i_2.d *= size, x.i_2.q *= size;
        ab_t i = {size * draw_f(-1, 1), size * draw_f(-1, 1)};
        hfi_state_t was = x;
        float idle = draw_f(-3, 3), idle_w = draw_f(-600, 600);
        hfi_observe(&p, &x, i, idle, idle_w, 2e-4f);
        vec_t r = unit((double)was.pll.theta);
        vec_t now = of_ab(i) * conj(r);
        vec_t turn = -I * (double)was.jump * of_dq(was.i_1); /* of both old samples */
        vec_t step = now - 2.0 * of_dq(was.i_1) + of_dq(was.i_2) - turn;
        double answer = creal(step);
        if (p.scheme == HFI_STATIONARY) {
            answer = creal((of_ab(i) - 2.0 * of_dq(was.i_1) + of_dq(was.i_2)) * conj(r));
            step = 2.0 * (of_ab(i) - of_dq(was.i_1)) * conj(r);
            now = of_ab(i);
            turn = 0.0;
        }
        vec_t e = 0.25 * (double)was.sign_2 * step;
        int valid = was.sign_2 * was.sign_3 < 0.0f;
        double err = valid ? cimag(e) / fmax(cabs(e), 0.02) : 0.0;
        check("injection's error", fabs((double)x.err - err) < 2e-4 && (x.valid > 0.0f) == valid);
        check("injection's amplitude", near((double)x.amplitude, cabs(e), 1e-5));
        check("injection's answer",
              fabs((double)x.answer - 0.25 * (double)was.sign_2 * answer) < 1e-5 * (double)size);
        check("injection's samples",
              near_v(of_dq(x.i_1), now, 1e-5) &&
                  cabs(of_dq(x.i_2) - of_dq(was.i_1) - turn) < 1e-6 * (double)size);
        pll_state_t pll = was.pll;
        if (!valid) {
            pll.theta = idle, pll.omega = idle_w;
        }
        double err_f = valid ? 0.9 * (double)was.err_f + 0.1 * err : 0.0;
        check("injection's low-passed error", fabs((double)x.err_f - err_f) < 1e-4);
        double faster = 1.0 + fmin(3.0 * fmax(fabs(err_f) - 0.3, 0.0), 0.8);
        pll.omega =
            (float)bounded((double)pll.omega + 2e-4 * 5000.0 * faster * faster * err, 700.0);
        pll.theta += (float)(2e-4 * ((double)pll.omega + 100.0 * faster * err));
        check("injection's loop", fabs(wrapped((double)(x.pll.theta - pll.theta))) < 1e-5 &&
                                      near((double)x.pll.omega, (double)pll.omega, 1e-4));
        rot_t d = hfi_direction(&p, &x, 2e-4f);
        vec_t to = unit((double)x.pll.theta + 0.5 * 2e-4 * (double)x.pll.omega);
        check("direction of injection", near_v((double)d.c + I * (double)d.s, to, 2e-6));
    }
    hfi_state_t x = {{0, 0}, {0, 0}, {0, 0}, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    const float signs[8] = {1, -1, 1, -1, 1, 0, 0, 0};
    for (int k = 0; k < 8; k++) {
        float s = hfi_inject(&p, &x, k < 3);
        check("signs alternate and stop", s == signs[k] && x.sign_1 == s);
        check("queue of signs", x.sign_2 == (k > 0 ? signs[k - 1] : 0.0f) &&
                                    x.sign_3 == (k > 1 ? signs[k - 2] : 0.0f));
    }
    for (int k = 0; k < 9; k++) {
        check("injection held", hfi_inject(&p, &x, 1) == (k % 2 ? -1.0f : 1.0f));
    }
}

/* What sliding gives for one axis; v: its integrated part. */
static double slide(const smo_params_t *p, double d, double omega, double *v) {
    if (p->switching == SMO_SIGMOID) {
        return (double)p->k * tanh((double)p->half_a * d);
    }
    if (p->switching == SMO_SIGN) {
        return (double)p->k * sgn(d);
    }
    double w = fmax(fabs(omega), (double)p->omega_floor);
    *v = bounded(*v + (double)p->climb * w * w * sgn(d), (double)p->k);
    return (double)p->root * w * sqrt(fabs(d)) * sgn(d) + *v;
}

static void sliding(void) {
    smo_params_t p = {{100.0f, 6000.0f, 700.0f},
                      2.0f,
                      0.06f,
                      700.0f,
                      0.2f,
                      3.0f,
                      SMO_SIGMOID,
                      0.5f,
                      1e-4f,
                      1.0f,
                      0.2f,
                      0.1f,
                      0.6f,
                      20.0f,
                      30.0f};
    for (int j = 0; j < 1500; j++) {
        p.switching = j % 3;
        p.lag_cure = j % 7 == 0 ? 0.0f : 1.0f;
        p.climb = j % 2 ? 1e-4f : 0.1f;
        smo_state_t x = {{draw_f(-5, 5), draw_f(-5, 5)},
                         {draw_f(-90, 90), draw_f(-90, 90)},
                         {draw_f(-300, 300), draw_f(-300, 300)},
                         draw_f(-300, 300)};
        double big = j % 4 ? 200.0 : 5.0;
        emf_estimate_t y = {
            {draw_f(-3, 3), draw_f(-300, 300)}, {draw_f(-big, big), draw_f(-big, big)}, 0.3f, 1.0f};
        ab_t i = {draw_f(-5, 5), draw_f(-5, 5)}, u = {draw_f(-200, 200), draw_f(-200, 200)};
        float w = j % 5 ? draw_f(-300, 300) : draw_f(-35, 35), idle = draw_f(-3, 3), L_q = 0.25f;
        double T = 2e-4, L = (double)0.06f;
        smo_state_t was = x;
        emf_estimate_t old = y;
        smo_observe(&p, &x, &y, i, u, L_q, w, idle, (float)T);
        vec_t i_hat = of_ab(was.i_hat);
        vec_t cross = I * (double)was.omega_f * (L - (double)L_q) * i_hat;
        i_hat += T / L * (of_ab(u) - 2.0 * i_hat + cross - of_ab(was.z));
        vec_t d = i_hat - of_ab(i);
        d = bounded(creal(d), 3.0) + I * bounded(cimag(d), 3.0);
        double va = (double)was.v.a, vb = (double)was.v.b;
        vec_t z = slide(&p, creal(d), (double)w, &va) + I * slide(&p, cimag(d), (double)w, &vb);
        check("model current", near_v(of_ab(x.i_hat), of_ab(i) + d, 1e-5));
        int clear = fabs(creal(d)) > 1e-4 && fabs(cimag(d)) > 1e-4;
        check("correction voltage", !clear || near_v(of_ab(x.z), z, 2e-4));
        check("integrated correction", !clear || near_v(of_ab(x.v), va + I * vb, 1e-4));
        double cure = (double)p.lag_cure;
        vec_t e = z + cure * (2.0 + I * (double)old.pll.omega * (double)L_q) * d;
        e = of_ab(old.e) + (double)p.alpha_e * (e - of_ab(old.e));
        check("EMF", !clear || near_v(of_ab(y.e), e, 5e-4));
        double at = (double)old.pll.theta + 0.5 * T * (double)old.pll.omega;
        vec_t seen = of_ab(y.e) * cexp(-I * at); /* j omega psi at the true angle */
        double err = sgn((double)w) * -creal(seen) / fmax(cabs(seen), 20.0);
        int valid = fabs((double)w) >= 30.0;
        check("EMF's error", fabs((double)y.err - (valid ? err : 0.0)) < 1e-4);
        check("EMF valid", y.valid == (valid ? 1.0f : 0.0f));
        pll_state_t pll = old.pll;
        if (!valid) {
            pll.theta = idle, pll.omega = w;
        }
        pll_step(&p.pll, &pll, y.err, (float)T);
        check("EMF's loop", y.pll.theta == pll.theta && y.pll.omega == pll.omega);
        check("speed of the cross term",
              near((double)x.omega_f,
                   (double)was.omega_f + 0.1 * ((double)y.pll.omega - (double)was.omega_f), 1e-5));
    }
    check("L_q as a motor", near((double)smo_L_q(&p, 0.2f, 5.0f, 0.5f), 0.2 * 1.1, 1e-6) &&
                                smo_L_q(&p, 0.2f, -5.0f, 1.0f) == 0.2f &&
                                smo_L_q(&p, 0.2f, 0.0f, 1.0f) == 0.2f);
}

static void flux(void) {
    flux_params_t p = {{80.0f, 4000.0f, 700.0f}, 0.004f, 2e-5f, 0.003f, 30.0f};
    for (int j = 0; j < 1500; j++) {
        flux_model_t m = {2.0f, 0.06f, 0.25f, 0.16f, 0.9f, j % 3 ? 0.05f : 1.5f};
        flux_state_t x = {{draw_f(-1, 1), draw_f(-1, 1)}};
        if (j % 5 == 0) {
            x.psi.a = 0.0f;
            x.psi.b = j % 10 ? 0.0f : x.psi.b;
        }
        emf_estimate_t y = {{draw_f(-3, 3), draw_f(-300, 300)}, {0, 0}, 0, j % 2 ? 1.0f : 0.0f};
        ab_t i = {draw_f(-5, 5), draw_f(-5, 5)}, u = {draw_f(-200, 200), draw_f(-200, 200)};
        ab_t i_1 = {draw_f(-5, 5), draw_f(-5, 5)};
        float w = j % 4 ? draw_f(-300, 300) : draw_f(-33, 33), idle = draw_f(-3, 3);
        float lead = draw_f(-1, 1);
        flux_state_t was = x;
        emf_estimate_t old = y;
        flux_observe(&p, &m, &x, &y, i, i_1, u, w, idle, lead, 2e-4f);
        int valid = fabs((double)w) >= 30.0;
        int fresh = !valid || (was.psi.a == 0.0f && was.psi.b == 0.0f);
        double at = valid ? (double)old.pll.theta : (double)idle;
        double omega = valid ? (double)old.pll.omega : (double)w;
        double L_d = (double)0.06f, psi_d = (double)0.9f;
        vec_t r = unit(at), idq = of_ab(i) * conj(r);
        vec_t model = psi_d + L_d * creal(idq) + I * 0.25 * cimag(idq);
        vec_t aux = psi_d + (L_d - (double)0.16f) * creal(idq) + I * (0.25 - L_d) * cimag(idq);
        vec_t psi = (of_ab(was.psi) + 2e-4 * (of_ab(u) - of_ab(i) - of_ab(i_1))) * conj(r);
        psi = fresh ? model : psi;
        double square = fmax(cabs(aux) * cabs(aux), (double)m.psi_sq_min);
        vec_t e = (model - psi) * conj(aux) / square; /* along and across the auxiliary flux */
        double gain = 2.0 * ((double)p.gain_0 + (double)p.gain_w * fabs(omega)) * creal(e);
        double turn = valid ? (double)p.k_turn * (double)lead : 0.0;
        vec_t next = (psi + (gain + I * turn) * aux) * r;
        check("flux", near_v(of_ab(x.psi), next, 3e-6));
        check("flux's error", fabs((double)y.err - bounded(-cimag(e), 1.0)) < 2e-5);
        check("flux's EMF", near_v(of_ab(y.e), I * omega * creal(aux) * r, 2e-4));
        check("flux valid", y.valid == (valid ? 1.0f : 0.0f));
        pll_state_t pll = {(float)at, (float)omega};
        pll_step(&p.pll, &pll, y.err, 2e-4f);
        check("flux's loop", y.pll.theta == pll.theta && y.pll.omega == pll.omega);
    }
}

void check_estimators(void) {
    check("switching", SMO_SIGMOID == 0 && SMO_SIGN == 1 && SMO_SUPER_TWISTING == 2);
    check("schemes", HFI_ROTATING == 0 && HFI_STATIONARY == 1);
    injection();
    sliding();
    flux();
}
