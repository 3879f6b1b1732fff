/* A safe decision on the weight k_s: by the table, or by the built-in rule if the table is refused.
 *
 * ks_schedule_init checks the table once. Call ks_schedule_step every PWM period before drive_step;
 * it decides every `periods` periods. A refused table, or a signal that is not finite, sets a fault
 * bit that stays until the caller clears it; the weight is defined in every case.
 */
#ifndef SENSORLESS_KS_SCHEDULE_H
#define SENSORLESS_KS_SCHEDULE_H

#include "ks_table.h"
#include "signals.h"

enum {
    KS_FAULT_TABLE = 1, /* the table was refused, or never checked: the built-in rule decides */
    KS_FAULT_INPUT = 2  /* a signal was not finite: the table's fallback, or 1, was used; in
                         * ks_hook_step: a number was not plausible, the last good ones were used */
};

/* Built-in rule on the speed signal (doi 10.12177/emca.2025.011, Eq. 25, on the magnitude). */
typedef struct {
    float x_min; /* k_s = 1 up to this |omega_e_hat| / omega_rated */
    float x_max; /* k_s = 0 from this one on; linear between the two */
} ks_rule_t;

typedef struct {
    const ks_table_t *table; /* header, or 0 for none */
    const void *values;      /* its node values */
    uint32_t motor_hash;     /* machine that the table must be made for; 0 accepts any */
    ks_rule_t rule;
    int32_t periods; /* PWM periods from one decision to the next */
} ks_schedule_params_t;

typedef struct {
    float k_s_ref; /* last decision */
    int32_t wait;  /* periods until the next one; beyond `periods` it decides at once */
    int check;     /* KS_GOOD, or why the table is not used: KS_BAD_*, 0 before init */
    int fault;     /* KS_FAULT_* bits, kept until the caller clears them */
} ks_schedule_state_t;

/* k_s of the built-in rule; 1 (injection needs no speed) where the speed is not finite. */
CORE_INLINE float ks_rule(const ks_rule_t *p, float speed) {
    float k_s = (p->x_max - speed) / max_f(p->x_max - p->x_min, 1.0e-6f);
    return finite_f(speed) ? clamp_f(k_s, 0.0f, 1.0f) : 1.0f;
}

#ifdef __cplusplus
extern "C" {
#endif

/* Checks the table. Returns KS_OK or KS_BAD_*; the schedule works in either case. */
int ks_schedule_init(const ks_schedule_params_t *p, ks_schedule_state_t *x);

/* Weight to pass to drive_step in this period. signal_params, signals: those of the drive. */
float ks_schedule_step(const ks_schedule_params_t *p, ks_schedule_state_t *x,
                       const signal_params_t *signal_params, const signal_state_t *signals);

#ifdef __cplusplus
}
#endif

#endif
