/* When a drive stops for good: no voltage any more until drive_init. */
#ifndef SENSORLESS_DRIVE_STOP_H
#define SENSORLESS_DRIVE_STOP_H

#include "drive_types.h"

/* Whether the drive was told to stop; the application may have lost the bit, or a period that
 * drive_trip interrupted all but the word begun. */
CORE_INLINE int drive_is_to_stop(const drive_state_t *x) {
    return (x->fault & FAULT_STOPPED) != 0 || x->begun == DRIVE_TRIPPED;
}

/* Stops the drive, and says so: no voltage from now on. */
CORE_INLINE void drive_stop(drive_state_t *x) {
    x->fault |= FAULT_STOPPED | (x->begun == DRIVE_TRIPPED ? FAULT_OVER_CURRENT : 0);
    start_enter(&x->start, START_STOPPED);
    x->u_1.a = 0.0f;
    x->u_1.b = 0.0f;
}

#endif
