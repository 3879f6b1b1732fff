/* Tells that the estimate is no longer the rotor's: five tests on what a drive knows of itself.
 *
 *   EMF      the q voltage without resistive drop and change of flux is omega psi_d at the true
 *            angle. r = u_q - R_s i_q - L_q d i_q/dt - omega psi_d, low-passed, stays small next
 *            to the EMF of the auxiliary flux; a quarter turn off adds -omega psi_a, half a turn
 *            -2 omega psi_d without d current, an EMF that is missing or unexpected all of it.
 *            On the d axis u_d - R_s i_d - L_d d i_d/dt + omega L_q i_q is 0 at the true angle;
 *            with what is left there, the auxiliary flux's EMF has a direction. A residual that
 *            lasts fails at less: half a turn off, a drive may stand or run slowly for ever
 *   SPEED    an estimate that slips moves faster than torque and load can move the shaft: the
 *            estimated speed leaves its own low-pass, without an EMF that goes with it. And an
 *            estimate at its bound no longer tells how fast the shaft is
 *   CURRENT  in a frame that is not the rotor's the EMF turns, and the torque current misses its
 *            reference
 *   ANSWER   an injected voltage moves the current along its axis, least where the axis is far off.
 *            Where it moves it less than 60 degrees off, or the other way, the axis is wrong, the
 *            voltage did not act when the drive thinks, or the samples are wrong; where it moves it
 *            more than on any axis, a channel reads too much
 *   STALL    the drive asks for all its current for half a second, and the shaft does not turn: a
 *            reluctance machine on the wrong pole, or a shaft that is blocked
 *
 * An evaluation every n periods, in two parts in two periods in a row, neither of them the one in
 * which a schedule decides. Thresholds and reasons: docs/lock-trials.md.
 */
#ifndef SENSORLESS_LOCK_H
#define SENSORLESS_LOCK_H

#include <stdint.h>

#include "trig.h"

/* Bits of lock_state_t.reason: the tests that failed. */
enum { LOCK_EMF = 1, LOCK_SPEED = 2, LOCK_CURRENT = 4, LOCK_ANSWER = 8, LOCK_STALL = 16 };

/* What a drive does about it: lock_params_t.action. */
enum {
    LOCK_REPORT = 0,  /* sets FAULT_LOCK */
    LOCK_RESTART = 1, /* also changes the observer, then seeks the rotor a few times, then stops */
    LOCK_STOP = 2     /* also stops: no voltage until drive_init */
};

typedef struct {
    float alpha;      /* low-pass of all tests, a coefficient of evaluations */
    float inv_t;      /* 1 / time from one evaluation to the next [1/s] */
    float R_s;        /* stator resistance [ohm] */
    float L_q_true;   /* apparent q inductance over that of the observer */
    float e_share;    /* EMF: residual over the EMF of the auxiliary flux beyond which it fails */
    float e_floor;    /* beyond this residual in addition [V] */
    float d_share;    /* EMF: d residual in lock, over the torque current [V/A] */
    float e_least;    /* least EMF that has a direction [V] */
    float alpha_late; /* low-pass of what lasts, a coefficient of evaluations */
    float e_late;     /* EMF: as e_floor, of what lasts [V] */
    float R_warm;     /* by which the stator resistance may be wrong in lock [ohm] */
    float jump;       /* SPEED: distance from the low-pass beyond which it fails [rad/s] */
    float i_off;      /* CURRENT: mean distance from the reference beyond which it fails [A] */
    float answer;     /* ANSWER: least current that the injected voltage moves [A] */
    float rest;       /* the same near zero current [A] */
    float most;       /* largest, with injection alone [A]; lock_bounds has all three */
    float i_loaded;   /* torque current from which dead time is compensated well [A] */
    float leads;      /* weight of injection from which it counts: its axis is the estimate's */
    float beside;    /* least current 60 degrees beside the axis, over the injected voltage [A/V] */
    float along;     /* least along the axis, over the voltage that acts [A/V] */
    float above;     /* largest over that voltage [A/V] */
    float u_unsure;  /* by which that may differ from the injected one: dead time [V] */
    float u_taken;   /* what dead time and switches may take of it near zero current [V] */
    float i_stall;   /* STALL: torque current beyond which the drive asks for all of it [A] */
    float slow;      /* STALL: estimated speed below which the shaft does not turn [rad/s] */
    int32_t n;       /* periods from one evaluation to the next, at least 2 */
    int32_t n_alarm; /* evaluations from the first failed one to an alarm, if the last failed too */
    int32_t n_act;   /* the same to a restart or stop */
    int32_t n_clear; /* passed evaluations in a row that end an alarm */
    int32_t n_calm;  /* passed ones in a row, of a shaft that turns, that forget restarts */
    int32_t restarts; /* most restarts before the drive stops */
    int32_t action;   /* LOCK_* */
    int32_t n_stall;  /* evaluations in a row in which it stalls that fail */
    int32_t n_grace;  /* evaluations after the drive takes control that cannot fail */
} lock_params_t;

typedef struct {
    dq_t i;           /* current at the last evaluation [A] */
    float across;     /* low-passed d residual [V] */
    float residual;   /* low-passed r [V] */
    float emf;        /* low-passed magnitude of the auxiliary flux's EMF [V] */
    float theta;      /* angle at the last evaluation [rad] */
    float late;       /* what r has beyond its share of the EMF, low-passed for longer [V] */
    float omega;      /* low-passed estimated speed [rad/s] */
    float i_off;      /* mean distance of the torque current from its reference [A] */
    float answer;     /* low-passed margin of the injection's answer, below 0 beyond a bound [A] */
    int32_t wait;     /* periods until the second part; the first comes at 1 */
    int32_t bad;      /* evaluations since the first failed one, 0 without; see LOCK_GRACE */
    int32_t calm;     /* passed evaluations in a row */
    int32_t stalled;  /* evaluations in a row in which it stalled */
    int32_t turned;   /* evaluations on this pole that turned the shaft, to n_stall */
    int32_t restarts; /* restarts not yet forgotten */
    int32_t alarms;   /* alarms so far */
    int32_t alarm;    /* 1 during an alarm */
    int32_t reason;   /* LOCK_* bits of all alarms, kept until the caller clears them */
} lock_state_t;

/* Periods from drive_init to the second part of the first evaluation. */
#define LOCK_FIRST 3

/* lock_state_t.bad beyond this counts evaluations of grace, downwards. Not below 0: the bits of a
 * negative number are a NaN to the check of the state. */
#define LOCK_GRACE 65536

/* What EMF reads; all in the estimated frame. */
typedef struct {
    float omega; /* electrical [rad/s] */
    float theta; /* electrical, -pi to pi [rad] */
    float T;     /* time since the last evaluation [s] */
    dq_t u;      /* mean voltage since the last evaluation [V] */
    dq_t i;      /* mean current since then [A] */
    dq_t i_now;  /* current [A] */
    float L_d;   /* [H] */
    float L_q;   /* [H] */
    float psi_d; /* [Vs] */
    float psi_a; /* auxiliary flux on the d axis, at most twice that of the magnets [Vs] */
} lock_in_t;

/* Nothing seen yet, for a drive that takes control without torque at speed omega [rad/s]. */
CORE_INLINE void lock_begin(const lock_params_t *p, lock_state_t *x, float omega) {
    x->i.d = 0.0f;
    x->i.q = 0.0f;
    x->across = 0.0f;
    x->residual = 0.0f;
    x->emf = 0.0f;
    x->theta = 0.0f;
    x->late = 0.0f;
    x->omega = omega;
    x->i_off = 0.0f;
    x->answer = 0.0f;
    x->stalled = 0;
    x->bad = LOCK_GRACE + p->n_grace;
    x->alarm = 0;
}

/* First part of an evaluation: the EMF. What lasts is taken for the speed at which the angle really
 * turns: injection may turn it while the estimated speed stands. */
CORE_INLINE void lock_emf(const lock_params_t *p, lock_state_t *x, const lock_in_t *in) {
    float drop_d = p->R_s * in->i.d + p->inv_t * in->L_d * (in->i_now.d - x->i.d);
    float drop_q = p->R_s * in->i.q + p->inv_t * in->L_q * (in->i_now.q - x->i.q);
    float d = in->u.d - drop_d + in->omega * in->L_q * in->i.q;
    float q = in->u.q - drop_q - in->omega * in->psi_d;
    x->i = in->i_now;
    x->across += p->alpha * (d - x->across);
    x->residual += p->alpha * (q - x->residual);
    x->emf += p->alpha * (abs_f(in->omega * in->psi_a) - x->emf);
    float beyond = p->inv_t * wrap_far(in->theta - x->theta - in->omega * in->T); /* [rad/s] */
    float late = x->bad > LOCK_GRACE ? 0.0f : p->alpha_late;
    x->theta = in->theta;
    float r = q - beyond * in->psi_d;
    float allowed = p->e_share * x->emf + p->R_warm * abs_f(in->i.q);
    x->late += late * (times_sign_f(max_f(abs_f(r) - allowed, 0.0f), r) - x->late);
}

#define LOCK_BESIDE 0.35f /* share of e_least that lock may leave on the d axis */

/* Whether the EMF is that of another angle: its q part far from what it should be, or its direction
 * 60 degrees from the q axis. */
CORE_INLINE int lock_emf_fails(const lock_params_t *p, const lock_state_t *x, float omega) {
    float along = x->emf + times_sign_f(x->residual, omega);
    float across = abs_f(x->across);
    float beside = across - p->d_share * abs_f(x->i.q) - LOCK_BESIDE * p->e_least;
    return abs_f(x->residual) > p->e_share * x->emf + p->e_floor || abs_f(x->late) > p->e_late ||
           (max_f(across, -along) > p->e_least && INV_SQRT3_F * beside > max_f(along, 0.0f));
}

/* Residual over the EMF below which both agree: a shaft that stands leaves 0.6 or more on one axis. */
#define LOCK_AGREES 0.4f
#define LOCK_TELLS 0.25f /* EMF over e_floor from which that does not come by chance */

/* Whether the EMF is that of the estimate's angle and speed, so that the shaft did move. */
CORE_INLINE int lock_emf_agrees(const lock_params_t *p, const lock_state_t *x) {
    float off = max_f(abs_f(x->residual), abs_f(x->across));
    return x->emf > LOCK_TELLS * p->e_floor && off < LOCK_AGREES * x->emf;
}

/* Bounds on the answer to an injected voltage of amplitude u [V]. */
CORE_INLINE void lock_bounds(lock_params_t *p, float u) {
    p->answer = min_f(p->beside * u, p->along * max_f(u - p->u_unsure, 0.0f));
    p->rest = min_f(p->answer, p->along * max_f(u - p->u_taken, 0.0f));
    p->most = p->above * (u + p->u_unsure);
}

/* Also in the first part: the answer to the injected voltage. seen: how far it moved the current
 * along its axis [A], if valid > 0; k_s: its weight. */
CORE_INLINE void lock_answer(const lock_params_t *p, lock_state_t *x, float seen, float valid,
                             float k_s) {
    int loaded = abs_f(x->i.q) > p->i_loaded;
    float least = loaded ? p->answer : p->rest;
    float above = seen - least;
    float below = k_s >= 1.0f && loaded ? p->most - seen : above;
    float more = valid > 0.0f && k_s >= p->leads ? min_f(above, below) : least;
    x->answer += p->alpha * (more - x->answer);
}

/* Also in the first part: the current. off: mean torque current less its reference [A]. */
CORE_INLINE void lock_current(const lock_params_t *p, lock_state_t *x, float off) {
    x->i_off += p->alpha * (abs_f(off) - x->i_off);
}

/* One more, up to most; also if x is damaged. */
CORE_INLINE int32_t lock_count(int32_t x, int32_t most) {
    return (uint32_t)x < (uint32_t)most ? x + 1 : most;
}

/* Also in the second part: whether the drive stalls, and for how long it has turned its shaft, which
 * on the wrong pole is for less than a stall takes. While it stands restarts count on: a shaft that is
 * blocked may pass every test. i_q_ref: torque current that it asks for [A]. */
CORE_INLINE void lock_stall(const lock_params_t *p, lock_state_t *x, float i_q_ref) {
    int stands = abs_f(x->omega) < p->slow;
    int stalls = stands && abs_f(i_q_ref) > p->i_stall;
    x->stalled = stalls ? lock_count(x->stalled, p->n_stall) : 0;
    x->turned = stands ? x->turned : lock_count(x->turned, p->n_stall);
    x->restarts = stands || x->calm < p->n_calm ? x->restarts : 0;
}

/* Second part, a period later: the speed, and the verdict. omega: estimated speed [rad/s];
 * omega_max: its bound [rad/s]. */
CORE_INLINE void lock_judge(const lock_params_t *p, lock_state_t *x, float omega, float omega_max) {
    x->omega += p->alpha * (omega - x->omega);
    int32_t grace = x->bad > LOCK_GRACE;
    int32_t jumps = abs_f(omega - x->omega) > p->jump && !lock_emf_agrees(p, x);
    int32_t moves = jumps || abs_f(omega) >= omega_max;
    int32_t found = (lock_emf_fails(p, x, omega) ? LOCK_EMF : 0) | (moves ? LOCK_SPEED : 0) |
                    (x->i_off > p->i_off ? LOCK_CURRENT : 0) |
                    (x->answer < 0.0f ? LOCK_ANSWER : 0) |
                    (x->stalled >= p->n_stall ? LOCK_STALL : 0);
    int32_t failed = grace ? 0 : found;
    int32_t calm = x->calm < p->n_calm ? x->calm + 1 : x->calm;
    x->calm = failed != 0 ? 0 : calm;
    int32_t next = x->bad < LOCK_GRACE ? x->bad + 1 : LOCK_GRACE;
    int32_t more = failed != 0 || (x->bad > 0 && x->calm < p->n_clear) ? next : 0;
    int32_t last = x->bad <= LOCK_GRACE + 1 || x->bad > LOCK_GRACE + p->n_grace;
    int32_t less = last ? 0 : x->bad - 1;
    x->bad = grace ? less : more;
    int32_t on = failed != 0 && x->bad >= p->n_alarm;
    x->alarms = count_i(x->alarms, on && x->alarm == 0 ? 1 : 0);
    x->alarm = x->bad > 0 && (on || x->alarm != 0) ? 1 : 0;
    x->reason |= x->alarm != 0 ? failed : 0;
}

/* Whether the drive has to act; change: its first action is to change the observer, which needs no
 * waiting, since the torque goes on. */
CORE_INLINE int lock_acts(const lock_params_t *p, const lock_state_t *x, int change) {
    int32_t n = change && p->action == LOCK_RESTART ? p->n_alarm : p->n_act;
    return p->action != LOCK_REPORT && x->bad >= n && x->calm == 0;
}

#endif
