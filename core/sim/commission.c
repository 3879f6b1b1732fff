/* Test commands through inverter, machine and sensors. */
#include "commission.h"

#include "sim_period.h"

/* Current along a vector of the command's sign in the direction r. */
static float along_command(const command_t *c, rot_t r, ab_t i) {
    float x = r.c * i.a + r.s * i.b;
    return c->from + c->to < 0.0f ? 0.0f - x : x;
}

/* Voltage for the next period: the command itself, or that of the current control, whose q axis is
 * the command's direction. */
static ab_t commission_voltage(sim_t *s, const command_t *c, float share, ab_t i, float u_dc) {
    estimate_t est = s->drive.x.est;
    float size = c->from + share * (c->to - c->from);
    if (c->kind == COMMAND_VOLTAGE) {
        control_state_t none = {0};
        dq_t u = {size, 0.0f};
        s->drive.x.control = none;
        return dq_to_ab(u, rot_of(est.theta));
    }
    estimate_t frame = {wrap_pi(est.theta - HALF_PI_F), est.omega};
    return current_control(&s->control.control, &s->drive.x.control, frame, rot_of(frame.theta), i,
                           u_dc, size, 0.0f, s->control.T_s);
}

static void commission_row(const sim_t *s, int32_t segment, const drive_in_t *in, double *row) {
    row[COMMISSION_SEGMENT] = (double)segment;
    row[COMMISSION_U_ALPHA] = (double)s->drive.u.a;
    row[COMMISSION_U_BETA] = (double)s->drive.u.b;
    row[COMMISSION_U_DC] = (double)in->u_dc;
    row[COMMISSION_I_A] = (double)in->i_a;
    row[COMMISSION_I_B] = (double)in->i_b;
    row[COMMISSION_THETA] = (double)s->drive.x.est.theta;
    row[COMMISSION_OMEGA] = (double)s->drive.x.est.omega;
}

int32_t commission_run(sim_t *s, const command_t *c, int32_t n, float i_stop, double *out) {
    int32_t rows = 0;
    estimate_t *est = &s->drive.x.est;
    float slow = 0.0f; /* voltage along the current [V] */
    float fast = 0.0f;
    for (int32_t j = 0; j < n; j++) {
        est->theta = c[j].go_on != 0 ? est->theta : c[j].theta;
        for (int32_t k = 0; k < c[j].n; k++) {
            float share = (float)k / (float)c[j].n;
            est->omega = c[j].omega_0 +
                         (c[j].omega_1 - c[j].omega_0) * 0.5f * (1.0f - rot_of(PI_F * share).c) -
                         c[j].damp * fast;
            drive_in_t in = sim_sample(s, &s->drive, 0.0f, s->plant.detail);
            ab_t i = phases_to_ab(in.i_a, in.i_b);
            if (c[j].i_end > 0.0f && along_command(&c[j], rot_of(est->theta), i) >= c[j].i_end) {
                break;
            }
            commission_row(s, j, &in, &out[(long)rows * COMMISSION_N]);
            rows += 1;
            ab_t u = commission_voltage(s, &c[j], share, i, in.u_dc);
            rot_t r = rot_of(est->theta);
            float along = r.c * u.a + r.s * u.b;
            slow = c[j].damp > 0.0f ? slow + c[j].follow * (along - slow) : along;
            fast = along - slow;
            chain_advance(s, &s->drive, u, s->plant.n_sub, s->plant.extra, s->plant.detail);
            s->k += 1;
            est->theta = wrap_pi(est->theta + s->control.T_s * est->omega);
            if (norm_ab(i) > i_stop) {
                return rows;
            }
        }
    }
    return rows;
}
