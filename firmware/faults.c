/* Fault tests without a C library. */
#include "faults.h"

#include <limits.h>

enum { BAD_N = 11 };

static const uint32_t bad_words[BAD_N] = {
    0x7FC00000UL, 0xFFC00000UL, 0x7F800001UL,               /* NaN: quiet, negative, signalling */
    0x7F800000UL, 0xFF800000UL, 0x7F7FFFFFUL, 0xFF7FFFFFUL, /* infinite, largest */
    0x00000001UL, 0x807FFFFFUL, 0x80000000UL, 0x00800000UL, /* denormal, -0, least normal */
};
enum { FIRST_HARMLESS = 7 }; /* the words from here on are valid numbers */

static float bad_float(uint32_t j) {
    union {
        uint32_t u;
        float f;
    } y;
    y.u = bad_words[j];
    return y.f;
}

/* Flips every bit of an object of n characters in turn; returns how many flips the check missed. */
static uint32_t flips(unsigned char *object, uint32_t n, const ks_table_t *t, const void *values,
                      uint32_t motor_hash) {
    uint32_t missed = 0;
    for (uint32_t j = 0; j < n; j++) {
        unsigned char was = object[j];
        for (uint32_t b = 0; b < CHAR_BIT; b++) {
            object[j] = (unsigned char)(was ^ (1U << b));
            missed += ks_table_check(t, values, motor_hash) == KS_OK ? 1U : 0U;
        }
        object[j] = was;
    }
    return missed;
}

uint32_t faults_flips(const ks_table_t *t, const void *values, uint32_t motor_hash) {
    static union {
        float f32[KS_TABLE_NODES];
        int16_t q15[KS_TABLE_NODES];
    } image;
    ks_table_t header = *t;
    uint32_t n = t->n_nodes;
    int q15 = t->value_format == KS_VALUES_Q15;
    for (uint32_t j = 0; j < n; j++) {
        if (q15) {
            image.q15[j] = ((const int16_t *)values)[j];
        } else {
            image.f32[j] = ((const float *)values)[j];
        }
    }
    uint32_t bytes = n * (uint32_t)(q15 ? sizeof image.q15[0] : sizeof image.f32[0]);
    uint32_t bad = ks_table_check(&header, &image, motor_hash) == KS_OK ? 0U : 1U;
    bad += flips((unsigned char *)&header, sizeof header, &header, &image, motor_hash);
    return bad + flips((unsigned char *)&image, bytes, &header, &image, motor_hash);
}

static uint32_t refused(const ks_schedule_params_t *p, const signal_params_t *signal,
                        int expected) {
    ks_schedule_state_t x;
    signal_state_t y;
    signals_clear(&y);
    uint32_t bad = ks_schedule_init(p, &x) == expected ? 0U : 1U;
    for (int j = -25; j <= 25; j++) {
        y.omega = (float)j * 0.02f / signal->inv_omega;
        x.wait = 0;
        float k_s = ks_schedule_step(p, &x, signal, &y);
        float rule = ks_rule(&p->rule, abs_f(y.omega) * signal->inv_omega);
        bad += k_s == rule && k_s >= 0.0f && k_s <= 1.0f ? 0U : 1U;
    }
    return bad + (x.fault == KS_FAULT_TABLE ? 0U : 1U);
}

uint32_t faults_refusals(const ks_schedule_params_t *p, const signal_params_t *signal) {
    ks_schedule_params_t q = *p;
    ks_table_t t = *p->table;
    uint32_t bad = 0;
    q.table = &t;
    t.format++;
    t.crc_header = ks_header_crc(&t);
    bad += refused(&q, signal, KS_BAD_FORMAT);
    t = *p->table;
    t.crc_values ^= 1U;
    t.crc_header = ks_header_crc(&t);
    bad += refused(&q, signal, KS_BAD_CRC);
    t = *p->table;
    t.motor_hash ^= 1U;
    t.crc_header = ks_header_crc(&t);
    bad += refused(&q, signal, KS_BAD_MOTOR);
    t = *p->table;
    q.values = 0;
    return bad + refused(&q, signal, KS_BAD_MAGIC);
}

/* One signal at a time is bad: directly in the lookup, and as speed through the schedule. */
uint32_t faults_signals(const ks_schedule_params_t *p, const signal_params_t *signal) {
    uint32_t bad = 0;
    ks_schedule_state_t x;
    signal_state_t state;
    if (ks_table_check(p->table, p->values, p->motor_hash) != KS_OK) {
        return 1; /* nobody may look up in it */
    }
    signals_clear(&state);
    for (uint32_t j = 0; j < BAD_N; j++) {
        for (uint32_t a = 0; a < p->table->n_axes; a++) {
            float y[SIGNAL_N];
            for (int i = 0; i < SIGNAL_N; i++) {
                y[i] = 0.1f;
            }
            float v = bad_float(j);
            y[p->table->axis[a].signal] = v;
            float k_s = ks_table_eval(p->table, p->values, y);
            bad += k_s >= 0.0f && k_s <= 1.0f ? 0U : 1U;
            bad += finite_f(v) || k_s == p->table->fallback ? 0U : 1U;
        }
        ks_schedule_init(p, &x);
        state.omega = bad_float(j);
        float k_s = ks_schedule_step(p, &x, signal, &state);
        bad += k_s >= 0.0f && k_s <= 1.0f ? 0U : 1U;
    }
    return bad;
}

/* 0 if the outputs of a period are finite and in range. */
static uint32_t harmed(const drive_state_t *x, ab_t u) {
    return finite_f(u.a) && finite_f(u.b) && abs_f(x->est.theta) <= 3.1416f &&
                   finite_f(x->est.omega) && x->k_s >= 0.0f && x->k_s <= 1.0f
               ? 0U
               : 1U;
}

static float link(const drive_params_t *p) {
    return 0.5f * (p->guard.u_dc_min + p->guard.u_dc_max);
}

static drive_in_t with_bad(const drive_params_t *p, uint32_t first, uint32_t second, float v) {
    float i = 0.01f * p->guard.i_sample;
    float in[5] = {i, -2.0f * i, link(p), 0.01f * p->guard.omega, 0.5f};
    in[first] = v;
    in[second] = v;
    drive_in_t y = {in[0], in[1], in[2], in[3], in[4]};
    return y;
}

uint32_t faults_inputs(const drive_params_t *p) {
    drive_state_t x;
    uint32_t bad = 0;
    for (uint32_t j = 0; j < BAD_N * 25; j++) {
        drive_in_t in = with_bad(p, j % 5, j / 5 % 5, bad_float(j / 25));
        drive_init(p, &x, 3.1f, 0.1f * p->guard.omega, 0.5f);
        for (int k = 0; k < 20; k++) {
            bad += harmed(&x, drive_step(p, &x, &in));
        }
        bad += j / 25 >= FIRST_HARMLESS || x.fault != 0 ? 0U : 1U;
        x.fault = 0;
        in = with_bad(p, 0, 0, 0.0f);
        for (int k = 0; k < 20; k++) {
            bad += harmed(&x, drive_step(p, &x, &in));
        }
        bad += x.fault == 0 ? 0U : 1U;
    }
    return bad;
}

uint32_t faults_angles(const drive_params_t *p) {
    static const float start[6] = {PI_F, -PI_F, 3.1415925f, -3.1415925f, 9.42477f, -9.42477f};
    drive_state_t x;
    uint32_t bad = 0;
    for (uint32_t j = 0; j < 12; j++) {
        float omega = j % 2 == 0 ? 0.4f * p->guard.omega : -0.4f * p->guard.omega;
        drive_init(p, &x, start[j / 2], omega, (float)(j % 3) * 0.5f);
        for (int k = 0; k < 200; k++) {
            drive_in_t in = {0.0f, 0.0f, link(p), omega, (float)(j % 3) * 0.5f};
            bad += harmed(&x, drive_step(p, &x, &in));
        }
    }
    return bad;
}

uint32_t faults_weights(const drive_params_t *p) {
    static const float k_s[6] = {0.0f, 1.0f, -0.0f, 1.0000001f, -1.0e-30f, 2.0f};
    drive_state_t x;
    uint32_t bad = 0;
    int n = 500 + (int)(0.5f / p->k_s_step); /* the weight moves by one step a period */
    for (uint32_t j = 0; j < 6; j++) {
        drive_init(p, &x, 0.0f, 0.1f * p->guard.omega, 0.5f);
        drive_in_t in = {0.0f, 0.0f, link(p), 0.1f * p->guard.omega, k_s[j]};
        for (int k = 0; k < n; k++) {
            x.lock.bad = 0; /* no machine answers here, which lock.h would tell */
            bad += harmed(&x, drive_step(p, &x, &in));
        }
        float want = j < 3 ? k_s[j] : 0.5f;
        bad += x.k_s == want && (x.fault == 0) == (j < 3) ? 0U : 1U;
    }
    return bad;
}
