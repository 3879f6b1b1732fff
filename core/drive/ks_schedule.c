/* Decides by the table or by the built-in rule. */
#include "ks_schedule.h"

int ks_schedule_init(const ks_schedule_params_t *p, ks_schedule_state_t *x) {
    x->k_s_ref = 1.0f;
    x->wait = 0;
    x->check = p->table != 0 && p->values != 0 ? ks_table_check(p->table, p->values, p->motor_hash)
                                               : KS_BAD_MAGIC;
    x->fault = x->check == KS_OK ? 0 : KS_FAULT_TABLE;
    return x->check;
}

/* Fills those of y[SIGNAL_N] that the table reads. Returns whether all of them are finite: x - x is
 * 0 if x is finite and NaN if not. */
static int read_axes(const ks_table_t *t, const signal_params_t *p, const signal_state_t *x,
                     float *y) {
    float dir = signals_direction(x);
    float zero = 0.0f;
    for (uint32_t a = 0; a < t->n_axes; a++) {
        uint32_t which = t->axis[a].signal;
        float v = signal_at(p, x, dir, which);
        y[which] = v;
        zero += v - v;
    }
    return zero == 0.0f;
}

static float decide(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                    const signal_params_t *signal_params, const signal_state_t *signals) {
    int use_table = x->check == KS_OK;
    float y[SIGNAL_N];
    float speed = signal_at(signal_params, signals, 1.0f, SIGNAL_SPEED);
    int finite = use_table ? read_axes(p->table, signal_params, signals, y) : finite_f(speed);
    x->fault |= finite ? 0 : KS_FAULT_INPUT;
    return use_table ? ks_table_eval(p->table, p->values, y) : ks_rule(&p->rule, speed);
}

float ks_schedule_step(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                       const signal_params_t *signal_params, const signal_state_t *signals) {
    if (x->wait <= 0 || x->wait > p->periods) {
        x->k_s_ref = decide(p, x, signal_params, signals);
        x->wait = p->periods;
    }
    x->wait -= 1;
    return x->k_s_ref;
}
