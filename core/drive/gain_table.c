/* Check and lookup of the grids of gains. */
#include "gain_table.h"

#include "ks_lookup.h"

uint32_t gain_header_crc(const gain_table_t *t) {
    uint32_t crc = 0xFFFFFFFFUL;
    crc = ks_crc32_u32(crc, t->magic);
    crc = ks_crc32_u32(crc, t->format);
    crc = ks_crc32_u32(crc, t->n_gains);
    crc = ks_crc32_u32(crc, t->n_nodes);
    for (int g = 0; g < GAIN_N; g++) {
        crc = ks_crc32_u32(crc, t->gain[g]);
        crc = ks_crc32_u32(crc, bits_of(t->limit[g].rise));
        crc = ks_crc32_u32(crc, bits_of(t->limit[g].bend));
        crc = ks_crc32_u32(crc, bits_of(t->limit[g].least));
        crc = ks_crc32_u32(crc, bits_of(t->limit[g].most));
        crc = ks_crc32_u32(crc, bits_of(t->limit[g].pace));
    }
    crc = ks_crc32_u32(crc, t->crc_table);
    crc = ks_crc32_u32(crc, t->crc_values);
    return crc ^ 0xFFFFFFFFUL;
}

static int is_q15(const ks_table_t *axes) { return axes->value_format == KS_VALUES_Q15; }

uint32_t gain_values_crc(const gain_table_t *t, const ks_table_t *axes, const void *values) {
    uint32_t crc = 0xFFFFFFFFUL;
    for (uint32_t j = 0; j < t->n_gains * t->n_nodes; j++) {
        crc = is_q15(axes) ? ks_crc32_word(crc, ((const uint16_t *)values)[j])
                           : ks_crc32_u32(crc, bits_of(((const float *)values)[j]));
    }
    return crc ^ 0xFFFFFFFFUL;
}

static int sizes_ok(const gain_table_t *t, const ks_table_t *axes) {
    if (t->n_gains < 1 || t->n_gains > GAIN_N || t->n_nodes != axes->n_nodes ||
        t->n_gains * t->n_nodes > KS_TABLE_NODES) {
        return 0;
    }
    int rising = t->gain[t->n_gains - 1] < GAIN_N;
    for (uint32_t g = 1; g < t->n_gains; g++) {
        rising = rising && t->gain[g] > t->gain[g - 1];
    }
    return rising;
}

/* Monotone, so that every value has a factor of its own, and above 0 where values may be. */
static int limit_ok(const gain_limits_t *p) {
    return p->rise >= 0.0f && finite_f(p->rise) && 2.0f * abs_f(p->bend) <= p->rise &&
           1.0f + p->least * (p->rise + p->bend * p->least) > 0.0f && p->least >= -1.0f &&
           p->least <= 0.0f && p->most >= 0.0f && p->most <= 1.0f && p->pace > 0.0f &&
           p->pace <= 1.0f;
}

static int ranges_ok(const gain_table_t *t, const ks_table_t *axes, const void *values) {
    int q15 = is_q15(axes);
    float one = q15 ? 32767.0f : 1.0f;
    for (uint32_t g = 0; g < t->n_gains; g++) {
        const gain_limits_t *p = &t->limit[g];
        const void *grid = ahead(values, g * t->n_nodes, q15);
        if (!limit_ok(p)) {
            return 0;
        }
        for (uint32_t j = 0; j < t->n_nodes; j++) {
            float v = node(grid, j, q15);
            if (!(v >= one * p->least && v <= one * p->most)) {
                return 0;
            }
        }
    }
    return 1;
}

int gain_table_check(const gain_table_t *t, const ks_table_t *axes, const void *values) {
    if (t->magic != GAINS_MAGIC) {
        return KS_BAD_MAGIC;
    }
    if (t->format != GAINS_FORMAT) {
        return KS_BAD_FORMAT;
    }
    if (gain_header_crc(t) != t->crc_header || t->crc_table != axes->crc_header) {
        return KS_BAD_CRC;
    }
    if (!sizes_ok(t, axes)) {
        return KS_BAD_AXES;
    }
    if (gain_values_crc(t, axes, values) != t->crc_values) {
        return KS_BAD_CRC;
    }
    return ranges_ok(t, axes, values) ? KS_OK : KS_BAD_VALUE;
}

void ks_table_place(const ks_table_t *t, const float *y, ks_cell_t *cell) {
    uint32_t at = 0;
    for (uint32_t a = 0; a < t->n_axes; a++) {
        const ks_axis_t *x = &t->axis[a];
        float v = y[x->signal];
        uint32_t j;
        int known = place(x, v, (v - x->x0) * x->inv_step, &j, &cell->f[a]);
        cell->f[a] = known ? cell->f[a] : v - v;
        at = at * x->n + j;
    }
    cell->at = at;
    cell->not_at = ~at;
}

/* Nodes from one node of an axis to the next; the last axis' step is 1 and left out. */
CORE_INLINE void steps_of(const ks_table_t *t, uint32_t *step) {
    uint32_t size = 1;
    for (uint32_t a = t->n_axes - 1; a > 0; a--) {
        size *= t->axis[a].n;
        step[a - 1] = size;
    }
}

CORE_INLINE float mix_cell(const void *v, const float *f, const uint32_t *step, uint32_t n_axes,
                           int q15) {
    switch (n_axes) {
    case 1:
        return mix_1(v, f, q15);
    case 2:
        return mix_2(v, f, step, q15);
    case 3:
        return mix_3(v, f, step, q15);
    default:
        return mix_4(v, f, step, q15);
    }
}

/* Mean over the cell of two and of three axes, which are the usual ones; node values are floats. */
CORE_INLINE float mean_2(const ks_table_t *t, const void *values, uint32_t at, const float *f) {
    return mix_2(ahead(values, at, 0), f, &t->axis[1].n, 0);
}

CORE_INLINE float mean_3(const ks_table_t *t, const void *values, uint32_t at, const float *f) {
    uint32_t step[2] = {t->axis[1].n * t->axis[2].n, t->axis[2].n};
    return mix_3(ahead(values, at, 0), f, step, 0);
}

float ks_table_at(const ks_table_t *t, const void *values, const ks_cell_t *cell) {
    if (t->kind == 3) {
        return weight(t, mean_3(t, values, cell->at, cell->f), 0);
    }
    if (t->kind == 2) {
        return weight(t, mean_2(t, values, cell->at, cell->f), 0);
    }
    uint32_t step[KS_TABLE_AXES] = {0};
    int q15 = is_q15(t);
    const void *v = ahead(values, cell->at, q15);
    steps_of(t, step);
    return q15 ? weight(t, mix_cell(v, cell->f, step, t->n_axes, 1), 1)
               : weight(t, mix_cell(v, cell->f, step, t->n_axes, 0), 0);
}

float gain_table_at(const gain_table_t *t, const ks_table_t *axes, const void *values,
                    const ks_cell_t *cell, uint32_t g) {
    uint32_t at = g * t->n_nodes + cell->at;
    if (axes->kind == 3) {
        return mean_3(axes, values, at, cell->f);
    }
    if (axes->kind == 2) {
        return mean_2(axes, values, at, cell->f);
    }
    uint32_t step[KS_TABLE_AXES] = {0};
    int q15 = is_q15(axes);
    const void *v = ahead(values, at, q15);
    steps_of(axes, step);
    float x = q15 ? mix_cell(v, cell->f, step, axes->n_axes, 1) * (1.0f / 32767.0f)
                  : mix_cell(v, cell->f, step, axes->n_axes, 0);
    return x;
}

void gain_table_eval_many(const gain_table_t *t, const ks_table_t *axes, const void *values,
                          const float *y, float *wanted, uint32_t n, uint32_t stride) {
    for (uint32_t i = 0; i < n; i++) {
        float *row = &wanted[(unsigned long)i * GAIN_N];
        ks_cell_t cell;
        ks_table_place(axes, &y[(unsigned long)i * stride], &cell);
        for (int g = 0; g < GAIN_N; g++) {
            row[g] = 0.0f;
        }
        for (uint32_t g = 0; g < t->n_gains; g++) {
            row[t->gain[g]] = gain_table_at(t, axes, values, &cell, g);
        }
    }
}
