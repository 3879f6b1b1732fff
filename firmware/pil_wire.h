/* Messages between host and target; every number is 32 bits wide, low byte first.
 *
 * Both sides use this file: the target's compiler, and core/binding.py for the host.
 */
#ifndef SENSORLESS_PIL_WIRE_H
#define SENSORLESS_PIL_WIRE_H

#include <stdint.h>

#include "drive.h"
#include "ks_schedule.h"

enum { PIL_DRIVES = 64 }; /* most drives per request */

/* Operations of a request, which is one pil_request_t and then `n` items. */
enum {
    PIL_EXIT = 0,
    PIL_INFO,   /* no item -> pil_info_t */
    PIL_TESTS,  /* no item -> pil_tests_t */
    PIL_START,  /* n of pil_start_t -> n of pil_step_t: drives start again */
    PIL_STEP,   /* n of drive_in_t -> n of pil_step_t: schedule, drive_step; k_s_ref is not read */
    PIL_RAW,    /* n of drive_in_t -> n of pil_step_t: drive_step alone, with k_s_ref */
    PIL_LOOKUP, /* n of pil_lookup_in_t -> n of pil_lookup_t */
    PIL_STAGES  /* n of drive_in_t -> n of pil_stages_t: parts on copies of the states */
};

typedef struct {
    uint32_t operation;
    uint32_t n;
} pil_request_t;

typedef struct {
    uint32_t drive_state; /* sizes in bytes */
    uint32_t schedule_state;
    uint32_t drive_params;
    uint32_t ticks_0;    /* of no code at all */
    uint32_t ticks_call; /* of a call like that of a lookup, with two instructions inside */
    uint32_t ticks_1000; /* of a thousand instructions and their call */
} pil_info_t;

/* Numbers of cases that went wrong. */
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
} pil_tests_t;

typedef struct {
    float theta;
    float omega;
    float k_s;
    float seek; /* above 0: with the start sequence */
} pil_start_t;

typedef struct {
    drive_state_t x;
    ks_schedule_state_t schedule;
    ab_t u;
    uint32_t ticks;       /* of schedule and drive_step */
    uint32_t ticks_drive; /* of drive_step alone */
} pil_step_t;

typedef struct {
    float y[SIGNAL_N];
} pil_lookup_in_t;

typedef struct {
    float k_s_f32;
    float k_s_q15;
    uint32_t ticks_f32;
    uint32_t ticks_q15;
} pil_lookup_t;

typedef struct {
    uint32_t hfi;
    uint32_t smo;
    uint32_t control;
    uint32_t signals;
    uint32_t decide; /* the schedule in a period that decides */
    uint32_t mend;   /* what drive_step takes more to mend a damaged state */
} pil_stages_t;

#endif
