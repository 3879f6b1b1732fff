/* What the checks of the mutation campaign share. */
#ifndef CHECKS_H
#define CHECKS_H

#include <complex.h>
#include <math.h>
#include <stdio.h>

#include "drive.h"
#include "ks_schedule.h"

typedef double complex vec_t; /* a space vector, alpha + j beta or d + j q */

extern int checks_failed;

/* Reports a failed check once. */
void check(const char *what, int good);

/* Whether x is y within tol of the larger of 1 and |y|. */
static inline int near(double x, double y, double tol) {
    return fabs(x - y) <= tol * fmax(1.0, fabs(y));
}

static inline int near_v(vec_t x, vec_t y, double tol) {
    return near(creal(x), creal(y), tol) && near(cimag(x), cimag(y), tol);
}

static inline vec_t of_ab(ab_t x) { return (double)x.a + I * (double)x.b; }
static inline vec_t of_dq(dq_t x) { return (double)x.d + I * (double)x.q; }
static inline double wrapped(double x) { return remainder(x, 2.0 * M_PI); }
static inline double bounded(double x, double most) { return fmax(fmin(x, most), -most); }
static inline double sgn(double x) { return x < 0.0 ? -1.0 : 1.0; }

/* A drive that seeks its rotor, at rest at angle 0; again: after lost lock. */
static inline drive_state_t seeking(const drive_params_t *p, int32_t phase, int again) {
    drive_state_t x;
    drive_init(p, &x, 0.0f, 0.0f, 0.5f);
    if (again) {
        drive_find_again(&x, START_OTHER_POLE);
    } else {
        drive_find_rotor(&x);
    }
    start_enter(&x.start, phase);
    return x;
}

/* Uniform number from a fixed sequence. */
double draw(double lo, double hi);
float draw_f(double lo, double hi);

void check_math(void);
void check_estimators(void);
void check_coupled(void);
void check_control(void);
void check_start(void);
void check_table(void);
void check_drive(void);
void check_lock(void);
void check_stall(void);
void check_restart(void);
void check_match(void);
void check_guard(void);
void check_seek(void);
void check_state(void);
uint32_t trajectory(void);

#endif
