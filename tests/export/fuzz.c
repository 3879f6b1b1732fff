/* libFuzzer: the input's words become a table, its signals, and the inputs of a few periods.
 * Whatever they are: no undefined behaviour, no number out of range. */
#include <stddef.h>
#include <string.h>

#include "params.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

static void take(void *to, size_t n, const unsigned char **data, size_t *size) {
    size_t have = n < *size ? n : *size;
    memset(to, 0, n);
    memcpy(to, *data, have);
    *data += have;
    *size -= have;
}

static void require(int good) {
    if (!good) {
        __builtin_trap();
    }
}

/* A damaged header or damaged values; with the sums made right if the first byte is odd, so that
 * the checks behind them are reached as well. */
static void fuzz_table(const unsigned char *data, size_t size) {
    static float values[KS_TABLE_NODES];
    static const float zero[KS_TABLE_NODES];
    unsigned char sealed;
    ks_table_t t = ks_table_f32;
    float y[SIGNAL_N];
    take(&sealed, 1, &data, &size);
    unsigned char change[sizeof t];
    take(change, sizeof change, &data, &size);
    for (size_t j = 0; j < sizeof t; j++) {
        ((unsigned char *)&t)[j] ^= change[j];
    }
    take(y, sizeof y, &data, &size);
    memcpy(values, zero, sizeof values);
    memcpy(values, ks_values_f32, sizeof(float) * ks_table_f32.n_nodes);
    unsigned char node[sizeof(float) * 8];
    take(node, sizeof node, &data, &size);
    memcpy(values, node, sealed & 2 ? sizeof node : 0);
    if (sealed & 1) {
        t.magic = KS_TABLE_MAGIC;
        t.format = KS_TABLE_FORMAT;
        t.crc_values = t.n_nodes <= KS_TABLE_NODES ? ks_values_crc(&t, values) : 0;
        t.crc_header = ks_header_crc(&t);
    }
    ks_schedule_params_t p = schedule_params;
    ks_schedule_state_t x;
    signal_state_t state;
    p.table = &t;
    p.values = values;
    if (ks_schedule_init(&p, &x) == KS_OK) {
        float k_s = ks_table_eval(&t, values, y);
        require(k_s >= 0.0f && k_s <= 1.0f);
    }
    take(&state, sizeof state, &data, &size);
    float k_s = ks_schedule_step(&p, &x, &drive_params.signal, &state);
    require(k_s >= 0.0f && k_s <= 1.0f);
}

static void fuzz_drive(const unsigned char *data, size_t size) {
    drive_state_t x;
    drive_init(&drive_params, &x, 1.0f, 100.0f, 0.5f);
    if (size > 0 && (data[0] & 1) != 0) {
        drive_find_rotor(&x);
    }
    while (size > 0) {
        drive_in_t in;
        take(&in, sizeof in, &data, &size);
        ab_t u = drive_step(&drive_params, &x, &in);
        require(finite_f(u.a) && finite_f(u.b) && finite_f(x.est.omega));
        require(x.est.theta >= -3.2f && x.est.theta <= 3.2f && x.k_s >= 0.0f && x.k_s <= 1.0f);
    }
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    if (size > 0 && (data[0] & 4) != 0) {
        fuzz_drive(data + 1, size - 1);
    } else {
        fuzz_table(data, size);
    }
    return 0;
}
