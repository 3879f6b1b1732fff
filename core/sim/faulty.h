/* A drive in a closed loop while a sensor, the link's measurement or the interrupt is faulty. */
#ifndef SENSORLESS_FAULTY_H
#define SENSORLESS_FAULTY_H

#include "drive/ks_schedule.h"
#include "sim.h"

/* What is faulty. */
enum {
    FAULTY_NONE = 0,
    FAULTY_OFFSET,    /* phase a reads `size` more [A] */
    FAULTY_GAIN,      /* phase a reads `size` times as much */
    FAULTY_GAINS,     /* both phases do */
    FAULTY_STUCK,     /* phase a reads `size` [A] */
    FAULTY_FROZEN,    /* both phases read what they read before */
    FAULTY_OPEN,      /* phase b reads 0 */
    FAULTY_NOISE,     /* both phases read noise of RMS `size` [A] on top */
    FAULTY_SATURATED, /* both phases read at most `size` [A] */
    FAULTY_SWAPPED,   /* each phase reads the other's current */
    FAULTY_REVERSED,  /* phase a reads the opposite */
    FAULTY_LINK,      /* the link reads `size` times as much; duty cycles go by what is read */
    FAULTY_MISSED,    /* a share `size` of the interrupts is missed: the last duty cycles stay */
    FAULTY_DOUBLED,   /* a share `size` of the interrupts comes twice, with the same samples */
    FAULTY_LATE       /* duty cycles act `size` periods later */
};

typedef struct {
    int32_t kind; /* FAULTY_* */
    int32_t from; /* first period with the fault */
    int32_t to;   /* first period without it */
    float size;
} faulty_t;

/* What came of it; periods are -1 for never. */
typedef struct {
    int32_t k_flag;  /* first period with a fault bit of the drive */
    int32_t k_lost;  /* period in which the judge of sim.h counts the drive as lost */
    int32_t lost;    /* LOST_* bits */
    int32_t fault;   /* fault bits of the drive at the end */
    float i_peak;    /* largest current vector until the bridge is open [A] */
    float i_unseen;  /* largest current vector before the first fault bit [A] */
    int32_t by_trip; /* 1: the first fault bit is that of the hardware's trip, by drive_trip */
} faulty_end_t;

/* Runs each of n drives to its end with the built-in rule of `schedule`. The bridge opens at
 * FAULT_OVER_CURRENT, at FAULT_STOPPED and at i_trip: then the run is over. */
void faulty_run(sim_t *s, int32_t n, const faulty_t *f, const ks_schedule_params_t *schedule,
                faulty_end_t *end);

#endif
