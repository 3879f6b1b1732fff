/* From the sums of the check in bring_up.h to faults and numbers. */
#ifndef SENSORLESS_BRING_UP_JUDGE_H
#define SENSORLESS_BRING_UP_JUDGE_H

#include "bring_up_types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* After PROBE: delay, wiring and d axis. */
void bring_up_judge_probe(const bring_up_params_t *p, bring_up_state_t *x);

/* After PUSH: scale, lost voltage and resistance. */
void bring_up_judge_push(const bring_up_params_t *p, bring_up_state_t *x);

#ifdef __cplusplus
}
#endif

#endif
