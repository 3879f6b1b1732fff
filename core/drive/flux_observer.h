/* Rotor angle from the stator flux: an alternative to the sliding-mode observer.
 *
 * Stator frame: d psi_hat / dt = u - R_s i + v. In the estimated rotor frame, the flux that the
 * measured current stands for minus psi_hat is the error
 *   eps ~ (error of psi_hat) - j delta psi_a,  delta = theta_e - theta_e_hat,
 * psi_a the auxiliary flux (flux_model.h). Its part across psi_a drives the PLL. Its part along
 * psi_a corrects psi_hat with a bandwidth that rises with speed from a bound at standstill
 * (doi 10.1109/TIA.2018.2858753). Integration over [k-1, k] is exact for a held voltage.
 *
 * Voltage errors, above all of the dead time, turn psi_hat. At low speed and light load nothing in
 * these equations opposes that, and the flux slips by whole turns. So injection, where it is on,
 * moves the flux by j psi_a times k_turn k_s times its lead: across psi_a, so the correction along
 * it does not see the move. The angle follows through eps. It is not turned directly: then the
 * speed would stay wrong by that turn as long as the voltage is wrong.
 */
#ifndef SENSORLESS_FLUX_OBSERVER_H
#define SENSORLESS_FLUX_OBSERVER_H

#include "emf_estimate.h"
#include "flux_model.h"
#include "trig.h"

typedef struct {
    pll_params_t pll;
    float gain_0;      /* half the correction of the flux at standstill [1/s] times T_s */
    float gain_w;      /* half its rise with speed, times T_s [s] */
    float k_turn;      /* from injection's lead to the flux, over psi_a [1/s] times T_s */
    float omega_floor; /* below this speed the flux is not used, electrical [rad/s] */
} flux_params_t;

typedef struct {
    ab_t psi; /* estimated stator flux [Vs]; 0: none yet, so it starts from the current */
} flux_state_t;

/* One period; arguments as for smo_observe of sliding_mode.h, and i_1: sample k-1 [A], for the
 * resistive drop over [k-1, k]. lead: k_s times the angle of injection minus that of y [rad], 0
 * without injection. */
CORE_INLINE void flux_observe(const flux_params_t *p, const flux_model_t *m, flux_state_t *x,
                              emf_estimate_t *y, ab_t i_ab, ab_t i_1, ab_t u_ab, float omega,
                              float theta_idle, float lead, float T_s) {
    int valid = abs_f(omega) >= p->omega_floor;
    int fresh = !valid || (x->psi.a == 0.0f && x->psi.b == 0.0f);
    y->pll.theta = valid ? y->pll.theta : theta_idle;
    y->pll.omega = valid ? y->pll.omega : omega;
    rot_t r = rot_of(y->pll.theta);
    dq_t i = ab_to_dq(i_ab, r);
    flux_of_current_t model = flux_of_current(m, i);
    dq_t aux = model.aux;

    ab_t i_m = {0.5f * (i_ab.a + i_1.a), 0.5f * (i_ab.b + i_1.b)};
    ab_t psi_ab = {x->psi.a + T_s * (u_ab.a - m->R_s * i_m.a),
                   x->psi.b + T_s * (u_ab.b - m->R_s * i_m.b)};
    dq_t psi = ab_to_dq(psi_ab, r);
    psi.d = fresh ? model.psi.d : psi.d;
    psi.q = fresh ? model.psi.q : psi.q;
    dq_t e = {model.psi.d - psi.d, model.psi.q - psi.q};
    float along = flux_along(&model, e);
    float gain = 2.0f * (p->gain_0 + p->gain_w * abs_f(y->pll.omega)) * along;
    float turn = valid ? p->k_turn * lead : 0.0f;
    dq_t next = {psi.d + gain * aux.d - turn * aux.q, psi.q + gain * aux.q + turn * aux.d};
    x->psi = dq_to_ab(next, r);

    dq_t emf = {0.0f, y->pll.omega * aux.d};
    y->e = dq_to_ab(emf, r);
    y->err = flux_across(&model, e);
    y->valid = valid ? 1.0f : 0.0f;
    pll_step(&p->pll, &y->pll, y->err, T_s);
}

#endif
