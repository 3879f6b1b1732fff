/* The tests of lock.h apart from the period, so that a period without them is as short as before. */
#include "drive_lock.h"

#include "drive_check.h"
#include "drive_start.h"
#include "drive_stop.h"

/* Seeks the rotor. If nothing tells the pole: a drive that had to act was far from its rotor, so the
 * one that it took for south is the likelier; but not if the coupled observer has taken over and drawn it
 * to the nearer one. A drive that stalls is on the wrong one unless it turned its shaft before. */
CORE_COLD static void drive_restart(const drive_params_t *p, drive_state_t *x) {
    int stalls = x->lock.stalled >= p->lock.n_stall;
    int known = stalls && x->lock.turned >= p->lock.n_stall;
    int same = known || (!stalls && p->estimator != ESTIMATE_COUPLED);
    x->lock.turned = known ? x->lock.turned : 0;
    x->lock.restarts += 1;
    drive_find_again(x, same ? START_SAME_POLE : START_OTHER_POLE);
}

CORE_COLD void drive_act(const drive_params_t *p, drive_state_t *x) {
    if (p->lock.action == LOCK_RESTART && drive_can_change(p, x)) {
        drive_change_observer(p, x);
        return;
    }
    if (p->lock.action == LOCK_STOP || x->lock.restarts >= p->lock.restarts) {
        drive_stop(x);
    } else {
        drive_restart(p, x);
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
