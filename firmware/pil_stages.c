/* Every part is a separate function, so that the compiler cannot merge them. */
#include "pil_stages.h"

#include "params.h"
#include "port.h"

#define APART static __attribute__((noinline))

APART void hfi_part(hfi_state_t *x, ab_t i_ab, const estimate_t *est) {
    hfi_observe(&drive_params.hfi, x, i_ab, est->theta, est->omega, drive_params.T_s);
}

APART void smo_part(drive_state_t *x, ab_t i_ab) {
    smo_observe(&drive_params.smo, &x->smo, &x->emf, i_ab, x->u_2, drive_params.L_q.y[0],
                x->est.omega, x->est.theta, drive_params.T_s);
}

APART ab_t control_part(drive_state_t *x, const drive_in_t *in, ab_t i_ab) {
    return drive_actuate(&drive_params, x, in, i_ab, x->est, rot_of(x->est.theta), x->hfi.sign_1);
}

APART void signals_part(drive_state_t *x, float omega_ref) {
    drive_signals(&drive_params.signal, x, omega_ref);
}

pil_stages_t pil_stages(const drive_state_t *x, const ks_schedule_state_t *schedule,
                        const drive_in_t *in) {
    pil_stages_t y;
    drive_state_t d = *x;
    drive_state_t sound = *x;
    drive_state_t hurt = *x;
    ks_schedule_state_t s = *schedule;
    ab_t i_ab = phases_to_ab(in->i_a, in->i_b);
    s.wait = 0;

    uint32_t t = port_ticks();
    hfi_part(&d.hfi, i_ab, &d.est);
    y.hfi = port_since(t);
    t = port_ticks();
    smo_part(&d, i_ab);
    y.smo = port_since(t);
    t = port_ticks();
    control_part(&d, in, i_ab);
    y.control = port_since(t);
    t = port_ticks();
    signals_part(&d, in->omega_ref);
    y.signals = port_since(t);
    t = port_ticks();
    ks_schedule_step(&schedule_params, &s, &drive_params.signal, &d.signal);
    y.decide = port_since(t);
    hurt.coupled.psi.a = __builtin_nanf("");
    t = port_ticks();
    uint32_t nothing = port_since(t);
    t = port_ticks();
    (void)drive_step(&drive_params, &sound, in);
    uint32_t without = port_since(t);
    t = port_ticks();
    (void)drive_step(&drive_params, &hurt, in);
    y.mend = port_since(t) - without + nothing; /* a count has those of the measurement */
    return y;
}
