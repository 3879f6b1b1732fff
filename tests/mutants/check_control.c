/* Speed and current control, signals: against their equations. */
#include "checks.h"

static control_params_t some(int j) {
    control_params_t p = {0};
    p.k_p_speed = 0.02f, p.k_i_speed = 0.3f, p.weight_ref = 0.4f, p.i_q_step = j % 3 ? 0.5f : 5.0f;
    p.i_max = 6.8f, p.k_t_d = 20.0f, p.k_t_q = 70.0f, p.k_p_d = 38.0f, p.k_p_q = 140.0f;
    p.k_i_d = 1.3f, p.k_i_q = 4.0f, p.L_d = 0.06f, p.L_q = 0.25f, p.psi_f = 0.9f, p.k_fw = 0.01f;
    p.fw_margin = 0.9f, p.i_d_min = -5.0f, p.u_dt = 5.0f, p.inv_i_dt = 4.0f;
    p.by_reference = j % 2 ? draw_f(0, 1) : 0.0f, p.curve_inv_step = 1.2f;
    for (int k = 0; k < CURVE_N; k++) {
        p.i_d_mtpa.y[k] = -0.3f * (float)k;
    }
    return p;
}

static void control(int j) {
    const double T = (double)2e-4f;
    control_params_t p = some(j);
    double big = j % 4 ? 200.0 : 30.0;
    control_state_t x = {{draw_f(-5, 5), draw_f(-5, 5)},
                         {0, 0},
                         {draw_f(-5, 0), draw_f(-6, 6)},
                         {draw_f(-big, big), draw_f(-big, big)},
                         draw_f(-5, 5),
                         j % 2 ? draw_f(-4, 0) : -0.01f,
                         {draw_f(0, 300), draw_f(200, 300)},
                         {0, 0},
                         draw_f(0, 300),
                         draw_f(100, 300)};
    x.i_d_end = j % 5 ? p.i_d_min : x.i_ref.d;
    x.i_q_least = j % 3 ? 0.0f : draw_f(0, 5);
    estimate_t est = {draw_f(-3, 3), draw_f(-300, 300)};
    ab_t i_ab = {draw_f(-5, 5), draw_f(-5, 5)};
    float u_dc = j % 9 ? draw_f(400, 600) : 0.0f, w_ref = draw_f(-300, 300),
          reserve = draw_f(0, 60);
    control_state_t was = x;
    rot_t r = rot_of(est.theta);
    vec_t u = of_ab(control_step(&p, &x, est, r, i_ab, u_dc, w_ref, reserve, 2e-4f));

    double w = (double)est.omega, ref = (double)w_ref;
    double want = (double)p.k_p_speed * ((double)p.weight_ref * ref - w) + (double)was.i_int;
    double less = fmin((double)p.L_d - (double)p.L_q, 0.0);
    double alone = (double)p.psi_f + less * fmin((double)was.i_ref.d - (double)was.i_d_fw, 0.0);
    double share = alone / ((double)p.psi_f + less * (double)was.i_ref.d);
    want *= share;
    double most = sqrt(fmax(pow((double)p.i_max, 2.0) - pow((double)was.i_ref.d, 2.0), 0.0));
    double held = fabs((double)was.i_ref.q);
    held =
        was.i_ref.d > was.i_d_end ? held : fmax(held - (double)p.i_q_step, (double)was.i_q_least);
    most = was.u_abs > was.u_max ? fmin(most, held) : most;
    double i_q = (double)was.i_ref.q;
    i_q = bounded(i_q + bounded(want - i_q, (double)p.i_q_step), most);
    check("torque current", near((double)x.i_ref.q, i_q, 1e-5));
    double grow = ref - w + (i_q - want) / (share * (double)p.k_p_speed);
    check("speed's integrator",
          near((double)x.i_int, (double)was.i_int + T * (double)p.k_i_speed * grow, 1e-5));

    vec_t turn = cexp(I * (double)est.theta), now = of_ab(i_ab) * conj(turn);
    vec_t i = 0.5 * (now + of_dq(was.i_1));
    check("mean current", near_v(of_dq(x.i), i, 1e-5) && near_v(of_dq(x.i_1), now, 1e-5));
    double mtpa = -0.3 * fmin(fabs(i_q) * (double)p.curve_inv_step, CURVE_N - 1.0);
    double i_d = fmax(mtpa + (double)was.i_d_fw, (double)p.i_d_min);
    check("d current", near((double)x.i_ref.d, i_d, 1e-4));
    double by = (double)p.by_reference;
    vec_t i_x = by * (i_d + I * i_q) + (1.0 - by) * i;
    vec_t v = (double)p.k_t_d * i_d - (double)p.k_p_d * creal(i) - w * (double)p.L_q * cimag(i_x) +
              I * ((double)p.k_t_q * i_q - (double)p.k_p_q * cimag(i) +
                   w * ((double)p.L_d * creal(i_x) + (double)p.psi_f)) +
              of_dq(was.u_int);
    double limit = fmax((double)u_dc / sqrt(3.0) - (double)reserve, 1.0);
    vec_t cut = cabs(v) > limit ? v * limit / cabs(v) : v;
    check("voltage", near_v(u, cut * turn * cexp(I * 1.5 * T * w), 1e-4));
    check("voltage's size", near((double)x.u_abs, cabs(v), 1e-5));
    check("voltage's limit", near((double)x.u_max, limit, 1e-5));
    vec_t lack = cut - v;
    double int_d =
        (double)was.u_int.d + (double)p.k_i_d * (i_d - creal(i) + creal(lack) / (double)p.k_t_d);
    double int_q =
        (double)was.u_int.q + (double)p.k_i_q * (i_q - cimag(i) + cimag(lack) / (double)p.k_t_q);
    check("sums", near_v(of_dq(x.u_sum) - of_dq(was.u_sum), cut, 1e-3) &&
                      near_v(of_dq(x.i_sum) - of_dq(was.i_sum), i, 1e-4));
    check("current's integrators", near_v(of_dq(x.u_int), int_d + I * int_q, 1e-4));
    double fw = (double)was.i_d_fw + (double)p.k_fw * ((double)p.fw_margin * limit - cabs(v));
    check("field weakening", near((double)x.i_d_fw, fmin(fmax(fw, (double)p.i_d_min), 0.0), 1e-4));
    control_ready(&p, &x, est.omega);
    check("ready", x.i_ref.q == 0.0f && near((double)x.i_int, 0.02 * 0.6 * w, 1e-5));
    check("ready: gives way at its end", x.i_d_end == p.i_d_min && x.i_q_least == 0.0f);
}

/* Where the torque current gives way, and what a generator keeps: 1.5 A here. */
static void ends(void) {
    for (int j = 0; j < 400; j++) {
        control_params_t p = {.i_d_min = -6.0f, .i_q_brake = 1.5f};
        control_state_t x = {.i_ref = {draw_f(-5, 0), 1.0f}, .i = {draw_f(-7, 1), 1.0f}};
        float w = draw_f(-300, 300), ref = draw_f(-300, 300), far = draw_f(0, 2);
        control_ends(&p, &x, ref, w, far);
        int brakes = w > 0.0f ? ref < w : ref > w;
        int beyond = x.i.d < x.i_ref.d - far;
        check("kept in braking", x.i_q_least == (brakes ? 1.5f : 0.0f));
        check("gives way at once", x.i_d_end == (brakes && beyond ? 0.0f : -6.0f));
    }
}

/* Each signal in words: magnitudes, and signs seen in the direction of motion. */
static void signals(void) {
    signal_params_t p = {0.03f, 190.0f, 0.004f, 0.2f, 0.003f, 12.0f};
    for (int j = 0; j < 400; j++) {
        signal_state_t x = {draw_f(-300, 300), draw_f(-300, 300), draw_f(-300, 300), draw_f(-5, 5),
                            draw_f(-1, 1),     draw_f(0, 300),    draw_f(0, 0.1),    draw_f(0, 1),
                            draw_f(0, 1),      draw_f(0, 2),      draw_f(0, 1)};
        float y[SIGNAL_N];
        signals_read(&p, &x, y);
        double dir = sgn((double)x.omega), w = (double)p.inv_omega;
        const double want[SIGNAL_N] = {fabs((double)x.omega) * w,
                                       dir * (double)x.i_q * (double)p.inv_i,
                                       dir * (double)x.disagree / (M_PI / 6.0),
                                       dir * (double)p.alpha_per_s *
                                           ((double)x.omega - (double)x.omega_2) * w,
                                       dir * ((double)x.omega_ref - (double)x.omega) * w,
                                       dir * (double)x.omega_ref * w,
                                       (double)x.k_s,
                                       (double)x.emf * (double)p.inv_e,
                                       (double)x.hf * (double)p.inv_i_hf,
                                       2.0 * sqrt((double)x.hfi_var),
                                       2.0 * sqrt((double)x.smo_var),
                                       (double)x.voltage};
        for (int k = 0; k < SIGNAL_N; k++) {
            check("signal", near((double)y[k], want[k], 2e-6));
        }
    }
}

static double toward(float was, double to) {
    return (double)was + (double)0.03f * (to - (double)was);
}

static void filters(void) {
    signal_params_t p = {0.03f, 190.0f, 0.004f, 0.2f, 0.003f, 12.0f};
    for (int j = 0; j < 300; j++) {
        drive_state_t x = {0};
        x.est.omega = draw_f(-300, 300), x.control.i.q = draw_f(-5, 5);
        x.theta_hfi = draw_f(-3, 3), x.theta_smo = draw_f(-3, 3);
        x.emf.e.a = draw_f(-99, 99), x.emf.e.b = draw_f(-99, 99), x.emf.err = draw_f(-1, 1);
        x.hfi.valid = j % 2 ? 1.0f : 0.0f, x.hfi.amplitude = draw_f(0, 0.1);
        x.hfi.err = draw_f(-1, 1), x.control.u_abs = draw_f(0, 400);
        x.control.u_max = draw_f(200, 300), x.k_s = draw_f(0, 1);
        signal_state_t w = {draw_f(-300, 300),
                            draw_f(-300, 300),
                            0,
                            draw_f(-5, 5),
                            draw_f(-1, 1),
                            draw_f(0, 99),
                            draw_f(0, 0.1),
                            draw_f(0, 1),
                            draw_f(0, 1),
                            draw_f(0, 2),
                            0};
        x.signal = w;
        drive_signals(&p, &x, 77.0f);
        const signal_state_t *y = &x.signal;
        double d = wrapped((double)x.theta_hfi - (double)x.theta_smo);
        d = fabs(d) < M_PI / 2.0 ? d : sgn(d) * (M_PI - fabs(d));
        check("filter: speed", near((double)y->omega, toward(w.omega, (double)x.est.omega), 1e-6));
        check("filter: speed again",
              near((double)y->omega_2, toward(w.omega_2, (double)y->omega), 1e-6));
        check("filter: current", near((double)y->i_q, toward(w.i_q, (double)x.control.i.q), 1e-6));
        check("filter: disagreement", near((double)y->disagree, toward(w.disagree, d), 1e-6));
        check("filter: EMF", near((double)y->emf, toward(w.emf, cabs(of_ab(x.emf.e))), 1e-6));
        double hf = (double)x.hfi.valid * (double)x.hfi.amplitude;
        check("filter: injection", fabs((double)y->hf - toward(w.hf, hf)) < 1e-7);
        check("filter: its error",
              near((double)y->hfi_var, toward(w.hfi_var, pow((double)x.hfi.err, 2.0)), 1e-6));
        check("filter: EMF's error",
              near((double)y->smo_var, toward(w.smo_var, pow((double)x.emf.err, 2.0)), 1e-6));
        double ratio = (double)x.control.u_abs / (double)x.control.u_max;
        check("filter: voltage", near((double)y->voltage, toward(w.voltage, ratio), 1e-6));
        check("filter: as they are", y->omega_ref == 77.0f && y->k_s == x.k_s);
    }
}

void check_control(void) {
    for (int j = 0; j < 2000; j++) {
        control(j);
    }
    ends();
    signals();
    filters();
}
