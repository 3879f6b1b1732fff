/* Self test of an exported schedule on a host: status 0 and one line if every check passes.
 *
 * It checks that this folder, compiled here, gives the same words as where it was exported; that a
 * damaged table is noticed and replaced by the built-in rule; and that bad inputs do no harm.
 */
#include <stdio.h>

#include "../params.h"
#include "arithmetic.h"
#include "drive_vectors.h"
#include "faults.h"
#if KS_TABLE_CMSIS
#include "cmsis.h"
#endif

#ifdef KS_USE_Q15
#error "the golden periods are those of the float table: compile the self test without KS_USE_Q15"
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

static void test_table(const char *name, const ks_table_t *t, const void *values,
                       const ks_vector_t *vectors, uint32_t n) {
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
    uint32_t missed = faults_flips(t, values, MOTOR_HASH);
    if (missed != 0) {
        fail(name, "flipped bits that the check did not notice", missed, 0);
    }
}

static void test_faults(const char *name, const char *what, uint32_t bad) {
    if (bad != 0) {
        fail(name, what, bad, 0);
    }
}

#if KS_TABLE_GAINS
static drive_params_t live;

static void test_gains(const char *name, const gain_table_t *t, const ks_table_t *axes,
                       const void *k_s, const void *values, const gain_vector_t *vectors,
                       uint32_t n) {
    uint32_t first;
    int check = gain_table_check(t, axes, values);
    if (check != KS_OK) {
        fprintf(stderr, "self test FAILED: %s: check: %s (code %d)\n", name, problem[check], check);
        failures++;
        return;
    }
    uint32_t bad = gain_table_selftest(t, axes, k_s, values, vectors, n, &first);
    if (bad != 0) {
        fail(name, "lookups that differ from the golden vectors", bad, first);
    }
}
#endif

/* All of the drive's periods, under the schedule that was exported. */
static uint32_t periods(uint32_t *first) {
#if KS_TABLE_GAINS
    return gain_drive_selftest(&drive_params, &live, &gain_schedule_params, &drive_start,
                               drive_vectors, DRIVE_VECTORS, first);
#else
    return drive_selftest(&drive_params, &schedule_params, &drive_start, drive_vectors,
                          DRIVE_VECTORS, first);
#endif
}

int main(void) {
    uint32_t first;
    const char *fault = arithmetic_fault();
    if (fault != 0) {
        fprintf(stderr, "self test FAILED: arithmetic: %s\n", fault);
        return 1;
    }
    test_table("float table", &ks_table_f32, ks_values_f32, ks_vectors_f32, KS_VECTORS_F32);
    test_table("Q15 table", &ks_table_q15, ks_values_q15, ks_vectors_q15, KS_VECTORS_Q15);
#if KS_TABLE_GAINS
    test_gains("float gains", &gain_table_f32, &ks_table_f32, ks_values_f32, gain_values_f32,
               gain_vectors_f32, KS_GAIN_VECTORS_F32);
    test_gains("Q15 gains", &gain_table_q15, &ks_table_q15, ks_values_q15, gain_values_q15,
               gain_vectors_q15, KS_GAIN_VECTORS_Q15);
#endif
    uint32_t bad = periods(&first);
    if (bad != 0) {
        fail("control core", "periods that differ from the golden vectors", bad, first);
    }
#if KS_TABLE_CMSIS
    test_faults("CMSIS table", "lookups that differ from the core's",
                cmsis_differences(&ks_table_f32, ks_values_f32));
#endif
    const signal_params_t *signal = &drive_params.signal;
    test_faults("schedule", "wrong reactions to a refused table",
                faults_refusals(&schedule_params, signal));
    test_faults("schedule", "wrong reactions to bad signals",
                faults_signals(&schedule_params, signal));
    test_faults("drive_step", "bad inputs that did harm or went unnoticed",
                faults_inputs(&drive_params));
    test_faults("drive_step", "wrong outputs at the seam", faults_angles(&drive_params));
    test_faults("drive_step", "weights out of range", faults_weights(&drive_params));
    if (failures != 0) {
        return 1;
    }
    printf("self test passed: %d vectors\n", KS_VECTORS_F32 + KS_VECTORS_Q15 + DRIVE_VECTORS);
    return 0;
}
