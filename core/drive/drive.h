/* One PWM period of the sensorless drive: guard, observe, actuate.
 *
 * Call drive_step once per period with the sample of instant k, and apply the voltage that it
 * returns over [k+1, k+2]. Control and injection stay within u_dc / sqrt(3) of a link that sets no
 * fault; dead-time compensation comes on top, so the voltage may be beyond the link's hexagon: limit
 * the duties to 0 ... 1.
 */
#ifndef SENSORLESS_DRIVE_H
#define SENSORLESS_DRIVE_H

#include "drive_actuate.h"
#include "drive_check.h"
#include "drive_guard.h"
#include "drive_lock.h"
#include "drive_observe.h"
#include "drive_start.h"
#include "drive_types.h"
#include "vector.h"

#ifdef __cplusplus
extern "C" {
#endif

/* No voltage and a new start in the place of a damaged state: FAULT_STATE. A drive that stops when
 * it loses lock, or has stopped, does not start: FAULT_STOPPED too. */
ab_t drive_mend(const drive_params_t *p, drive_state_t *x);

#ifdef __cplusplus
}
#endif

/* The voltage u of this period if the state is sound. */
CORE_INLINE ab_t drive_checked(const drive_params_t *p, drive_state_t *x, ab_t u) {
    int hurt = SCALAR_ONLY(!CORE_LIKELY(drive_sound(&p->guard, x, u)));
    return hurt ? drive_mend(p, x) : u;
}

/* The whole period. */
CORE_INLINE ab_t drive_step_inline(const drive_params_t *p, drive_state_t *x,
                                   const drive_in_t *raw) {
    drive_in_t in = drive_guard(&p->guard, x, raw);
    ab_t i_ab = match_correct(&x->coupled.match, in.i_a, in.i_b);
    drive_guard_current(&p->guard, x, i_ab);
    if (SCALAR_ONLY(x->start.phase != START_DONE)) {
        x->coupled.i_1 = i_ab;
        drive_in_t copy = in; /* so that other periods need not have the inputs in memory */
        return drive_checked(p, x, drive_seek(p, x, &copy, i_ab));
    }
    drive_guard_step(&p->guard, x, i_ab);
    rot_t r = drive_observe(p, x, i_ab, in.k_s_ref);
    x->coupled.i_1 = i_ab;
    float s = hfi_inject(&p->hfi, &x->hfi, x->k_s > 0.0f);
    ab_t u = drive_actuate(p, x, &in, i_ab, x->est, r, s);
    drive_signals(&p->signal, x, in.omega_ref);
    x->lock.wait = count_i(x->lock.wait, -1);
    if (SCALAR_ONLY(x->lock.wait <= 1 || x->lock.wait > p->lock.n + LOCK_FIRST)) {
        u = drive_lock(p, x, u);
    }
    return drive_checked(p, x, u);
}

#ifdef __cplusplus
extern "C" {
#endif

/* The same as a linkable function, for firmware. */
ab_t drive_step(const drive_params_t *p, drive_state_t *x, const drive_in_t *in);

/* Initial state: no currents, estimators at theta [rad] and omega [rad/s], electrical, weight k_s.
 * A bad argument sets FAULT_COMMAND: an angle beyond 10,000 rad or not finite becomes 0, a speed
 * beyond guard.omega that limit, or 0 if not finite, a weight beyond [0, 1] its nearest end, or 1 if
 * it is NaN. */
void drive_init(const drive_params_t *p, drive_state_t *x, float theta, float omega, float k_s);

/* Makes the drive find its rotor before it takes control. Call it after drive_init if angle or
 * speed is unknown; the angle passed to drive_init then only says which pole to assume first. Before
 * drive_init, and after a stop without it, nothing happens but FAULT_COMMAND. */
void drive_find_rotor(drive_state_t *x);

/* Tells the drive that hardware opened the bridge, which samples need not show: no voltage any more,
 * FAULT_OVER_CURRENT and FAULT_STOPPED, until drive_init. It takes effect with the next drive_step; with
 * that within a millisecond if it interrupts one, which may write over all but begun. */
void drive_trip(drive_state_t *x);

#ifdef __cplusplus
}
#endif

#endif
