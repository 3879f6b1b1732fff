/* What the sums of PROBE and PUSH mean. Complex numbers are ab_t: a + j b. */
#include "bring_up_judge.h"

#include "dead_time.h"
#include "trig.h"

/* A real 2 x 2 matrix as the map z -> p z + q conj(z). */
typedef struct {
    ab_t p;
    ab_t q;
} map_t;

static ab_t times(ab_t x, ab_t y) {
    ab_t z = {x.a * y.a - x.b * y.b, x.a * y.b + x.b * y.a};
    return z;
}

static ab_t conj_of(ab_t x) {
    ab_t z = {x.a, -x.b};
    return z;
}

static ab_t sum(ab_t x, ab_t y) {
    ab_t z = {x.a + y.a, x.b + y.b};
    return z;
}

/* What undoes each WIRING_*: the map from the measured currents to the right ones. */
static map_t cure(int32_t wiring) {
    static const map_t cures[WIRING_UNKNOWN] = {
        {{1.0f, 0.0f}, {0.0f, 0.0f}},
        {{0.0f, 0.0f}, {1.0f, 0.0f}},
        {{0.0f, 0.0f}, {-0.5f, HALF_SQRT3_F}},
        {{0.0f, 0.0f}, {-0.5f, -HALF_SQRT3_F}},
        {{-0.5f, HALF_SQRT3_F}, {0.0f, 0.0f}},
        {{-0.5f, -HALF_SQRT3_F}, {0.0f, 0.0f}},
        {{0.0f, -INV_SQRT3_F}, {-1.0f, -INV_SQRT3_F}},
        {{0.0f, INV_SQRT3_F}, {1.0f, INV_SQRT3_F}},
    };
    return cures[wiring];
}

/* f after g. */
static map_t after(map_t f, map_t g) {
    map_t y = {
        sum(times(f.p, g.p), times(f.q, conj_of(g.q))),
        sum(times(f.p, g.q), times(f.q, conj_of(g.p))),
    };
    return y;
}

#define SINGULAR 0.93f /* |q| / |p| from which on a direction does not answer at all */

/* How far a map is from that of a salient machine at any angle: p real, |q| = anisotropy |p|. */
static float oddity(const bring_up_params_t *p, map_t m) {
    float size = max_f(norm_ab(m.p), 1.0e-9f);
    float across = m.p.b / size;
    float excess = norm_ab(m.q) / size - p->anisotropy;
    float none = norm_ab(m.q) > SINGULAR * size ? 1.0f : 0.0f;
    return across * across + excess * excess + none;
}

#define LEANS 0.2f   /* anisotropy beyond the machine's that a leg without its duty makes */
#define ODD 0.3f     /* oddity from which on a wiring does not explain the steps */
#define R_LEAST 0.6f /* resistance over its nominal value, bounds of what is believed */
#define R_MOST 1.6f
#define LIKEWISE 0.15f /* share of the largest step from which on a lag counts */

static float product(const bring_up_state_t *x, int j, int k) {
    return x->along_a[j].a * x->along_a[k].a + x->along_a[j].b * x->along_a[k].b +
           x->along_b[j].a * x->along_b[k].a + x->along_b[j].b * x->along_b[k].b;
}

/* Matrix of the steps along both axes. Where the current steps most, and other lags in which it
 * steps likewise, count; its decay after the step does not. Sets the delay: their mean. */
static map_t steps(const bring_up_params_t *p, bring_up_state_t *x) {
    int most = 0;
    for (int j = 1; j < BRING_UP_LAGS; j++) {
        most = product(x, j, j) > product(x, most, most) ? j : most;
    }
    float all = max_f(product(x, most, most), 1.0e-20f);
    ab_t a = {0.0f, 0.0f};
    ab_t b = {0.0f, 0.0f};
    float weight = 0.0f;
    float mean = 0.0f;
    for (int j = 0; j < BRING_UP_LAGS; j++) {
        float share = product(x, j, most) / all;
        if (share > LIKEWISE) {
            a = sum(a, x->along_a[j]);
            b = sum(b, x->along_b[j]);
            weight += share;
            mean += share * (float)j;
        }
    }
    x->delay = mean / max_f(weight, LIKEWISE);
    float per = 1.0f / (float)p->n_probe; /* two axes, and half of the sum of two */
    map_t m = {{per * (a.a + b.b), per * (a.b - b.a)}, {per * (a.a - b.b), per * (a.b + b.a)}};
    return m;
}

/* Faults of a wiring, whose steps may be inverted on top. */
static int32_t wiring_fault(int32_t wiring, int inverted) {
    if (wiring == WIRING_UNKNOWN) {
        return BRING_UP_FAULT_WIRING;
    }
    int channel = wiring == WIRING_CHANNEL_A || wiring == WIRING_CHANNEL_B;
    int32_t y =
        channel ? BRING_UP_FAULT_CHANNEL : (wiring == WIRING_RIGHT ? 0 : BRING_UP_FAULT_PHASES);
    return y | (inverted && !channel ? BRING_UP_FAULT_SIGN : 0);
}

/* Finds the wiring that explains the map m best, and the d axis. */
static void judge_wiring(const bring_up_params_t *p, bring_up_state_t *x, map_t m) {
    float least = ODD;
    int inverted = 0;
    x->wiring = WIRING_UNKNOWN;
    for (int32_t w = 0; w < WIRING_UNKNOWN; w++) {
        map_t c = after(cure(w), m);
        float odd = oddity(p, c);
        int channel = w == WIRING_CHANNEL_A || w == WIRING_CHANNEL_B;
        int fits = c.p.a > 0.0f || !channel; /* inverted, one channel is the other */
        if (fits && odd < least) {
            least = odd;
            inverted = c.p.a < 0.0f;
            x->wiring = w;
        }
    }
    x->fault |= wiring_fault(x->wiring, inverted);
    x->d = rot_of(0.5f * angle_of(m.q));
}

void bring_up_judge_probe(const bring_up_params_t *p, bring_up_state_t *x) {
    map_t m = steps(p, x);
    if (max_f(norm_ab(m.p), norm_ab(m.q)) < p->i_least) {
        x->fault |= BRING_UP_FAULT_DEAF;
        return;
    }
    x->fault |= abs_f(x->delay - 1.0f) > p->delay_band ? BRING_UP_FAULT_DELAY : 0;
    judge_wiring(p, x, m);
    /* inductances are symmetric; a gain of one channel makes (g_a - g_b) / sqrt(12) of this */
    int lopsided = x->wiring == WIRING_RIGHT && abs_f(m.p.b) > p->lopsided * norm_ab(m.p);
    int leans = x->wiring == WIRING_RIGHT && norm_ab(m.q) > (p->anisotropy + LEANS) * norm_ab(m.p);
    x->fault |= lopsided || leans ? BRING_UP_FAULT_SCALE : 0;
}

/* With k = T_s / L_d a step is k (u - lost - R i). Where iron saturates, the current falls faster at
 * the upper level than there; counted as at L_d, both levels tell lost voltage from resistance. */
void bring_up_judge_push(const bring_up_params_t *p, bring_up_state_t *x) {
    float rises = (float)(p->n_cycles * (p->n_push - 1));
    float holds = 1.0f / (float)(p->n_cycles * (p->n_hold - 1));
    float i_0 = holds * x->level[0];
    float i_1 = holds * x->level[1];
    float i_rise = x->level_rise / rises;
    float fall_0 = p->L_high / p->L_d * holds * x->fall[0];
    float fall_1 = p->L_low / p->L_d * holds * x->fall[1];
    float k_R = (fall_1 - fall_0) / max_f(i_0 - i_1, 1.0e-9f);
    float k_nominal = p->T_s / p->L_d;
    k_R = clamp_f(k_R, R_LEAST * k_nominal * p->R_s, R_MOST * k_nominal * p->R_s);
    float k_lost = -0.5f * (fall_0 + fall_1 + k_R * (i_0 + i_1));
    float k = max_f((x->rise / rises + k_lost + k_R * i_rise) / p->u_push, 1.0e-20f);
    ab_t axis = {x->d.c, x->d.s};
    ab_t full = dead_time_voltage(p->u_lost, 1.0e6f, axis);
    float along = full.a * axis.a + full.b * axis.b;
    x->R_s = k_R / k;
    x->scale = k * p->L_d / p->T_s;
    x->lost = p->u_lost > 0.0f ? k_lost / (k * along) : 1.0f;
    int off = !(abs_f(x->scale - 1.0f) <= p->scale_band);
    x->fault |= off ? BRING_UP_FAULT_SCALE : 0;
    x->fault |= !off && x->lost < p->lost_least ? BRING_UP_FAULT_DEAD_TIME : 0;
}
