/* Check and lookup of the schedule table. */
#include "ks_table.h"

#include "signals.h"

/* The bits of a float without breaking the aliasing rules. */
static uint32_t bits_of(float x) {
    union {
        float f;
        uint32_t u;
    } y;
    y.f = x;
    return y.u;
}

uint32_t ks_crc32_word(uint32_t crc, uint32_t word) {
    uint32_t x = crc ^ (word & 0xFFFFUL);
    for (int j = 0; j < 16; j++) {
        x = (x >> 1) ^ ((x & 1UL) != 0U ? 0xEDB88320UL : 0UL);
    }
    return x;
}

static uint32_t crc_u32(uint32_t crc, uint32_t x) {
    return ks_crc32_word(ks_crc32_word(crc, x), x >> 16);
}

uint32_t ks_header_crc(const ks_table_t *t) {
    uint32_t crc = 0xFFFFFFFFUL;
    crc = crc_u32(crc, t->magic);
    crc = crc_u32(crc, t->format);
    crc = crc_u32(crc, t->value_format);
    crc = crc_u32(crc, t->n_axes);
    crc = crc_u32(crc, t->n_nodes);
    for (uint32_t a = 0; a < KS_TABLE_AXES; a++) {
        crc = crc_u32(crc, t->axis[a].signal);
        crc = crc_u32(crc, t->axis[a].n);
        crc = crc_u32(crc, bits_of(t->axis[a].x0));
        crc = crc_u32(crc, bits_of(t->axis[a].inv_step));
    }
    crc = crc_u32(crc, bits_of(t->slew_per_s));
    crc = crc_u32(crc, bits_of(t->fallback));
    crc = crc_u32(crc, t->policy_hash);
    crc = crc_u32(crc, t->motor_hash);
    crc = crc_u32(crc, t->crc_values);
    return crc ^ 0xFFFFFFFFUL;
}

uint32_t ks_values_crc(const ks_table_t *t, const void *values) {
    uint32_t crc = 0xFFFFFFFFUL;
    if (t->value_format == KS_VALUES_Q15) {
        const uint16_t *v = (const uint16_t *)values;
        for (uint32_t j = 0; j < t->n_nodes; j++) {
            crc = ks_crc32_word(crc, v[j]);
        }
    } else {
        const float *v = (const float *)values;
        for (uint32_t j = 0; j < t->n_nodes; j++) {
            crc = crc_u32(crc, bits_of(v[j]));
        }
    }
    return crc ^ 0xFFFFFFFFUL;
}

static int axes_ok(const ks_table_t *t) {
    uint32_t nodes = 1;
    if (t->n_axes < 1 || t->n_axes > KS_TABLE_AXES) {
        return 0;
    }
    for (uint32_t a = 0; a < t->n_axes; a++) {
        const ks_axis_t *x = &t->axis[a];
        if (x->signal >= SIGNAL_N || x->n < 2 || x->n > KS_TABLE_NODES) {
            return 0;
        }
        if (!finite_f(x->x0) || !finite_f(x->inv_step) || x->inv_step <= 0.0f) {
            return 0;
        }
        nodes *= x->n;
        if (nodes > KS_TABLE_NODES) {
            return 0;
        }
    }
    return nodes == t->n_nodes;
}

static int values_ok(const ks_table_t *t, const void *values) {
    for (uint32_t j = 0; j < t->n_nodes; j++) {
        if (t->value_format == KS_VALUES_Q15) {
            if (((const int16_t *)values)[j] < 0) {
                return 0;
            }
        } else {
            float v = ((const float *)values)[j];
            if (!(v >= 0.0f && v <= 1.0f)) {
                return 0;
            }
        }
    }
    return t->fallback >= 0.0f && t->fallback <= 1.0f && finite_f(t->slew_per_s) &&
           t->slew_per_s > 0.0f;
}

int ks_table_check(const ks_table_t *t, const void *values, uint32_t motor_hash) {
    if (t->magic != KS_TABLE_MAGIC) {
        return KS_BAD_MAGIC;
    }
    if (t->format != KS_TABLE_FORMAT ||
        (t->value_format != KS_VALUES_F32 && t->value_format != KS_VALUES_Q15)) {
        return KS_BAD_FORMAT;
    }
    if (ks_header_crc(t) != t->crc_header) {
        return KS_BAD_CRC;
    }
    if (!axes_ok(t)) {
        return KS_BAD_AXES;
    }
    if (ks_values_crc(t, values) != t->crc_values) {
        return KS_BAD_CRC;
    }
    if (!values_ok(t, values)) {
        return KS_BAD_VALUE;
    }
    return motor_hash == 0 || motor_hash == t->motor_hash ? KS_OK : KS_BAD_MOTOR;
}

/* Multilinear interpolation over n axes; n is a constant at each call, so the loops unroll. */
CORE_INLINE float eval_n(const ks_table_t *t, const void *values, const float *y, uint32_t n) {
    float frac[KS_TABLE_AXES];
    uint32_t stride[KS_TABLE_AXES];
    uint32_t offset = 0;
    uint32_t size = 1;
    int finite = 1;
    for (uint32_t i = 1; i <= n; i++) { /* the last axis first: it is the fastest */
        uint32_t a = n - i;
        const ks_axis_t *x = &t->axis[a];
        float v = y[x->signal];
        float pos = clamp_f((v - x->x0) * x->inv_step, 0.0f, (float)(int32_t)(x->n - 1));
        int32_t j = (int32_t)pos;
        int32_t last = (int32_t)x->n - 2;
        j = j < last ? j : last;
        finite &= finite_f(v);
        frac[a] = pos - (float)j;
        stride[a] = size;
        offset += (uint32_t)j * size;
        size *= x->n;
    }
    float corner[1U << KS_TABLE_AXES];
    for (uint32_t c = 0; c < (1U << n); c++) {
        uint32_t at = offset;
        for (uint32_t a = 0; a < n; a++) {
            at += ((c >> a) & 1U) != 0U ? stride[a] : 0U;
        }
        corner[c] = t->value_format == KS_VALUES_Q15
                        ? (float)((const int16_t *)values)[at] * (1.0f / 32767.0f)
                        : ((const float *)values)[at];
    }
    for (uint32_t i = 1; i <= n; i++) {
        uint32_t half = 1U << (n - i);
        for (uint32_t c = 0; c < half; c++) {
            corner[c] += frac[n - i] * (corner[c + half] - corner[c]);
        }
    }
    return finite ? clamp_f(corner[0], 0.0f, 1.0f) : t->fallback;
}

float ks_table_eval(const ks_table_t *t, const void *values, const float *y) {
    switch (t->n_axes) {
    case 1:
        return eval_n(t, values, y, 1);
    case 2:
        return eval_n(t, values, y, 2);
    case 3:
        return eval_n(t, values, y, 3);
    default:
        return eval_n(t, values, y, 4);
    }
}

void ks_table_eval_many(const ks_table_t *t, const void *values, const float *y, float *k_s,
                        uint32_t n, uint32_t stride) {
    for (uint32_t i = 0; i < n; i++) {
        k_s[i] = ks_table_eval(t, values, &y[(unsigned long)i * stride]);
    }
}
