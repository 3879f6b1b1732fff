/* Instruction counts of each part of the control step, and of mending a damaged state, on
 * copies of the states. */
#ifndef SENSORLESS_PIL_STAGES_H
#define SENSORLESS_PIL_STAGES_H

#include "pil_wire.h"

pil_stages_t pil_stages(const drive_state_t *x, const ks_schedule_state_t *schedule,
                        const drive_in_t *in);

#endif
