/* What a drive meets over time: speed reference, load torque, DC-link voltage. */
#ifndef SENSORLESS_PROFILE_H
#define SENSORLESS_PROFILE_H

#include <stdint.h>

#include "drive/frames.h"
#include "drive/vector.h"

enum {
    PROFILE_N = 8,     /* segments of a profile */
    NEVER = 2147483647 /* start of a segment that is never reached */
};

/* Segment j applies from period start[j] until start[j + 1]; each quantity moves to its target at
 * its own rate. */
typedef struct {
    int32_t start[PROFILE_N];    /* first period; NEVER for a segment that is not used */
    float omega_ref[PROFILE_N];  /* target, electrical [rad/s] */
    float omega_step[PROFILE_N]; /* largest change a period [rad/s] */
    float tau[PROFILE_N];        /* load torque, positive against positive speed [N m] */
    float tau_step[PROFILE_N];   /* largest change a period [N m] */
    float u_dc[PROFILE_N];       /* [V] */
    float u_dc_step[PROFILE_N];  /* largest change a period [V] */
} profile_t;

typedef struct {
    float omega_ref; /* electrical [rad/s] */
    float tau_load;  /* [N m] */
    float u_dc;      /* [V] */
    int32_t segment;
} profile_state_t;

CORE_INLINE float profile_move(float x, float target, float step) {
    return x + clamp_f(target - x, -step, step);
}

/* Values for period k. */
CORE_INLINE void profile_step(const profile_t *p, profile_state_t *x, int32_t k) {
    int32_t next = x->segment + 1 < PROFILE_N ? x->segment + 1 : PROFILE_N - 1;
    int32_t start = NEVER;
    for (int32_t i = 1; i < PROFILE_N; i++) {
        int32_t at = p->start[i];
        start = next >= i ? at : start;
    }
    int32_t j = k >= start ? next : x->segment;
    x->segment = j;
    x->omega_ref = profile_move(x->omega_ref, pick_f(p->omega_ref, j, PROFILE_N),
                                pick_f(p->omega_step, j, PROFILE_N));
    x->tau_load =
        profile_move(x->tau_load, pick_f(p->tau, j, PROFILE_N), pick_f(p->tau_step, j, PROFILE_N));
    x->u_dc =
        profile_move(x->u_dc, pick_f(p->u_dc, j, PROFILE_N), pick_f(p->u_dc_step, j, PROFILE_N));
}

#endif
