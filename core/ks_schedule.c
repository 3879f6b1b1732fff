/* Table or built-in rule. */
#include "ks_schedule.h"

int ks_schedule_init(const ks_schedule_params_t *p, ks_schedule_state_t *x) {
    x->k_s_ref = 1.0f;
    x->wait = 0;
    x->check = p->table != 0 && p->values != 0 ? ks_table_check(p->table, p->values, p->motor_hash)
                                               : KS_BAD_MAGIC;
    x->fault = x->check == KS_OK ? 0 : KS_FAULT_TABLE;
    return x->check;
}

/* All signals that the decision reads are finite. */
static int signals_finite(const ks_table_t *t, const float *y) {
    int finite = 1;
    for (uint32_t a = 0; a < t->n_axes; a++) {
        finite &= finite_f(y[t->axis[a].signal]);
    }
    return finite;
}

static float decide(const ks_schedule_params_t *p, ks_schedule_state_t *x, const float *y) {
    int use_table = x->check == KS_OK;
    int finite = use_table ? signals_finite(p->table, y) : finite_f(y[SIGNAL_SPEED]);
    x->fault |= finite ? 0 : KS_FAULT_INPUT;
    return use_table ? ks_table_eval(p->table, p->values, y) : ks_rule(&p->rule, y[SIGNAL_SPEED]);
}

float ks_schedule_step(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                       const signal_params_t *signal_params, const signal_state_t *signals) {
    if (x->wait <= 0) {
        float y[SIGNAL_N];
        signals_read(signal_params, signals, y);
        x->k_s_ref = decide(p, x, y);
        x->wait = p->periods;
    }
    x->wait -= 1;
    return x->k_s_ref;
}
