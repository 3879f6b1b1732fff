/* The tests of lock.h apart from the period, so that a period without them is as short as before. */
#include "drive_lock.h"

#include "drive_check.h"
#include "drive_start.h"
#include "drive_stop.h"

/* Which of the axis' two directions is the likelier one if nothing tells: START_SAME_POLE or
 * START_OTHER_POLE. A drive that had to act was far from its rotor, so the pole that it took for south
 * is; but not if the coupled observer has taken over and drawn it to the nearer one, unless it stalls. */
static int32_t drive_likelier_pole(const drive_params_t *p, const drive_state_t *x) {
    int stalls = x->lock.stalled >= p->lock.n_stall;
    return stalls || p->estimator == ESTIMATE_COUPLED ? START_OTHER_POLE : START_SAME_POLE;
}

CORE_COLD void drive_act(const drive_params_t *p, drive_state_t *x) {
    if (p->lock.action == LOCK_RESTART && drive_can_change(p, x)) {
        drive_change_observer(p, x);
        return;
    }
    if (p->lock.action == LOCK_STOP || x->lock.restarts >= p->lock.restarts) {
        drive_stop(x);
    } else {
        x->lock.restarts += 1;
        drive_find_again(x, drive_likelier_pole(p, x));
    }
    lock_begin(&p->lock, &x->lock, 0.0f);
}

ab_t drive_lock(const drive_params_t *p, drive_state_t *x, ab_t u) {
    if (x->lock.wait == 1) {
        drive_watch(p, x);
        return drive_unless(drive_start_counts(x) && drive_angles_sound(x), &p->guard, u);
    }
    int begun = x->begun == DRIVE_BEGUN || x->begun == DRIVE_TRIPPED;
    drive_judge(p, x);
    if (drive_is_to_stop(x)) { /* drive_trip came within a period */
        drive_stop(x);
    } else if (drive_acts(p, x)) {
        drive_act(p, x);
    }
    u = x->start.phase == START_STOPPED ? x->u_1 : u;
    return drive_unless(begun && drive_lock_counts(x) && drive_loops_sound(p, x), &p->guard, u);
}
