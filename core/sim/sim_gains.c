/* Gains that a decision sets besides k_s, of simulated drives. */
#include "sim_gains.h"

/* Gain g of n drives. */
static void set_gain(sim_t *s, sim_gains_t *gains, int32_t n, uint32_t g) {
    for (int32_t i = 0; i < n; i++) {
        sim_gains_t *x = &gains[i];
        float wanted = gain_bounded(&x->limit[g], x->wanted[g]);
        x->value[g] =
            gain_step(&x->limit[g], x->which[g], x->value[g], wanted, &x->design, &s[i].control);
    }
}

/* Number of gains, of n, in force in a period. */
static uint32_t in_force(uint32_t n, int32_t period, int32_t periods) {
    int all = period + 1 >= periods || (uint32_t)period > n;
    return all ? n : (uint32_t)period;
}

int sim_set_due(sim_t *s, sim_gains_t *gains, int32_t n, int32_t period, int32_t periods) {
    if (gains == 0 || period >= periods) {
        return 0;
    }
    uint32_t first = period > 0 ? in_force(gains->n, period - 1, periods) : 0;
    uint32_t end = in_force(gains->n, period, periods);
    for (uint32_t g = first; g < end; g++) {
        set_gain(s, gains, n, g);
    }
    return end > first;
}

void sim_lock_bounds(lock_params_t *p, float u) { lock_bounds(p, u); }
