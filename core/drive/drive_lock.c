/* The tests of lock.h apart from the period, so that a period without them is as short as before. */
#include "drive_lock.h"

#include "drive_start.h"

/* The coupled observer goes on in the place of another: at its angle and speed, with the flux of the
 * present current, and with a load that balances the torque. */
CORE_COLD static void change_observer(const drive_params_t *p, drive_state_t *x) {
    const coupled_params_t *c = &p->coupled;
    dq_t i = x->control.i;
    curve_pos_t pos = curve_locate(i.q, p->control.curve_inv_step);
    dq_t psi = {curve_at(&c->psi_d, pos) + c->L_d * i.d, curve_at(&p->L_q, pos) * i.q};
    x->start.again = 1;
    x->emf.pll.theta = wrap_pi(x->est.theta + p->T_s * x->est.omega);
    x->emf.pll.omega = x->est.omega;
    x->emf.valid = 1.0f;
    x->coupled.psi = dq_to_ab(psi, rot_of(x->emf.pll.theta));
    x->coupled.load = bound_f(-c->k_tau * (psi.d * i.q - psi.q * i.d), c->load_max);
    x->coupled.eps_f = 0.0f;
    drift_clear(&c->drift, &x->coupled.drift);
}

CORE_COLD void drive_act(const drive_params_t *p, drive_state_t *x) {
    if (p->lock.action == LOCK_RESTART && drive_can_change(p, x)) {
        change_observer(p, x);
        return;
    }
    if (p->lock.action == LOCK_STOP || x->lock.restarts >= p->lock.restarts) {
        x->fault |= FAULT_STOPPED;
        start_enter(&x->start, START_STOPPED);
    } else {
        x->lock.restarts += 1;
        drive_find_again(x);
    }
    lock_begin(&p->lock, &x->lock, 0.0f);
}

void drive_lock(const drive_params_t *p, drive_state_t *x) {
    if (x->lock.wait == 1) {
        drive_watch(p, x);
        return;
    }
    drive_judge(p, x);
    if (drive_acts(p, x)) {
        drive_act(p, x);
    }
}
