/* Decides by the table or by the built-in rule. */
#include "ks_schedule.h"

#include "ks_lookup.h"

int ks_schedule_init(const ks_schedule_params_t *p, ks_schedule_state_t *x) {
    x->k_s_ref = 1.0f;
    x->wait = 0;
    x->check = p->table != 0 && p->values != 0 ? ks_table_check(p->table, p->values, p->motor_hash)
                                               : KS_BAD_MAGIC;
    x->fault = x->check == KS_OK ? 0 : KS_FAULT_TABLE;
    return x->check;
}

/* Kept apart, so that the periods without a decision save no registers for it. */
CORE_APART float decide(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                        const signal_params_t *signal_params, const signal_state_t *signals) {
    int use_table = x->check == KS_OK;
    float y[SIGNAL_N];
    float speed = signal_at(signal_params, signals, 1.0f, SIGNAL_SPEED);
    int finite = use_table ? ks_read_axes(p->table, signal_params, signals, y) : finite_f(speed);
    x->fault |= finite ? 0 : KS_FAULT_INPUT;
    x->k_s_ref = use_table ? ks_table_eval(p->table, p->values, y) : ks_rule(&p->rule, speed);
    x->wait = p->periods - 1;
    return x->k_s_ref;
}

float ks_schedule_step(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                       const signal_params_t *signal_params, const signal_state_t *signals) {
    if (x->wait <= 0 || x->wait > p->periods) {
        return decide(p, x, signal_params, signals);
    }
    x->wait -= 1;
    return x->k_s_ref;
}
