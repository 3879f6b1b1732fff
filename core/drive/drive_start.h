/* The start sequence on the drive's estimators; start_sequence.h has its phases. */
#ifndef SENSORLESS_DRIVE_START_H
#define SENSORLESS_DRIVE_START_H

#include "drive_types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Makes a drive in operation that lost its rotor find it: takes its current to zero first. again:
 * START_SAME_POLE or START_OTHER_POLE. */
void drive_find_again(drive_state_t *x, int32_t again);

/* The coupled observer goes on in the place of another: at its angle and speed, with the flux of the
 * present current, and with a load that balances the torque. */
void drive_change_observer(const drive_params_t *p, drive_state_t *x);

/* One period of a drive in its start sequence. */
ab_t drive_seek(const drive_params_t *p, drive_state_t *x, const drive_in_t *in, ab_t i_ab);

#ifdef __cplusplus
}
#endif

#endif
