/* The check of bring_up.h on a simulated drive that somebody has built in, rightly or not. */
#ifndef SENSORLESS_BRING_UP_RUN_H
#define SENSORLESS_BRING_UP_RUN_H

#include "drive/bring_up.h"
#include "sim.h"

/* What stands between the core and the machine; matrices row by row, stator frame. */
typedef struct {
    float i_map[4];  /* from the right sample to the one that the core gets */
    float u_map[4];  /* from the core's voltage to the commanded one */
    float delay;     /* of the voltage after its sample, 0 ... 2 [periods]; 1 is right */
    float added;     /* lost voltage that the PWM driver compensates, over what is lost */
    float inv_i_add; /* slope of that through zero current [1/A] */
    float reserved;
} built_t;

/* Columns of a row, one per sampling instant k. */
enum {
    BUILT_I_A = 0, /* sample that the core gets [A] */
    BUILT_I_B,
    BUILT_U_A, /* voltage that it returns [V] */
    BUILT_U_B,
    BUILT_N
};

/* Runs the check to its end, at most `periods` periods, and writes a row of BUILT_N numbers a
 * period. Returns the number of rows. */
int32_t bring_up_run(sim_t *s, const built_t *b, const bring_up_params_t *p, bring_up_state_t *x,
                     int32_t periods, double *out);

/* The check on a log: rows of BUILT_N numbers, of which it reads the samples, and writes the voltage
 * that it would have commanded. Returns the rows that it took. */
int32_t bring_up_replay(const bring_up_params_t *p, bring_up_state_t *x, int32_t n, double *rows);

#endif
