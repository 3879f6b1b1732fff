/* Words that travel between host and target; every number is 32 bits wide, low byte first. */
#ifndef SENSORLESS_PIL_H
#define SENSORLESS_PIL_H

#include "params.h"

enum { PIL_DRIVES = 64 }; /* drives at a time */

/* What the host asks for: one request_t, then `n` items. */
enum {
    PIL_EXIT = 0,
    PIL_INFO,   /* no item -> info_t */
    PIL_TESTS,  /* no item -> tests_t */
    PIL_START,  /* n of start_item_t -> n of step_t: all drives anew */
    PIL_STEP,   /* n of drive_in_t -> n of step_t: schedule and drive_step; k_s_ref is not read */
    PIL_RAW,    /* n of drive_in_t -> n of step_t: drive_step alone, with k_s_ref */
    PIL_LOOKUP, /* n of lookup_in_t -> n of lookup_t */
    PIL_STAGES  /* n of drive_in_t -> n of stages_t: parts on copies of the states */
};

typedef struct {
    uint32_t operation;
    uint32_t n;
} request_t;

typedef struct {
    uint32_t drive_state; /* sizes in bytes */
    uint32_t schedule_state;
    uint32_t drive_params;
    uint32_t ticks_0;    /* of nothing */
    uint32_t ticks_call; /* of a call like that of a lookup, with two instructions in it */
    uint32_t ticks_1000; /* of a thousand instructions and a call */
} info_t;

/* Each the number of what went wrong. */
typedef struct {
    uint32_t lookups_f32;
    uint32_t lookups_q15;
    uint32_t periods;
    uint32_t flips_f32;
    uint32_t flips_q15;
    uint32_t refusals;
    uint32_t signals;
    uint32_t inputs;
    uint32_t angles;
    uint32_t weights;
} tests_t;

typedef struct {
    float theta;
    float omega;
    float k_s;
    float seek; /* above 0: with the start sequence */
} start_item_t;

typedef struct {
    drive_state_t x;
    ks_schedule_state_t schedule;
    ab_t u;
    uint32_t ticks;       /* of schedule and drive_step */
    uint32_t ticks_drive; /* of drive_step alone */
} step_t;

typedef struct {
    float y[SIGNAL_N];
} lookup_in_t;

typedef struct {
    float k_s_f32;
    float k_s_q15;
    uint32_t ticks_f32;
    uint32_t ticks_q15;
} lookup_t;

typedef struct {
    uint32_t hfi;
    uint32_t smo;
    uint32_t control;
    uint32_t signals;
    uint32_t decide; /* the schedule in a period that decides */
} stages_t;

uint32_t pil_since(uint32_t start);
stages_t pil_stages(const drive_state_t *x, const ks_schedule_state_t *schedule,
                    const drive_in_t *in);

#endif
