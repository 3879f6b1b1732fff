/* What is asked of the drive over time: speed reference, load torque, DC-link voltage. Host only. */
#ifndef SENSORLESS_PROFILE_H
#define SENSORLESS_PROFILE_H

#include <stdint.h>

#include "frames.h"

#define PROFILE_N 8 /* segments of a profile */

/* Segment j holds from period start[j] until start[j + 1]; each quantity runs to its target with its
 * own rate. */
typedef struct {
    int32_t start[PROFILE_N];    /* first period; a segment never reached starts at INT32_MAX */
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
    int32_t j = k >= p->start[next] ? next : x->segment;
    x->segment = j;
    x->omega_ref = profile_move(x->omega_ref, p->omega_ref[j], p->omega_step[j]);
    x->tau_load = profile_move(x->tau_load, p->tau[j], p->tau_step[j]);
    x->u_dc = profile_move(x->u_dc, p->u_dc[j], p->u_dc_step[j]);
}

#endif
