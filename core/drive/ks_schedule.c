/* Decides by the table or by the built-in rule. */
#include "ks_schedule.h"

#include "ks_lookup.h"

int ks_schedule_init(const ks_schedule_params_t *p, ks_schedule_state_t *x) {
    x->k_s_ref = 1.0f;
    x->wait = 0;
    int found = p->table != 0 && p->values != 0 ? ks_table_check(p->table, p->values, p->motor_hash)
                                                : KS_BAD_MAGIC;
    x->check = found == KS_OK ? KS_GOOD : found;
    x->fault = found == KS_OK ? 0 : KS_FAULT_TABLE;
    return found;
}

/* Decides without a good table, also where check is damaged. */
CORE_COLD static float by_rule(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                               const signal_params_t *signal_params,
                               const signal_state_t *signals) {
    float speed = signal_at(signal_params, signals, 1.0f, SIGNAL_SPEED);
    x->fault |= KS_FAULT_TABLE | (finite_f(speed) ? 0 : KS_FAULT_INPUT);
    x->k_s_ref = ks_rule(&p->rule, speed);
    x->wait = p->periods - 1;
    return x->k_s_ref;
}

/* Kept apart, so that the periods without a decision save no registers for it. */
CORE_APART float decide(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                        const signal_params_t *signal_params, const signal_state_t *signals) {
    if (x->check != KS_GOOD) {
        return by_rule(p, x, signal_params, signals);
    }
    float y[SIGNAL_N];
    int finite = ks_read_axes(p->table, signal_params, signals, y);
    x->fault |= finite ? 0 : KS_FAULT_INPUT;
    x->k_s_ref = ks_table_eval(p->table, p->values, y);
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
