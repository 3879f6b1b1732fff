/* The step of one period as a linkable function, and the initial state. */
#include "drive.h"

#include "drive_stop.h"

ab_t drive_step(const drive_params_t *p, drive_state_t *x, const drive_in_t *in) {
    return drive_step_inline(p, x, in);
}

/* Zeros are written one by one: for a whole struct the compiler would call memset, which not every
 * target has. */
static void hfi_clear(hfi_state_t *x) {
    x->i_1.d = 0.0f;
    x->i_1.q = 0.0f;
    x->i_2.d = 0.0f;
    x->i_2.q = 0.0f;
    x->jump = 0.0f;
    hfi_quiet(x);
    x->err_f = 0.0f;
    x->answer = 0.0f;
}

static void smo_clear(smo_state_t *x) {
    x->i_hat.a = 0.0f;
    x->i_hat.b = 0.0f;
    x->z.a = 0.0f;
    x->z.b = 0.0f;
    x->v.a = 0.0f;
    x->v.b = 0.0f;
}

static void emf_clear(emf_estimate_t *x) {
    x->e.a = 0.0f;
    x->e.b = 0.0f;
    x->err = 0.0f;
    x->valid = 0.0f;
}

static void coupled_clear(const coupled_params_t *p, coupled_state_t *x) {
    x->psi.a = 0.0f;
    x->psi.b = 0.0f;
    x->i_1.a = 0.0f;
    x->i_1.b = 0.0f;
    x->load = 0.0f;
    drift_clear(&p->drift, &x->drift);
    x->eps_f = 0.0f;
    coupled_correct(p, x, 1.0f);
    x->match.gain = 0.0f;
    x->match.offset_a = 0.0f;
    x->match.offset_b = 0.0f;
    x->match.mean = 0.0f;
}

static void control_clear(control_state_t *x) {
    x->i_1.d = 0.0f;
    x->i_1.q = 0.0f;
    x->i.d = 0.0f;
    x->i.q = 0.0f;
    x->i_ref.d = 0.0f;
    x->i_ref.q = 0.0f;
    x->u_int.d = 0.0f;
    x->u_int.q = 0.0f;
    control_sum_anew(x);
    x->i_d_fw = 0.0f;
    x->u_abs = 0.0f;
    x->u_max = 1.0f;
}

static void lock_clear(const lock_params_t *p, lock_state_t *x, float omega) {
    lock_begin(p, x, omega);
    x->wait = LOCK_FIRST; /* a schedule decides in the first period and every n */
    x->calm = 0;
    x->turned = 0;
    x->restarts = 0;
    x->alarms = 0;
    x->reason = 0;
}

#define INIT_ANGLE 1.0e4f /* beyond, a float has too few digits of an angle [rad] */

/* An angle of any number of turns as one in [-pi, pi]. */
static float init_angle(float theta) {
    float t = sane_f(theta, INIT_ANGLE);
    return wrap_pi(t - TWO_PI_F * (float)(int32_t)(t / TWO_PI_F));
}

/* All words but the one that tells a trip. */
static void drive_clear(const drive_params_t *p, drive_state_t *x, float theta_0, float omega_0,
                        float k_s_0) {
    float at = init_angle(theta_0);
    float omega = guard_speed(omega_0, p->guard.omega);
    float k_s = ks_limit(k_s_0);
    hfi_clear(&x->hfi);
    emf_clear(&x->emf);
    smo_clear(&x->smo);
    x->flux.psi.a = 0.0f;
    x->flux.psi.b = 0.0f;
    coupled_clear(&p->coupled, &x->coupled);
    control_clear(&x->control);
    signals_clear(&x->signal);
    lock_clear(&p->lock, &x->lock, omega);
    x->u_1.a = 0.0f;
    x->u_1.b = 0.0f;
    x->u_2.a = 0.0f;
    x->u_2.b = 0.0f;
    x->fault = abs_f(theta_0) <= INIT_ANGLE && omega == omega_0 && k_s == k_s_0 ? 0 : FAULT_COMMAND;
    x->hfi.pll.theta = at;
    x->hfi.pll.omega = omega;
    x->emf.pll.theta = at;
    x->emf.pll.omega = omega;
    x->smo.omega_f = omega;
    x->est.theta = at;
    x->est.omega = omega;
    x->theta_hfi = at;
    x->theta_smo = at;
    x->k_s = k_s;
    x->signal.omega = omega;
    x->signal.omega_2 = omega;
    x->signal.omega_ref = omega;
    x->signal.k_s = k_s;
    control_ready(&p->control, &x->control, omega);
    start_begin(&x->start);
    x->start.phase = START_DONE;
}

void drive_init(const drive_params_t *p, drive_state_t *x, float theta_0, float omega_0,
                float k_s_0) {
    drive_clear(p, x, theta_0, omega_0, k_s_0);
    x->begun = DRIVE_BEGUN;
}

void drive_find_rotor(drive_state_t *x) {
    if (x->begun != DRIVE_BEGUN || x->start.phase == START_STOPPED || drive_is_to_stop(x)) {
        x->fault |= FAULT_COMMAND;
    } else {
        start_begin(&x->start);
    }
}

CORE_COLD void drive_trip(drive_state_t *x) {
    x->begun = DRIVE_TRIPPED;
    drive_stop(x);
}

CORE_COLD ab_t drive_mend(const drive_params_t *p, drive_state_t *x) {
    int fault = x->fault & FAULT_ALL; /* the word itself may be damaged */
    int stopped = x->start.phase == START_STOPPED || drive_is_to_stop(x);
    int stop = p->lock.action == LOCK_STOP || stopped;
    drive_clear(p, x, 0.0f, 0.0f, 1.0f);
    if (x->begun != DRIVE_BEGUN && x->begun != DRIVE_TRIPPED) { /* else a trip might be lost here */
        x->begun = DRIVE_BEGUN;
    }
    drive_find_rotor(x);
    x->fault = fault | FAULT_STATE;
    if (stop) {
        drive_stop(x);
    }
    return x->u_1;
}
