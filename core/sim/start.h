/* Puts drives into the state that a scenario begins with. */
#ifndef SENSORLESS_SIM_START_H
#define SENSORLESS_SIM_START_H

#include "sim.h"

/* Puts n drives into the state that their start_t describes, without current. */
void sim_start(sim_t *s, int32_t n);

#endif
