/* The voltage that edges.h loses to dead time, period by period, for whoever knows the commands. */
#ifndef SENSORLESS_EDGE_LOSSES_H
#define SENSORLESS_EDGE_LOSSES_H

#include "edges.h"

/* Voltage lost in each of n periods [V], stator frame.
 *
 * slope: of the current in each period; u: commands [V]; i: currents at the starts [A]; u_dc: DC
 * link [V]; u_lost: voltage that a leg loses once its current is large [V]; T_s: period [s]. */
void edge_losses(const plant_slope_t *slope, const ab_t *u, const ab_t *i, const float *u_dc,
                 float u_lost, float T_s, int32_t n, ab_t *lost);

#endif
