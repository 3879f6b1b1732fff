/* What a block of drives has to do. */
#ifndef SENSORLESS_BLOCK_RUN_H
#define SENSORLESS_BLOCK_RUN_H

#include "lanes.h"
#include "sim_gains.h"

/* Periods done ... periods - 1 of a decision, in the first of which all gains due are in force. The
 * period reached is less than `periods` if gains are to come for drives outside the block. */
typedef struct {
    sim_t *sims;          /* drives that fit, see batch.h */
    int32_t count;        /* of them, at most LANES */
    int32_t done;         /* periods */
    int32_t periods;      /* of the decision */
    const float *k_s_ref; /* weight of each drive */
    sim_gains_t *gains;   /* of each drive, or 0 */
} block_run_t;

#endif
