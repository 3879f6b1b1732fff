/* Check and lookup of the schedule table. */
#include "ks_table.h"

#include "ks_lookup.h"
#include "signals.h"

uint32_t ks_crc32_word(uint32_t crc, uint32_t word) {
    uint32_t x = crc ^ (word & 0xFFFFUL);
    for (int j = 0; j < 16; j++) {
        x = (x >> 1) ^ ((x & 1UL) != 0U ? 0xEDB88320UL : 0UL);
    }
    return x;
}

uint32_t ks_header_crc(const ks_table_t *t) {
    uint32_t crc = 0xFFFFFFFFUL;
    crc = ks_crc32_u32(crc, t->magic);
    crc = ks_crc32_u32(crc, t->format);
    crc = ks_crc32_u32(crc, t->value_format);
    crc = ks_crc32_u32(crc, t->n_axes);
    crc = ks_crc32_u32(crc, t->n_nodes);
    crc = ks_crc32_u32(crc, t->kind);
    for (uint32_t a = 0; a < KS_TABLE_AXES; a++) {
        crc = ks_crc32_u32(crc, t->axis[a].signal);
        crc = ks_crc32_u32(crc, t->axis[a].n);
        crc = ks_crc32_u32(crc, bits_of(t->axis[a].x0));
        crc = ks_crc32_u32(crc, bits_of(t->axis[a].inv_step));
        crc = ks_crc32_u32(crc, bits_of(t->axis[a].top));
    }
    crc = ks_crc32_u32(crc, bits_of(t->slew_per_s));
    crc = ks_crc32_u32(crc, bits_of(t->fallback));
    crc = ks_crc32_u32(crc, t->policy_hash);
    crc = ks_crc32_u32(crc, t->motor_hash);
    crc = ks_crc32_u32(crc, t->crc_values);
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
            crc = ks_crc32_u32(crc, bits_of(v[j]));
        }
    }
    return crc ^ 0xFFFFFFFFUL;
}

static int axes_ok(const ks_table_t *t) {
    uint32_t nodes = 1;
    uint32_t q15 = t->value_format == KS_VALUES_Q15 ? (uint32_t)KS_KIND_Q15 : 0U;
    if (t->n_axes < 1 || t->n_axes > KS_TABLE_AXES || t->kind != (t->n_axes | q15)) {
        return 0;
    }
    for (uint32_t a = 0; a < t->n_axes; a++) {
        const ks_axis_t *x = &t->axis[a];
        if (x->signal >= SIGNAL_N || x->n < 2 || x->n > KS_TABLE_NODES) {
            return 0;
        }
        if (!finite_f(x->x0) || !finite_f(x->inv_step) || x->inv_step <= 0.0f ||
            x->top != (float)(int32_t)(x->n - 1)) {
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

/* First all positions, then the nodes: this order needs fewer registers at a time. */
#define POSITION(a)                                                                                \
    float y##a = y[t->axis[a].signal];                                                             \
    float pos##a = (y##a - t->axis[a].x0) * t->axis[a].inv_step;
#define PLACE(a)                                                                                   \
    uint32_t j##a;                                                                                 \
    if (!place(&t->axis[a], y##a, pos##a, &j##a, &f[a])) {                                         \
        return fallback(t);                                                                        \
    }

CORE_INLINE float eval_1(const ks_table_t *t, const void *v, const float *y, int q15) {
    float f[1];
    POSITION(0)
    PLACE(0)
    return weight(t, mix_1(ahead(v, j0, q15), f, q15), q15);
}

CORE_INLINE float eval_2(const ks_table_t *t, const void *v, const float *y, int q15) {
    float f[2];
    POSITION(0)
    POSITION(1)
    PLACE(0)
    PLACE(1)
    uint32_t step[1] = {t->axis[1].n};
    uint32_t at = j0 * step[0] + j1;
    return weight(t, mix_2(ahead(v, at, q15), f, step, q15), q15);
}

CORE_INLINE float eval_3(const ks_table_t *t, const void *v, const float *y, int q15) {
    float f[3];
    POSITION(0)
    POSITION(1)
    POSITION(2)
    PLACE(0)
    PLACE(1)
    PLACE(2)
    uint32_t step[2] = {t->axis[1].n * t->axis[2].n, t->axis[2].n};
    uint32_t at = j0 * step[0] + j1 * step[1] + j2;
    return weight(t, mix_3(ahead(v, at, q15), f, step, q15), q15);
}

CORE_INLINE float eval_4(const ks_table_t *t, const void *v, const float *y, int q15) {
    float f[4];
    POSITION(0)
    POSITION(1)
    POSITION(2)
    POSITION(3)
    PLACE(0)
    PLACE(1)
    PLACE(2)
    PLACE(3)
    uint32_t n = t->axis[3].n;
    uint32_t step[3] = {t->axis[1].n * t->axis[2].n * n, t->axis[2].n * n, n};
    uint32_t at = j0 * step[0] + j1 * step[1] + j2 * step[2] + j3;
    return weight(t, mix_4(ahead(v, at, q15), f, step, q15), q15);
}

/* Separate functions, so that none has to save the registers that another needs. */
#define APART(name, eval, q15)                                                                     \
    CORE_APART float name(const ks_table_t *t, const void *v, const float *y) {                    \
        return eval(t, v, y, q15);                                                                 \
    }
APART(eval_1_f32, eval_1, 0)
APART(eval_2_f32, eval_2, 0)
APART(eval_3_f32, eval_3, 0)
APART(eval_4_f32, eval_4, 0)
APART(eval_1_q15, eval_1, 1)
APART(eval_2_q15, eval_2, 1)
APART(eval_3_q15, eval_3, 1)
APART(eval_4_q15, eval_4, 1)

CORE_APART float eval_rare(const ks_table_t *t, const void *v, const float *y) {
    switch (t->kind) {
    case 1:
        return eval_1_f32(t, v, y);
    case 4:
        return eval_4_f32(t, v, y);
    case KS_KIND_Q15 | 1:
        return eval_1_q15(t, v, y);
    default:
        return eval_4_q15(t, v, y);
    }
}

float ks_table_eval(const ks_table_t *t, const void *values, const float *y) {
    uint32_t kind = t->kind;
    if (kind == 2) {
        return eval_2_f32(t, values, y);
    }
    if (kind == 3) {
        return eval_3_f32(t, values, y);
    }
    if (kind == (KS_KIND_Q15 | 2)) {
        return eval_2_q15(t, values, y);
    }
    return kind == (KS_KIND_Q15 | 3) ? eval_3_q15(t, values, y) : eval_rare(t, values, y);
}

void ks_table_eval_many(const ks_table_t *t, const void *values, const float *y, float *k_s,
                        uint32_t n, uint32_t stride) {
    for (uint32_t i = 0; i < n; i++) {
        k_s[i] = ks_table_eval(t, values, &y[(unsigned long)i * stride]);
    }
}
