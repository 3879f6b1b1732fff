/* The start sequence on the drive's estimators; start_sequence.h has its phases. */
#ifndef SENSORLESS_DRIVE_START_H
#define SENSORLESS_DRIVE_START_H

#include "drive_types.h"

/* Makes the drive find its rotor before it controls: call it after drive_init if angle or speed are
 * not known. The angle given to drive_init only says which pole to try first. */
void drive_find_rotor(drive_state_t *x);

/* One period of the start sequence, of a drive in such a phase. */
ab_t drive_seek(const drive_params_t *p, drive_state_t *x, const drive_in_t *in, ab_t i_ab);

#endif
