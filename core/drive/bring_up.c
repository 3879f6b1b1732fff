/* Pulses, and sums of the steps of the current. */
#include "bring_up.h"

#include "bring_up_judge.h"

void bring_up_init(bring_up_state_t *x) {
    ab_t zero = {0.0f, 0.0f};
    x->phase = BRING_UP_REST;
    x->n = 0;
    x->fault = 0;
    x->wiring = WIRING_RIGHT;
    x->delay = 0.0f;
    x->scale = 0.0f;
    x->lost = 0.0f;
    x->R_s = 0.0f;
    x->i_1 = zero;
    for (int j = 0; j < BRING_UP_LAGS; j++) {
        x->along_a[j] = zero;
        x->along_b[j] = zero;
    }
    x->d.c = 1.0f;
    x->d.s = 0.0f;
    x->rise = 0.0f;
    x->level_rise = 0.0f;
    for (int j = 0; j < 2; j++) {
        x->fall[j] = 0.0f;
        x->level[j] = 0.0f;
    }
}

static void enter(bring_up_state_t *x, int32_t phase) {
    x->phase = phase;
    x->n = 0;
}

/* Sign of pulse j: + - - +, so that the current and its torque have no mean. */
static float way(int32_t j) { return (j & 3) == 0 || (j & 3) == 3 ? 1.0f : -1.0f; }

/* Takes in the step of one sample; returns the voltage of PROBE. Four pulses along alpha, then four
 * along beta. */
static ab_t probe(const bring_up_params_t *p, bring_up_state_t *x, ab_t step) {
    int32_t pulse = x->n / p->n_gap;
    int32_t at = x->n - pulse * p->n_gap;
    float s = way(pulse);
    int along_b = (pulse & 4) != 0;
    if (at >= 1 && at <= BRING_UP_LAGS) {
        ab_t *to = along_b ? &x->along_b[at - 1] : &x->along_a[at - 1];
        to->a += s * step.a;
        to->b += s * step.b;
    }
    float u = at == 0 ? s * p->u_probe : 0.0f;
    ab_t y = {along_b ? 0.0f : u, along_b ? u : 0.0f};
    return y;
}

/* Place in a cycle of PUSH: rise, first level, half of the fall, second level, the other half. */
enum { PART_NONE = 0, PART_RISE, PART_HIGH, PART_HALF, PART_LOW, PART_END };

static int part_of(const bring_up_params_t *p, int32_t at) {
    int32_t half = p->n_push / 2;
    int32_t high = p->n_push + p->n_hold;
    int32_t low = high + half + p->n_hold;
    if (at < 0 || at >= low + half) {
        return PART_NONE;
    }
    if (at < high) {
        return at < p->n_push ? PART_RISE : PART_HIGH;
    }
    return at < high + half ? PART_HALF : (at < low ? PART_LOW : PART_END);
}

static int32_t cycle_periods(const bring_up_params_t *p) {
    return 2 * (p->n_push + p->n_hold) + p->n_gap;
}

/* Takes in the step of one sample; returns the voltage of PUSH. A sample shows what was commanded
 * two periods before. */
static ab_t push(const bring_up_params_t *p, bring_up_state_t *x, ab_t step, ab_t i_ab) {
    int32_t cycle = x->n / cycle_periods(p);
    int32_t at = x->n - cycle * cycle_periods(p);
    float s = way(cycle);
    float d = s * (x->d.c * step.a + x->d.s * step.b);
    float mean = s * (x->d.c * i_ab.a + x->d.s * i_ab.b) - 0.5f * d;
    int seen = part_of(p, at - 2);
    if (seen != part_of(p, at - 3)) { /* iron loss follows the voltage, not the current */
        seen = PART_NONE;
    }
    if (seen == PART_RISE) {
        x->rise += d;
        x->level_rise += mean;
    } else if (seen == PART_HIGH || seen == PART_LOW) {
        int j = seen == PART_LOW;
        x->fall[j] += d;
        x->level[j] += mean;
    }
    int now = part_of(p, at);
    float u =
        now == PART_RISE ? p->u_push : (now == PART_HALF || now == PART_END ? -p->u_push : 0.0f);
    ab_t y = {s * u * x->d.c, s * u * x->d.s};
    return y;
}

/* Enters the next phase when the present one has had its periods. */
static void next(const bring_up_params_t *p, bring_up_state_t *x, ab_t i_ab) {
    x->n = count_i(x->n, 1);
    if (x->phase == BRING_UP_REST && x->n >= p->n_rest) {
        x->fault |= norm_ab(i_ab) > p->i_rest ? BRING_UP_FAULT_MOVES : 0;
        enter(x, x->fault != 0 ? BRING_UP_DONE : BRING_UP_PROBE);
    } else if (x->phase == BRING_UP_PROBE && x->n >= p->n_probe * p->n_gap) {
        bring_up_judge_probe(p, x);
        enter(x, x->fault != 0 ? BRING_UP_DONE : BRING_UP_PUSH);
    } else if (x->phase == BRING_UP_PUSH && x->n >= p->n_cycles * cycle_periods(p)) {
        bring_up_judge_push(p, x);
        enter(x, BRING_UP_DONE);
    }
}

/* Whether phase, count and the voltage u [V] are such as the check computes. */
static int sound(const bring_up_params_t *p, const bring_up_state_t *x, ab_t u) {
    float most =
        1.001f * max_f(p->u_probe, p->u_push); /* rounding makes the d axis longer than 1 */
    return x->phase >= BRING_UP_REST && x->phase <= BRING_UP_DONE && x->n >= 0 &&
           abs_f(u.a) <= most && abs_f(u.b) <= most;
}

ab_t bring_up_step(const bring_up_params_t *p, bring_up_state_t *x, float i_a, float i_b) {
    ab_t u = {0.0f, 0.0f};
    ab_t i_ab = phases_to_ab(i_a, i_b);
    if (!(norm_ab(i_ab) <= p->i_stop)) {
        x->fault |= BRING_UP_FAULT_CURRENT;
        x->phase = BRING_UP_DONE;
    }
    ab_t step = {i_ab.a - x->i_1.a, i_ab.b - x->i_1.b};
    if (x->phase == BRING_UP_PROBE) {
        u = probe(p, x, step);
    } else if (x->phase == BRING_UP_PUSH) {
        u = push(p, x, step, i_ab);
    }
    if (x->phase != BRING_UP_DONE) {
        next(p, x, i_ab);
    }
    x->i_1 = i_ab;
    if (!sound(p, x, u)) {
        ab_t none = {0.0f, 0.0f};
        x->fault |= BRING_UP_FAULT_STATE;
        x->phase = BRING_UP_DONE;
        u = none;
    }
    return u;
}

void turn_begin(turn_count_t *x, float theta) {
    x->theta = theta;
    x->turns = 0.0f;
}

void turn_count(turn_count_t *x, float theta) {
    x->turns += wrap_pi(theta - x->theta) * (1.0f / TWO_PI_F);
    x->theta = theta;
}

int32_t turn_pole_pairs(const turn_count_t *x, float shaft_turns) {
    float turns = abs_f(x->turns) / max_f(abs_f(shaft_turns), 1.0e-6f);
    return (int32_t)(clamp_f(turns, 0.0f, 1000.0f) + 0.5f);
}
