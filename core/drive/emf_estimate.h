/* What the second estimator gives the drive: the one that needs no injection and so leads at speed.
 * It is the sliding-mode, the flux or the coupled observer; the rest of the drive sees no
 * difference. */
#ifndef SENSORLESS_EMF_ESTIMATE_H
#define SENSORLESS_EMF_ESTIMATE_H

#include "pll.h"

typedef struct {
    pll_state_t pll;
    ab_t e;      /* extended EMF, stator frame [V] */
    float err;   /* last angle error, truth minus estimate near lock [rad] */
    float valid; /* 1 when its own signal drove the loop, 0 when it followed theta_idle */
} emf_estimate_t;

#endif
