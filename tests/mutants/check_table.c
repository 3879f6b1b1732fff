/* Table and schedule: CRC by its definition over bytes, lookups by the sum over corners, and the
 * fault tests that ship. */
#include <string.h>

#include "checks.h"
#include "faults.h"

static float nodes[KS_TABLE_NODES];
static int16_t q15[KS_TABLE_NODES];

/* CRC-32 of bytes, low byte of each word first. */
static uint32_t crc_bytes(const void *data, size_t words, int half) {
    uint32_t crc = 0xFFFFFFFFU;
    for (size_t k = 0; k < words; k++) {
        uint32_t word = half ? ((const uint16_t *)data)[k] : ((const uint32_t *)data)[k];
        for (int byte = 0; byte < (half ? 2 : 4); byte++) {
            crc ^= (word >> (8 * byte)) & 0xFFU;
            for (int bit = 0; bit < 8; bit++) {
                crc = (crc >> 1) ^ (crc & 1U ? 0xEDB88320U : 0U);
            }
        }
    }
    return ~crc;
}

static ks_table_t table(uint32_t n_axes, int half) {
    static const uint32_t nodes_of[4][4] = {{12}, {12, 12}, {11, 3, 12}, {9, 3, 3, 12}};
    static const uint32_t signal[4] = {0, 1, 2, 11};
    const uint32_t *n = nodes_of[n_axes - 1];
    ks_table_t t;
    memset(&t, 0, sizeof t);
    t.magic = KS_TABLE_MAGIC, t.format = KS_TABLE_FORMAT;
    t.value_format = half ? KS_VALUES_Q15 : KS_VALUES_F32;
    t.n_axes = n_axes, t.n_nodes = 1, t.kind = n_axes | (half ? (uint32_t)KS_KIND_Q15 : 0U);
    for (uint32_t a = 0; a < n_axes; a++) {
        ks_axis_t x = {signal[a], n[a], -0.5f + 0.3f * (float)a, 0.4f * (float)n[a],
                       (float)(n[a] - 1)};
        t.axis[a] = x;
        t.n_nodes *= n[a];
    }
    for (uint32_t j = 0; j < t.n_nodes; j++) {
        nodes[j] = draw_f(0, 1);
        nodes[j] = j == 1 || j == 2 ? (float)(j - 1) : nodes[j]; /* the ends count */
        q15[j] = (int16_t)(32767.0f * nodes[j]);
    }
    nodes[t.n_nodes] = (float)NAN, q15[t.n_nodes] = -1; /* beyond the table */
    t.slew_per_s = 50.0f, t.fallback = 0.75f, t.policy_hash = 3, t.motor_hash = 9;
    t.crc_values = half ? crc_bytes(q15, t.n_nodes, 1) : crc_bytes(nodes, t.n_nodes, 0);
    t.crc_header = crc_bytes(&t, sizeof t / 4 - 1, 0);
    return t;
}

static double corners(const ks_table_t *t, const float *y, int half) {
    double sum = 0.0;
    for (uint32_t c = 0; c < 1U << t->n_axes; c++) {
        double share = 1.0;
        uint32_t at = 0;
        for (uint32_t a = 0; a < t->n_axes; a++) {
            const ks_axis_t *x = &t->axis[a];
            double pos = ((double)y[x->signal] - (double)x->x0) * (double)x->inv_step;
            pos = fmin(fmax(pos, 0.0), x->n - 1.0);
            uint32_t left = (uint32_t)fmin(floor(pos), x->n - 2.0);
            uint32_t up = (c >> a) & 1U;
            share *= up ? pos - left : 1.0 - (pos - left);
            at = at * x->n + left + up;
        }
        sum += share * (half ? q15[at] / 32767.0 : (double)nodes[at]);
    }
    return sum;
}

static void lookups(uint32_t n_axes, int half) {
    ks_table_t t = table(n_axes, half);
    const void *values = half ? (const void *)q15 : (const void *)nodes;
    check("good table",
          ks_table_check(&t, values, 9) == KS_OK && ks_table_check(&t, values, 0) == KS_OK);
    check("CRC", ks_header_crc(&t) == t.crc_header && ks_values_crc(&t, values) == t.crc_values);
    float y[2 * SIGNAL_N];
    for (int j = 0; j < 150; j++) {
        for (int k = 0; k < 2 * SIGNAL_N; k++) {
            y[k] = draw_f(-1, 3);
        }
        check("lookup", near((double)ks_table_eval(&t, values, y), corners(&t, y, half), 3e-6));
        float many[2];
        ks_table_eval_many(&t, values, y, many, 2, SIGNAL_N);
        check("lookups", many[0] == ks_table_eval(&t, values, y) &&
                             many[1] == ks_table_eval(&t, values, y + SIGNAL_N));
        uint32_t which = t.axis[j % (int)n_axes].signal;
        y[which] = j % 3 ? 3e38f : -3e38f;
        check("far signal", near((double)ks_table_eval(&t, values, y), corners(&t, y, half), 3e-6));
        y[which] = j % 3 == 0 ? (float)NAN : (j % 3 == 1 ? (float)INFINITY : -(float)INFINITY);
        check("bad signal", ks_table_eval(&t, values, y) == 0.75f);
    }
    for (uint32_t a = 0; a < n_axes; a++) {
        y[t.axis[a].signal] = 1e3f;
        float far = ks_table_eval(&t, values, y);
        y[t.axis[a].signal] = t.axis[a].x0 + t.axis[a].top / t.axis[a].inv_step;
        check("last node", near((double)ks_table_eval(&t, values, y), (double)far, 3e-6));
    }
    for (int k = 0; k < SIGNAL_N; k++) {
        y[k] = 0.0f;
    }
    for (uint32_t j = 0; j < t.n_nodes; j++) {
        nodes[j] = j % 2 ? (float)NAN : 40.0f;
        q15[j] = (int16_t)(-5 - (int)j);
    }
    check("damaged nodes", ks_table_eval(&t, values, y) == 0.75f);
    t.fallback = 7.0f;
    check("damaged fallback", ks_table_eval(&t, values, y) == 1.0f);
}

/* One axis with every node that a table may have. */
static void as_large_as_it_gets(ks_table_t *t) {
    ks_axis_t x = {0, KS_TABLE_NODES, 0.0f, 1.0f, KS_TABLE_NODES - 1.0f};
    for (int j = 0; j < KS_TABLE_NODES; j++) {
        nodes[j] = 0.5f;
    }
    t->axis[0] = x, t->n_axes = 1, t->kind = 1, t->n_nodes = KS_TABLE_NODES;
}

/* Each change of a good header, with its sum made right, gets its answer. */
#define ANSWERS(change, why)                                                                       \
    {                                                                                              \
        ks_table_t t = table(2, 0);                                                                \
        change;                                                                                    \
        t.crc_values =                                                                             \
            crc_bytes(nodes, t.n_nodes < KS_TABLE_NODES ? t.n_nodes : KS_TABLE_NODES, 0);          \
        t.crc_header = crc_bytes(&t, sizeof t / 4 - 1, 0);                                         \
        check("answer: " #change, ks_table_check(&t, nodes, 9) == (why));                          \
    }

static void answers(void) {
    ANSWERS(t.magic ^= 1U, KS_BAD_MAGIC)
    ANSWERS(as_large_as_it_gets(&t), KS_OK)
    ANSWERS(t.format += 1U, KS_BAD_FORMAT)
    ANSWERS(t.value_format += 1U, KS_BAD_FORMAT)
    ANSWERS(t.motor_hash += 1U, KS_BAD_MOTOR)
    ANSWERS(t.n_axes = 0, KS_BAD_AXES)
    ANSWERS(t.n_axes = 5, KS_BAD_AXES)
    ANSWERS(t.kind = 3, KS_BAD_AXES)
    ANSWERS((t.n_axes = 0, t.kind = 0, t.n_nodes = 1), KS_BAD_AXES)
    ANSWERS((t.n_axes = 5, t.kind = 5), KS_BAD_AXES)
    ANSWERS(t.axis[1].signal = SIGNAL_N, KS_BAD_AXES)
    ANSWERS(t.axis[0].n = 1, KS_BAD_AXES)
    ANSWERS((t.axis[0].n = 1, t.axis[0].top = 0.0f, t.n_nodes = 4), KS_BAD_AXES)
    ANSWERS(t.axis[0].n = 2000, KS_BAD_AXES)
    ANSWERS(t.axis[0].x0 = (float)NAN, KS_BAD_AXES)
    ANSWERS(t.axis[1].inv_step = 0.0f, KS_BAD_AXES)
    ANSWERS(t.axis[1].inv_step = -2.0f, KS_BAD_AXES)
    ANSWERS(t.axis[1].inv_step = (float)INFINITY, KS_BAD_AXES)
    ANSWERS(t.axis[1].top = 4.0f, KS_BAD_AXES)
    ANSWERS(t.n_nodes = 19, KS_BAD_AXES)
    ANSWERS((t.axis[0].n = 600, t.axis[0].top = 599.0f), KS_BAD_AXES)
    ANSWERS(t.fallback = 1.0f, KS_OK)
    ANSWERS(t.fallback = 0.0f, KS_OK)
    ANSWERS(t.fallback = -0.1f, KS_BAD_VALUE)
    ANSWERS(t.fallback = 1.1f, KS_BAD_VALUE)
    ANSWERS(t.slew_per_s = 0.0f, KS_BAD_VALUE)
    ANSWERS(t.slew_per_s = (float)INFINITY, KS_BAD_VALUE)
    ANSWERS(nodes[0] = 1.01f, KS_BAD_VALUE)
    ANSWERS(nodes[3] = 1.01f, KS_BAD_VALUE)
    ANSWERS(nodes[3] = -0.01f, KS_BAD_VALUE)
    ANSWERS(nodes[t.n_nodes - 1] = (float)NAN, KS_BAD_VALUE)
    ks_table_t t = table(1, 0);
    as_large_as_it_gets(&t);
    for (int j = 0; j < KS_TABLE_NODES; j++) {
        nodes[j] = (float)j / KS_TABLE_NODES;
    }
    for (int j = 0; j < 50; j++) {
        float y[SIGNAL_N] = {draw_f(0, KS_TABLE_NODES - 1)};
        check("large table",
              near((double)ks_table_eval(&t, nodes, y), (double)y[0] / KS_TABLE_NODES, 1e-6));
    }
    t = table(2, 1);
    q15[4] = -1;
    t.crc_values = crc_bytes(q15, t.n_nodes, 1);
    t.crc_header = crc_bytes(&t, sizeof t / 4 - 1, 0);
    check("refused: negative Q15", ks_table_check(&t, q15, 9) == KS_BAD_VALUE);
}

static void schedule(void) {
    ks_table_t t = table(4, 0);
    signal_params_t signal = {0.03f, 190.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    ks_schedule_params_t p = {&t, nodes, 9, {0.2f, 0.3f}, 11};
    check("flips", faults_flips(&t, nodes, 9) == 0);
    check("refusals", faults_refusals(&p, &signal) == 0);
    check("signals", faults_signals(&p, &signal) == 0);
    ks_schedule_state_t x;
    signal_state_t at = {0};
    check("schedule",
          ks_schedule_init(&p, &x) == KS_OK && x.fault == 0 && x.wait == 0 && x.k_s_ref == 1.0f);
    for (int k = 0; k < 60; k++) {
        at.omega = draw_f(0, 1), at.i_q = draw_f(-1, 1), at.disagree = draw_f(-1, 1);
        at.voltage = draw_f(0, 3);
        float y[SIGNAL_N], was = x.k_s_ref;
        signals_read(&signal, &at, y);
        float k_s = ks_schedule_step(&p, &x, &signal, &at);
        check("decision", k_s == (k % 11 ? was : ks_table_eval(&t, nodes, y)));
        check("decision on good signals", x.fault == 0);
    }
    x.wait = 99;
    at.omega = (float)NAN;
    check("bad input",
          ks_schedule_step(&p, &x, &signal, &at) == 0.75f && x.fault == KS_FAULT_INPUT);
    x = (ks_schedule_state_t){0};
    at.omega = 0.25f;
    check("not checked", near((double)ks_schedule_step(&p, &x, &signal, &at), 0.5, 1e-5) &&
                             x.fault == KS_FAULT_TABLE);
    at.omega = (float)NAN;
    p.table = 0;
    check("fault bits", KS_FAULT_TABLE == 1 && KS_FAULT_INPUT == 2);
    check("no table", ks_schedule_init(&p, &x) == KS_BAD_MAGIC && x.fault == KS_FAULT_TABLE);
    check("rule of NaN", ks_schedule_step(&p, &x, &signal, &at) == 1.0f &&
                             x.fault == (KS_FAULT_TABLE | KS_FAULT_INPUT));
    for (int k = 0; k < 30; k++) {
        x.wait = 0, x.fault = 0;
        at.omega = draw_f(-0.5, 0.5);
        double want = fmin(fmax((0.3 - fabs((double)at.omega)) / 0.1, 0.0), 1.0);
        check("rule", near((double)ks_schedule_step(&p, &x, &signal, &at), want, 1e-5));
        check("rule: its bit", x.fault == KS_FAULT_TABLE && x.wait == p.periods - 1);
    }
}

void check_table(void) {
    for (uint32_t n = 1; n <= 4; n++) {
        lookups(n, 0);
        lookups(n, 1);
    }
    answers();
    schedule();
}
