/* The schedule on the signals that a foreign drive has. */
#include "ks_hook.h"

#include "blend.h"

/* Signals that follow from speed, torque current and difference of the angles. */
static int known(uint32_t signal) {
    return signal == SIGNAL_SPEED || signal == SIGNAL_TORQUE_CURRENT ||
           signal == SIGNAL_DISAGREEMENT || signal == SIGNAL_ACCELERATION || signal == SIGNAL_K_S;
}

int ks_hook_init(const ks_hook_params_t *p, ks_hook_state_t *x) {
    signals_clear(&x->signal);
    x->k_s = 1.0f;
    x->signal.k_s = x->k_s;
    int found = ks_schedule_init(&p->schedule, &x->schedule);
    const ks_table_t *t = p->schedule.table;
    for (uint32_t a = 0; found == KS_OK && a < t->n_axes; a++) {
        if (!known(t->axis[a].signal)) {
            found = KS_BAD_AXES;
            x->schedule.check = found;
            x->schedule.fault |= KS_FAULT_TABLE;
        }
    }
    return found;
}

/* Whether the signals are what plausible inputs make. */
static int sound(const ks_hook_params_t *p, const signal_state_t *x) {
    return abs_f(x->omega) <= p->omega_most && abs_f(x->omega_2) <= p->omega_most &&
           abs_f(x->i_q) <= p->i_most && abs_f(x->disagree) <= PI_F;
}

float ks_hook_step(const ks_hook_params_t *p, ks_hook_state_t *x, float omega, float i_q,
                   float difference) {
    int fine =
        abs_f(omega) <= p->omega_most && abs_f(i_q) <= p->i_most && abs_f(difference) < 3.0f * PI_F;
    int mend = !sound(p, &x->signal);
    x->schedule.fault |= fine && !mend ? 0 : KS_FAULT_INPUT;
    if (mend) {
        signals_clear(&x->signal);
        x->signal.omega = x->signal.omega_2 = fine ? omega : 0.0f;
        x->signal.i_q = fine ? i_q : 0.0f;
    }
    if (fine) {
        signals_filter(&p->signal, &x->signal, omega, i_q, wrap_pi(difference));
    }
    float want = ks_schedule_step(&p->schedule, &x->schedule, &p->signal, &x->signal);
    x->k_s = ks_slew(ks_limit(x->k_s), want, p->k_s_step);
    x->signal.k_s = x->k_s;
    return x->k_s;
}

int16_t ks_hook_step_q15(const ks_hook_params_t *p, ks_hook_state_t *x, int16_t omega, int16_t i_q,
                         int16_t difference) {
    float unit = 1.0f / 32768.0f;
    float k_s = ks_hook_step(p, x, unit * p->omega_full * (float)omega,
                             unit * p->i_full * (float)i_q, unit * PI_F * (float)difference);
    return (int16_t)(32767.0f * k_s + 0.5f);
}
