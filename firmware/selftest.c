/* Self test of an exported schedule on a host: status 0 and one line if every check passes.
 *
 * Does this folder, compiled here, give the words that were noted where it was exported; is a damaged
 * table noticed and replaced by the built-in rule; does a bad input stay without harm?
 */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../params.h"
#include "drive_vectors.h"

#if FLT_EVAL_METHOD != 0
#error "float32 is not computed in float32; on 32-bit x86 compile with -msse2 -mfpmath=sse"
#endif

static const char *const problem[] = {
    "good",          "not a table",    "unknown format number",  "wrong CRC",
    "axis at fault", "value at fault", "made for another motor",
};

static unsigned long failures;

static void fail(const char *name, const char *what, unsigned long bad, unsigned long first) {
    fprintf(stderr, "self test FAILED: %s: %s: %lu, first %lu\n", name, what, bad, first);
    failures++;
}

/* Flips every bit of an image of n bytes that `check` reads; returns the number not noticed. */
static unsigned long flip(unsigned char *image, size_t n, const ks_table_t *t, const void *values) {
    unsigned long missed = 0;
    for (size_t j = 0; j < 8 * n; j++) {
        unsigned char bit = (unsigned char)(1U << (j % 8));
        image[j / 8] = (unsigned char)(image[j / 8] ^ bit);
        missed += ks_table_check(t, values, MOTOR_HASH) == KS_OK ? 1U : 0U;
        image[j / 8] = (unsigned char)(image[j / 8] ^ bit);
    }
    return missed;
}

static void test_table(const char *name, const ks_table_t *t, const void *values,
                       const ks_vector_t *vectors, uint32_t n) {
    ks_table_t copy = *t;
    uint32_t first;
    int check = ks_table_check(t, values, MOTOR_HASH);
    if (check != KS_OK) {
        fprintf(stderr, "self test FAILED: %s: check: %s (code %d)\n", name, problem[check], check);
        failures++;
        return;
    }
    uint32_t bad = ks_table_selftest(t, values, vectors, n, &first);
    if (bad != 0) {
        fail(name, "lookups that differ from the golden vectors", bad, first);
    }
    size_t bytes =
        t->n_nodes * (t->value_format == KS_VALUES_Q15 ? sizeof(int16_t) : sizeof(float));
    unsigned char *image = malloc(bytes);
    if (image == NULL) {
        fail(name, "bytes of memory not to be had", (unsigned long)bytes, 0);
        return;
    }
    memcpy(image, values, bytes);
    unsigned long missed =
        flip((unsigned char *)&copy, sizeof copy, &copy, values) + flip(image, bytes, t, image);
    free(image);
    if (missed != 0) {
        fail(name, "flipped bits that the check did not notice", missed, 0);
    }
}

/* A refused table: the built-in rule decides and the fault is reported. */
static void test_refused(const char *name, ks_table_t broken, const void *values, int expected) {
    ks_schedule_params_t p = schedule_params;
    ks_schedule_state_t x;
    unsigned long bad = 0;
    p.table = &broken;
    p.values = values;
    bad += ks_schedule_init(&p, &x) == expected ? 0U : 1U;
    for (int j = 0; j < 50; j++) {
        signal_state_t signals = {0};
        signals.omega = (float)(j - 25) * 0.02f / drive_params.signal.inv_omega;
        float speed = abs_f(signals.omega) * drive_params.signal.inv_omega;
        x.wait = 0;
        float k_s = ks_schedule_step(&p, &x, &drive_params.signal, &signals);
        bad += k_s >= 0.0f && k_s <= 1.0f && k_s == ks_rule(&p.rule, speed) ? 0U : 1U;
    }
    bad += x.fault == KS_FAULT_TABLE ? 0U : 1U;
    if (bad != 0) {
        fail(name, "wrong reactions to a refused table", bad, 0);
    }
}

static void test_refusals(void) {
    ks_table_t t = ks_table_f32;
    t.format++;
    test_refused("format number", t, ks_values_f32, KS_BAD_FORMAT);
    t = ks_table_f32;
    t.crc_values ^= 1U;
    t.crc_header = ks_header_crc(&t);
    test_refused("CRC of the values", t, ks_values_f32, KS_BAD_CRC);
    t = ks_table_f32;
    t.motor_hash ^= 1U;
    t.crc_header = ks_header_crc(&t);
    test_refused("motor", t, ks_values_f32, KS_BAD_MOTOR);
    test_refused("no values", ks_table_f32, 0, KS_BAD_MAGIC);
}

/* Every input in turn, a few periods of each bad value: outputs stay numbers, the fault is set. */
static void test_inputs(void) {
    static const uint32_t words[] = {0x7FC00000U, 0xFFC00000U, 0x7F800000U, 0xFF800000U,
                                     0x7F7FFFFFU, 0xFF7FFFFFU, 0x7F800001U};
    unsigned long bad = 0;
    for (unsigned j = 0; j < 5 * sizeof words / sizeof words[0]; j++) {
        drive_state_t x;
        float in[5] = {0.1f, -0.2f, 540.0f, 10.0f, 0.5f};
        drive_init(&drive_params, &x, 3.1f, 100.0f, 0.5f);
        memcpy(&in[j % 5], &words[j / 5], sizeof in[0]);
        for (int k = 0; k < 20; k++) {
            drive_in_t raw = {in[0], in[1], in[2], in[3], in[4]};
            ab_t u = drive_step(&drive_params, &x, &raw);
            bad += finite_f(u.a) && finite_f(u.b) && finite_f(x.est.theta) &&
                           finite_f(x.est.omega) && x.k_s >= 0.0f && x.k_s <= 1.0f && x.fault != 0
                       ? 0U
                       : 1U;
        }
    }
    if (bad != 0) {
        fail("drive_step", "bad inputs that did harm or went unnoticed", bad, 0);
    }
}

int main(void) {
    uint32_t first;
    test_table("float table", &ks_table_f32, ks_values_f32, ks_vectors_f32, KS_VECTORS_F32);
    test_table("Q15 table", &ks_table_q15, ks_values_q15, ks_vectors_q15, KS_VECTORS_Q15);
    uint32_t bad = drive_selftest(&drive_params, &schedule_params, &drive_start, drive_vectors,
                                  DRIVE_VECTORS, &first);
    if (bad != 0) {
        fail("control core", "periods that differ from the golden vectors", bad, first);
    }
    test_refusals();
    test_inputs();
    if (failures != 0) {
        return 1;
    }
    printf("self test passed: %d vectors\n", KS_VECTORS_F32 + KS_VECTORS_Q15 + DRIVE_VECTORS);
    return 0;
}
