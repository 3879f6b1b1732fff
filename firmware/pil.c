/* Processor in the loop: runs the exported control core as the host requests. */
#include "faults.h"
#include "params.h"
#include "pil_stages.h"
#include "pil_wire.h"
#include "port.h"
#include "test/drive_vectors.h"

static drive_state_t drive[PIL_DRIVES];
static ks_schedule_state_t schedule[PIL_DRIVES];
#if KS_TABLE_GAINS
static gain_schedule_state_t gains[PIL_DRIVES];
static drive_params_t live[PIL_DRIVES];
#endif

static union {
    pil_start_t start[PIL_DRIVES];
    drive_in_t in[PIL_DRIVES];
    pil_lookup_in_t lookup[PIL_DRIVES];
} item;

static union {
    pil_info_t info;
    pil_tests_t tests;
    pil_step_t step[PIL_DRIVES];
    pil_lookup_t lookup[PIL_DRIVES];
    pil_stages_t stages[PIL_DRIVES];
} answer;

/* Has the call of ks_table_eval, but only loads and returns. */
static __attribute__((noinline)) float nothing(const ks_table_t *t, const void *values,
                                               const float *y) {
    (void)t;
    (void)values;
    return y[0];
}

static uint32_t info(void) {
    pil_info_t *y = &answer.info;
    y->drive_state = sizeof(drive_state_t);
#if KS_TABLE_GAINS
    y->schedule_state = sizeof gains[0] + sizeof live[0]; /* it writes to the latter */
#else
    y->schedule_state = sizeof schedule[0];
#endif
    y->drive_params = sizeof(drive_params_t);
    uint32_t t = port_ticks();
    y->ticks_0 = port_since(t);
    t = port_ticks();
    answer.lookup[PIL_DRIVES - 1].k_s_f32 = nothing(&ks_table_f32, ks_values_f32, item.lookup[0].y);
    y->ticks_call = port_since(t);
    t = port_ticks();
    port_thousand();
    y->ticks_1000 = port_since(t);
    return sizeof *y;
}

static uint32_t tests(void) {
    pil_tests_t *y = &answer.tests;
    uint32_t first;
    y->lookups_f32 =
        ks_table_selftest(&ks_table_f32, ks_values_f32, ks_vectors_f32, KS_VECTORS_F32, &first);
    y->lookups_q15 =
        ks_table_selftest(&ks_table_q15, ks_values_q15, ks_vectors_q15, KS_VECTORS_Q15, &first);
#if KS_TABLE_GAINS
    y->lookups_f32 +=
        gain_table_selftest(&gain_table_f32, &ks_table_f32, ks_values_f32, gain_values_f32,
                            gain_vectors_f32, KS_GAIN_VECTORS_F32, &first);
    y->lookups_q15 +=
        gain_table_selftest(&gain_table_q15, &ks_table_q15, ks_values_q15, gain_values_q15,
                            gain_vectors_q15, KS_GAIN_VECTORS_Q15, &first);
    y->periods = gain_drive_selftest(&drive_params, &live[0], &gain_schedule_params, &drive_start,
                                     drive_vectors, DRIVE_VECTORS, &first);
#else
    y->periods = drive_selftest(&drive_params, &schedule_params, &drive_start, drive_vectors,
                                DRIVE_VECTORS, &first);
#endif
    y->flips_f32 = faults_flips(&ks_table_f32, ks_values_f32, MOTOR_HASH);
    y->flips_q15 = faults_flips(&ks_table_q15, ks_values_q15, MOTOR_HASH);
    y->refusals = faults_refusals(&schedule_params, &drive_params.signal);
    y->signals = faults_signals(&schedule_params, &drive_params.signal);
    y->inputs = faults_inputs(&drive_params);
    y->angles = faults_angles(&drive_params);
    y->weights = faults_weights(&drive_params);
    return sizeof *y;
}

static void start(uint32_t j) {
    pil_step_t *y = &answer.step[j];
    const pil_start_t *at = &item.start[j];
    drive_init(&drive_params, &drive[j], at->theta, at->omega, at->k_s);
    if (at->seek > 0.0f) {
        drive_find_rotor(&drive[j]);
    }
    ks_schedule_init(&schedule_params, &schedule[j]);
#if KS_TABLE_GAINS
    gain_schedule_init(&gain_schedule_params, &gains[j], &drive_params, &live[j]);
#endif
    y->x = drive[j];
    y->schedule = schedule[j];
    y->u.a = 0.0f;
    y->u.b = 0.0f;
    y->ticks = 0;
    y->ticks_drive = 0;
}

/* Weight for this period; raw: that of the request. */
static float decide(uint32_t j, const drive_in_t *in, int raw) {
    if (raw != 0) {
        return in->k_s_ref;
    }
#if KS_TABLE_GAINS
    return gain_schedule_step(&gain_schedule_params, &gains[j], &drive_params, &live[j],
                              &drive[j].signal);
#else
    return ks_schedule_step(&schedule_params, &schedule[j], &drive_params.signal, &drive[j].signal);
#endif
}

/* Numbers that drive j runs on. */
static const drive_params_t *numbers(uint32_t j) {
#if KS_TABLE_GAINS
    return &live[j];
#else
    (void)j;
    return &drive_params;
#endif
}

static void step(uint32_t j, int raw) {
    pil_step_t *y = &answer.step[j];
    drive_in_t in = item.in[j];
    uint32_t t = port_ticks();
    in.k_s_ref = decide(j, &in, raw);
    uint32_t t_drive = port_ticks();
    y->u = drive_step(numbers(j), &drive[j], &in);
    y->ticks_drive = port_since(t_drive);
    y->ticks = port_since(t);
    y->x = drive[j];
#if KS_TABLE_GAINS
    schedule[j] = gains[j].ks;
#endif
    y->schedule = schedule[j];
}

static void lookup(uint32_t j) {
    pil_lookup_t *y = &answer.lookup[j];
    const float *signals = item.lookup[j].y;
    uint32_t t = port_ticks();
    y->k_s_f32 = ks_table_eval(&ks_table_f32, ks_values_f32, signals);
    y->ticks_f32 = port_since(t);
    t = port_ticks();
    y->k_s_q15 = ks_table_eval(&ks_table_q15, ks_values_q15, signals);
    y->ticks_q15 = port_since(t);
}

/* Bytes of one item of a request. */
static uint32_t item_size(uint32_t operation) {
    switch (operation) {
    case PIL_START:
        return sizeof(pil_start_t);
    case PIL_STEP:
    case PIL_RAW:
    case PIL_STAGES:
        return sizeof(drive_in_t);
    case PIL_LOOKUP:
        return sizeof(pil_lookup_in_t);
    default:
        return 0;
    }
}

/* Serves item j; returns the bytes of its answer. */
static uint32_t serve(uint32_t operation, uint32_t j) {
    switch (operation) {
    case PIL_START:
        start(j);
        return sizeof(pil_step_t);
    case PIL_STEP:
    case PIL_RAW:
        step(j, operation == PIL_RAW);
        return sizeof(pil_step_t);
    case PIL_LOOKUP:
        lookup(j);
        return sizeof(pil_lookup_t);
    default:
        answer.stages[j] = pil_stages(&drive[j], &schedule[j], &item.in[j]);
        return sizeof(pil_stages_t);
    }
}

int main(void) {
    pil_request_t request;
    if (port_open() == 0) {
        return 2;
    }
    while (port_read(&request, sizeof request / 4) != 0) {
        uint32_t bytes = 0;
        if (request.operation == PIL_EXIT) {
            return 0;
        }
        if (request.operation > PIL_STAGES || request.n > PIL_DRIVES ||
            port_read(&item, request.n * item_size(request.operation) / 4) == 0) {
            return 3;
        }
        if (request.operation == PIL_INFO) {
            bytes = info();
        } else if (request.operation == PIL_TESTS) {
            bytes = tests();
        }
        for (uint32_t j = 0; j < request.n; j++) {
            bytes += serve(request.operation, j);
        }
        if (port_write(&answer, bytes / 4) == 0) {
            return 4;
        }
    }
    return 5;
}
