/* Coupled observer: one period against its equations in complex numbers. */
#include "checks.h"

static coupled_params_t some_coupled(int j) {
    coupled_params_t p = {0};
    p.gain_0 = 0.004f, p.gain_w = 2e-5f, p.layer = 0.3f, p.inv_layer = j % 4 ? 3.3f : 0.0f;
    p.k_p = 0.024f, p.k_i = 5000.0f, p.k_l = 14.0f, p.k_tau = 90.0f;
    p.load_max = j % 5 ? 900.0f : 3.0f, p.alpha_rise = 0.2f, p.eps_rise = 0.05f, p.rise = 3.0f;
    p.rise_max = j % 2 ? 1.5f : 0.2f, p.inv_slope = 1.3f, p.k_h = 0.004f;
    p.drift.k = 0.03f, p.drift.most = j % 7 ? 5.0f : 0.3f, p.drift.alpha = 0.1f;
    p.drift.inv_omega = 0.005f, p.drift.inv_i_true = 9.0f, p.drift.inv_i = 0.3f;
    p.drift.res_most = j % 5 < 3 ? 4.0f : 0.2f, p.drift.dead_share = 0.4f, p.drift.res_share = 0.6f;
    p.drift.ind_most = j % 5 < 2 ? 3.0f : 0.3f, p.drift.ind_share = 0.7f;
    p.drift.u_dt = 6.0f, p.drift.u_dt_i = 18.0f, p.drift.to_loss = j % 5 ? 0.5f : 4.0f;
    p.drift.from_loss = 1.5f, p.drift.loss_max = 11.0f;
    p.drift.calm = 0.3f, p.drift.calm_rise = 1.2f;
    p.brake = j % 4 ? 6e4f : 0.0f, p.brake_least = j % 3 ? 0.4f : 0.0f;
    p.idle = j % 2 ? 0.006f : 0.0f, p.inv_i_idle = 0.4f;
    p.match.alpha = 0.5f, p.match.err_max = 1.0f, p.match.k_offset = 0.1f;
    p.match.offset_max = 1.0f;
    p.omega_floor = 30.0f, p.omega_max = j % 6 ? 700.0f : 250.0f;
    return p;
}

static vec_t excess(const drift_params_t *p, const drift_state_t *x, vec_t i) {
    vec_t sum = 0.0;
    for (int leg = 0; leg < 3; leg++) {
        vec_t axis = cexp(I * 2.0 * M_PI / 3.0 * leg);
        double own = creal(i * conj(axis));
        sum += 2.0 / 3.0 * axis *
               (bounded(own * (double)p->u_dt_i, (double)p->u_dt) -
                bounded(own * (double)x->loss * (double)p->inv_i_true, (double)x->loss));
    }
    return sum;
}

/* What is learned of the voltages from the error e at weight k_s, torque current i_q, speed w. */
static void drift(const drift_params_t *p, const drift_state_t *was, const drift_state_t *x,
                  double k_s, double e, double i_q, double w, int now) {
    double sum = (double)was->sum + e;
    check("drift: sum", fabs((double)x->sum - (now ? 0.0 : sum)) < 1e-6);
    double sign = (double)was->sign;
    sign += (double)p->alpha * (bounded(i_q * (double)p->inv_i_true, 1.0) - sign);
    double most = (double)p->most, k = (double)p->k;
    double fade = k_s > 0.0 ? 0.0 : (double)p->alpha;
    double even = (double)was->even + (1.0 - sign * sign) * (k * sum - fade * (double)was->even);
    even = bounded(even, most);
    /* gain of three integrators whose outputs, two of them times the current and one of these
     * times the speed, add up to one */
    double i = fmin(fabs(i_q) * (double)p->inv_i, 1.0);
    double rise = fmin(fabs(w) * (double)p->inv_omega, 1.0);
    double var[3] = {(double)p->dead_share, (double)p->res_share, (double)p->ind_share};
    double all = k * sign * sum / (var[0] + var[1] * i * i + var[2] * i * i * rise * rise);
    double dead = bounded((double)was->dead + var[0] * all, most);
    double res = bounded((double)was->res + i * var[1] * all, (double)p->res_most);
    double ind = bounded((double)was->ind + i * rise * var[2] * all, (double)p->ind_most);
    double loss = (1.0 - 0.1 * (1.0 - sign * sign)) * ((double)p->u_dt - (double)p->to_loss * dead);
    loss = fmin(fmax(loss, 0.0), (double)p->loss_max);
    double turn = res + rise * ind + dead + (double)p->from_loss * (loss - (double)p->u_dt);
    double trust = fmin((double)p->calm + (double)p->calm_rise * i, 1.0);
    const drift_state_t want = {(float)dead, (float)res,  (float)ind, (float)even, (float)sign,
                                (float)loss, (float)turn, 0.0f,       (float)trust};
    const drift_state_t *y = now ? &want : was;
    check("drift: dead time", fabs((double)(x->dead - y->dead)) < 2e-6);
    check("drift: resistance", fabs((double)(x->res - y->res)) < 2e-6);
    check("drift: inductance", fabs((double)(x->ind - y->ind)) < 2e-6);
    check("drift: even", fabs((double)(x->even - y->even)) < 2e-6);
    check("drift: sign", fabs((double)(x->sign - y->sign)) < 1e-6);
    check("drift: loss", fabs((double)(x->loss - y->loss)) < 1e-5);
    check("drift: turn", fabs((double)(x->turn - y->turn)) < 2e-5);
    check("drift: trust", fabs((double)(x->trust - y->trust)) < 1e-6);
}

static void one(int j) {
    const double T = (double)2e-4f;
    coupled_params_t p = some_coupled(j);
    coupled_state_t x = {0};
    x.psi.a = draw_f(-1, 1), x.psi.b = draw_f(-1, 1);
    x.i_1.a = draw_f(-5, 5), x.i_1.b = draw_f(-5, 5);
    x.load = draw_f(-3, 3), x.eps_f = draw_f(-0.4, 0.4);
    x.drift.dead = draw_f(-5, 5), x.drift.even = draw_f(-5, 5), x.drift.sign = draw_f(-1, 1);
    x.drift.res = draw_f(-4, 4), x.drift.ind = draw_f(-3, 3), x.drift.loss = draw_f(0, 11);
    x.drift.turn = draw_f(-5, 5), x.drift.sum = draw_f(-0.1, 0.1);
    x.drift.trust = draw_f(0.2, 1);
    float w = j % 3 ? draw_f(-240, 240) : draw_f(-33, 33);
    emf_estimate_t y = {{draw_f(-3, 3), w}, {0, 0}, 0, j % 8 ? 1.0f : 0.0f};
    ab_t i = {draw_f(-5, 5), draw_f(-5, 5)}, u = {draw_f(-200, 200), draw_f(-200, 200)};
    float k_s = j % 4 < 2 ? draw_f(0, 1) : (j % 8 < 4 ? draw_f(0, 0.02) : 0.0f),
          err = draw_f(-1, 1);
    int learn = j % 3 == 1 ? 1 + j % 2 : 0;
    flux_model_t m = {2.0f, 0.06f, 0.25f, 0.2f, 0.9f, j % 3 ? 0.05f : 1.4f};
    if (j % 9 == 0) { /* near lock: the flux that the current implies */
        vec_t at = cexp(I * (double)y.pll.theta), d = of_ab(i) * conj(at);
        vec_t psi = (0.9 + 0.06 * creal(d) + I * 0.25 * cimag(d)) * at;
        x.psi.a = (float)creal(psi), x.psi.b = (float)cimag(psi);
    }
    float share = j % 2 ? 1.0f : draw_f(0.4, 1);
    coupled_correct(&p, &x, share);
    coupled_state_t was = x;
    emf_estimate_t old = y;
    float jump = coupled_observe(&p, &m, &x, &y, rot_of(y.pll.theta), i, u, k_s, err, learn, 2e-4f);

    int led = fabs((double)w) >= 30.0 || k_s > 0.01f;
    int fresh = !led || old.valid == 0.0f;
    vec_t r = cexp(I * (double)old.pll.theta);
    vec_t mean = 0.5 * (of_ab(i) + of_ab(was.i_1));
    vec_t psi =
        of_ab(was.psi) + T * (of_ab(u) + excess(&p.drift, &was.drift, mean) - (double)m.R_s * mean);
    vec_t c = of_ab(i) * conj(r);
    vec_t model = (double)m.psi_0 + (double)m.L_d * creal(c) + I * (double)m.L_q * cimag(c);
    vec_t aux = model - (double)m.L_qq * creal(c) - I * (double)m.L_d * cimag(c);
    psi = fresh ? model : psi * conj(r);
    vec_t e = (model - psi) * conj(aux) / fmax(pow(cabs(aux), 2.0), (double)m.psi_sq_min);
    double eps = bounded(-cimag(e), 1.0), along = creal(e);
    double inv = (double)p.inv_layer;
    double slide = inv > 0.0 ? (double)p.layer * (double)tanh_f((float)(along * inv)) : along;
    double gain =
        2.0 * (double)share * ((double)p.gain_0 + (double)p.gain_w * fabs((double)w)) * slide;
    double e_h = (double)k_s * (double)err;
    double part = bounded(cimag(c) * (double)p.drift.inv_i, 1.0);
    double away = (double)was.drift.even + (double)was.drift.turn * part;
    double trust = (double)was.drift.trust;
    double told = trust * trust * eps;
    double load = bounded((double)was.load + (double)p.k_l * told, (double)p.load_max);
    double eps_f = (double)was.eps_f + (double)p.alpha_rise * (told - (double)was.eps_f);
    double more = (double)p.rise * (fabs(eps_f) - (double)p.eps_rise);
    double f = trust * (1.0 + fmax(0.0, fmin(more, (double)p.rise_max)));
    load = fresh ? 0.0 : load;
    double tau = cimag(conj(psi) * c); /* flux times current */
    double omega = (double)w + T * ((double)p.k_i * f * f * eps + (double)p.k_tau * tau + load);
    omega = bounded(omega, (double)p.omega_max);
    double turn = (double)p.k_h * e_h;
    double beyond = (double)p.k_p * f * eps + turn;
    double theta = (double)old.pll.theta + T * omega + beyond;
    vec_t next = (psi + (gain + I * turn) * aux + I * T * away * psi) * r;
    check("coupled: flux", near_v(of_ab(x.psi), next, 4e-6));
    check("coupled: error", fabs((double)y.err - eps) < 2e-5);
    check("coupled: beyond its speed", fabs((double)jump - beyond) < 2e-6);
    drift(&p.drift, &was.drift, &x.drift, (double)k_s, e_h, cimag(c), (double)y.pll.omega,
          learn > 0);
    check("coupled: load", fabs((double)x.load - load) < 1e-3);
    check("coupled: rise", fabs((double)x.eps_f - eps_f) < 1e-5);
    check("coupled: speed", near((double)y.pll.omega, omega, 1e-5));
    check("coupled: angle", fabs(wrapped((double)y.pll.theta - theta)) < 8e-6);
    vec_t emf = I * r * (double)y.pll.omega * creal(aux);
    check("coupled: EMF", cabs(of_ab(y.e) - emf) <= 1e-6 * fabs((double)y.pll.omega));
    check("coupled: valid", y.valid == (led ? 1.0f : 0.0f));
    check("coupled: gain in odd periods", (x.match.mean != 0.0f) == (!fresh && learn == 1));
    check("coupled: offsets in even periods", (x.match.offset_a != 0.0f) == (!fresh && learn == 2));
    match_state_t sensors = was.match;
    dq_t aux_dq = {(float)creal(aux), (float)cimag(aux)};
    double now = (double)x.drift.trust;
    double inv_sq = 1.0 / fmax(pow(cabs(aux), 2.0), (double)m.psi_sq_min);
    match_offset(&p.match, &sensors, learn == 2, rot_of(old.pll.theta), aux_dq, (float)inv_sq,
                 (float)(now * now * now * now * eps), y.pll.omega);
    check("coupled: offsets by what is told",
          fabs((double)(x.match.offset_a - sensors.offset_a)) < 1e-5 &&
              fabs((double)(x.match.offset_b - sensors.offset_b)) < 1e-5);
}

/* The share of the correction that leans the angle no more than braking allows; more of it without
 * torque current. */
static void rates(int j) {
    coupled_params_t p = some_coupled(j);
    coupled_state_t x = {0};
    float k_s = j % 5 ? draw_f(0, 1) * (float)(j % 2) : 0.0f, emf = draw_f(0, 250);
    float i_q = draw_f(-5, 5), w = draw_f(-240, 240);
    coupled_correct(&p, &x, 1.0f);
    check("rates: all", x.gain_0 == 2.0f * p.gain_0 && x.gain_w == 2.0f * p.gain_w);
    coupled_rates(&p, &x, k_s, emf, i_q, w, 0);
    check("rates: as they were", x.gain_0 == 2.0f * p.gain_0 && x.gain_w == 2.0f * p.gain_w);
    coupled_rates(&p, &x, k_s, emf, i_q, w, 1);
    double a = fabs((double)w), against = (w < 0.0f ? 1.0 : -1.0) * (double)i_q;
    double rate = (double)p.gain_0 + (double)p.gain_w * a;
    double takes = (double)p.brake * against * rate, has = a * (double)emf;
    double least = (double)p.brake_least + (1.0 - (double)p.brake_least) * (double)k_s;
    double share = has < takes ? fmax(has / takes, least) : 1.0;
    double still = fmax(1.0 - fabs((double)i_q * (double)p.inv_i_idle), 0.0);
    double more = (double)k_s * (double)p.idle * still;
    check("rates: standstill", near((double)x.gain_0, 2.0 * share * (double)p.gain_0 + more, 1e-5));
    check("rates: speed", near((double)x.gain_w, 2.0 * share * (double)p.gain_w, 1e-5));
}

void check_coupled(void) {
    for (int j = 0; j < 4000; j++) {
        one(j);
        rates(j);
    }
}
