/* A schedule that decides on k_s and on the gains of gains.h.
 *
 * It takes the place of ks_schedule.h. The drive runs on `live`, a copy of its parameters in memory
 * that can be written. gain_schedule_init makes the copy and checks both tables. Call
 * gain_schedule_step every PWM period before drive_step. It decides on k_s every `periods` periods,
 * exactly as ks_schedule_step does. The gains of the same place in the grid follow, one in each of
 * the next periods, so that no period carries much more than a decision on k_s alone; the last
 * period of a decision takes all that are left.
 *
 * A period that sets no gain compares one word of `live` with the parameters and restores it if it
 * differs, unless a gain sets it: such words are written anew after every decision. So damage lasts
 * for as many decisions as there are words (sizeof(drive_params_t) / 4), or fewer where a decision
 * has periods to spare.
 *
 * Where a signal is not finite, the gains stay as they are. Without a good k_s table the built-in
 * rule decides on k_s; then, and without a good gain table, all gains are static.
 */
#ifndef SENSORLESS_GAIN_SCHEDULE_H
#define SENSORLESS_GAIN_SCHEDULE_H

#include "gain_table.h"
#include "ks_schedule.h"

enum { SET_N = 8 }; /* words with a bit for each word of the parameters */

/* Further bits of ks_schedule_state_t.fault. */
enum {
    KS_FAULT_GAINS = 4, /* gain table refused */
    KS_FAULT_PARAMS = 8 /* a parameter of `live` was damaged, and is restored */
};

typedef struct {
    ks_schedule_params_t ks;
    const gain_table_t *table; /* header, or 0 for none */
    const void *values;        /* its node values */
} gain_schedule_params_t;

typedef struct {
    ks_schedule_state_t ks;
    int check;           /* KS_GOOD, or why the gains are static: KS_BAD_*, 0 before init */
    uint32_t next;       /* grid of the table that comes next */
    uint32_t word;       /* word of the parameters that is compared next */
    uint32_t set[SET_N]; /* a bit for each word: whether a gain of the table writes it */
    ks_cell_t cell;      /* place of the last decision */
    float value[GAIN_N]; /* in force, by grid */
} gain_schedule_state_t;

#ifdef __cplusplus
extern "C" {
#endif

/* Checks the tables and copies the parameters. Returns KS_OK or the first KS_BAD_*; the schedule
 * works in either case. */
int gain_schedule_init(const gain_schedule_params_t *p, gain_schedule_state_t *x,
                       const drive_params_t *drive, drive_params_t *live);

/* Weight to pass to drive_step in this period; `live` gets the gains. signals: those of the
 * drive. */
float gain_schedule_step(const gain_schedule_params_t *p, gain_schedule_state_t *x,
                         const drive_params_t *drive, drive_params_t *live,
                         const signal_state_t *signals);

#ifdef __cplusplus
}
#endif

#endif
