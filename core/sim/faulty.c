/* The period of sim_period.h with a fault between machine and drive. */
#include "faulty.h"

#include "noise.h"
#include "sim_period.h"

enum { LATEST = 4 }; /* most periods that duty cycles can be late */

typedef struct {
    drive_in_t was;           /* samples of the last period */
    ab_t waiting[LATEST + 1]; /* voltages of the last periods, the newest first [V] */
    int32_t err_count;
} loop_t;

/* Whether an event of probability `share` happens in period k. */
static int happens(const sim_t *s, float share) {
    uint32_t x = noise_mix(s->seed ^ noise_mix((uint32_t)s->k));
    return (float)(x >> 8) < share * 16777216.0f;
}

/* Samples as a faulty sensor gives them. */
static drive_in_t spoil(const sim_t *s, const faulty_t *f, const loop_t *loop, drive_in_t in) {
    drive_in_t y = in;
    uint32_t k = (uint32_t)s->k;
    switch (f->kind) {
    case FAULTY_OFFSET:
        y.i_a = in.i_a + f->size;
        break;
    case FAULTY_GAINS:
        y.i_b = f->size * in.i_b;
        y.i_a = f->size * in.i_a;
        break;
    case FAULTY_GAIN:
        y.i_a = f->size * in.i_a;
        break;
    case FAULTY_STUCK:
        y.i_a = f->size;
        break;
    case FAULTY_FROZEN:
        y.i_a = loop->was.i_a;
        y.i_b = loop->was.i_b;
        break;
    case FAULTY_OPEN:
        y.i_b = 0.0f;
        break;
    case FAULTY_NOISE:
        y.i_a = in.i_a + f->size * noise_normal(s->seed ^ 0x5A5AU, 2U * k);
        y.i_b = in.i_b + f->size * noise_normal(s->seed ^ 0x5A5AU, 2U * k + 1U);
        break;
    case FAULTY_SATURATED:
        y.i_a = bound_f(in.i_a, f->size);
        y.i_b = bound_f(in.i_b, f->size);
        break;
    case FAULTY_SWAPPED:
        y.i_a = in.i_b;
        y.i_b = in.i_a;
        break;
    case FAULTY_REVERSED:
        y.i_a = -in.i_a;
        break;
    case FAULTY_LINK:
        y.u_dc = f->size * in.u_dc;
        break;
    default:
        break;
    }
    y.i_a = bound_f(y.i_a, s->sensor.range);
    y.i_b = bound_f(y.i_b, s->sensor.range);
    return y;
}

/* Puts a new voltage into the queue and returns the one that acts next. */
static ab_t late(loop_t *loop, ab_t u, int32_t periods) {
    for (int j = LATEST; j > 0; j--) {
        loop->waiting[j] = loop->waiting[j - 1];
    }
    loop->waiting[0] = u;
    return loop->waiting[periods < LATEST ? periods : LATEST];
}

/* One period; whether the bridge stays closed. theta: true angle at its sample, which the estimate
 * is of [rad]. */
static int period(sim_t *s, const faulty_t *f, const ks_schedule_params_t *schedule,
                  ks_schedule_state_t *weight, loop_t *loop, float *theta) {
    drive_state_t *x = &s->drive.x;
    int on = s->k >= f->from && s->k < f->to;
    int kind = on ? f->kind : FAULTY_NONE;
    profile_step(&s->profile, &s->now, s->k);
    drive_in_t in = sim_sample(s, &s->drive, 0.0f, s->plant.detail);
    *theta = (float)s->drive.y.theta_e;
    in = on ? spoil(s, f, loop, in) : in;
    loop->was = in;
    ab_t u = loop->waiting[0];
    if (kind != FAULTY_MISSED || !happens(s, f->size)) {
        int calls = kind == FAULTY_DOUBLED && happens(s, f->size) ? 2 : 1;
        for (int j = 0; j < calls; j++) {
            in.k_s_ref = ks_schedule_step(schedule, weight, &s->control.signal, &x->signal);
            u = drive_step_inline(&s->control, x, &in);
        }
    }
    float truth = s->now.u_dc * guard_inv_link(&s->control.guard, in.u_dc);
    ab_t act = late(loop, u, kind == FAULTY_LATE ? (int32_t)f->size : 0);
    act.a *= kind == FAULTY_LINK ? truth : 1.0f;
    act.b *= kind == FAULTY_LINK ? truth : 1.0f;
    chain_advance(s, &s->drive, act, s->plant.n_sub, s->plant.extra, s->plant.detail);
    s->k += 1;
    return (x->fault & FAULT_OVER_CURRENT) == 0;
}

/* The hardware has opened the bridge, and the firmware passes that on. */
static void trip(sim_t *s, faulty_end_t *end) {
    end->by_trip = end->k_flag < 0;
    end->k_flag = end->by_trip ? s->k : end->k_flag;
    drive_trip(&s->drive.x);
}

/* Counts what the judge counts, at the true angle theta [rad]; the current vector [A]. */
static float judge(sim_t *s, faulty_end_t *end, float theta) {
    const chain_t *c = &s->drive;
    float i = (float)(c->y.i_d * c->y.i_d + c->y.i_q * c->y.i_q);
    float err = abs_f(wrap_pi(theta - c->x.est.theta));
    err = c->x.start.phase == START_DONE ? err : 0.0f;
    s->err_count = err > s->err_limit ? s->err_count + 1 : 0;
    s->lost |= (s->err_count > s->err_periods ? LOST_ANGLE : 0) |
               (i <= s->i_trip * s->i_trip ? 0 : LOST_CURRENT);
    end->k_lost = end->k_lost < 0 && s->lost != 0 ? s->k : end->k_lost;
    end->k_flag = end->k_flag < 0 && c->x.fault != 0 ? s->k : end->k_flag;
    i = sqrt_f(i);
    end->i_peak = max_f(end->i_peak, i);
    end->i_unseen = end->k_flag < 0 ? max_f(end->i_unseen, i) : end->i_unseen;
    if ((s->lost & LOST_CURRENT) != 0) {
        trip(s, end);
    }
    return i;
}

static void run(sim_t *s, const faulty_t *f, const ks_schedule_params_t *schedule,
                faulty_end_t *end) {
    loop_t loop = {0};
    faulty_end_t none = {-1, -1, 0, 0, 0.0f, 0.0f, 0};
    ks_schedule_state_t weight;
    ks_schedule_init(schedule, &weight);
    *end = none;
    int closed = 1;
    float theta = 0.0f;
    while (closed && s->k < s->k_end) {
        closed = period(s, f, schedule, &weight, &loop, &theta);
        closed = judge(s, end, theta) <= s->i_trip && closed;
    }
    end->lost = s->lost;
    end->fault = s->drive.x.fault;
}

void faulty_run(sim_t *s, int32_t n, const faulty_t *f, const ks_schedule_params_t *schedule,
                faulty_end_t *end) {
    for (int32_t j = 0; j < n; j++) {
        run(&s[j], &f[j], schedule, &end[j]);
    }
}
