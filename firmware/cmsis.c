/* Comparison of the CMSIS-DSP layout of a table with the core's lookup. */
#include "cmsis.h"

#include "../cmsis/ks_table_cmsis.h"
#include "../core/signals.h"

#define ROUNDING 1e-6f
enum { PER_NODE = 4, FAR = 2, BEYOND = 2 * PER_NODE }; /* points per node; far and close outside */

typedef struct {
    uint16_t numRows;
    uint16_t numCols;
    const float *pData;
} instance_t;

/* arm_bilinear_interp_f32 as documented, including its zeros outside the table. */
static float bilinear(const instance_t *s, float x, float y) {
    if (!(x > -1.0f && y > -1.0f && x < 32768.0f && y < 32768.0f)) {
        return 0.0f;
    }
    int32_t i = (int32_t)x;
    int32_t j = (int32_t)y;
    if (i > (int32_t)s->numCols - 2 || j > (int32_t)s->numRows - 2) {
        return 0.0f;
    }
    const float *f = s->pData + i + j * (int32_t)s->numCols;
    const float *g = f + s->numCols;
    float dx = x - (float)i;
    float dy = y - (float)j;
    return f[0] + (f[1] - f[0]) * dx + (g[0] - f[0]) * dy + (f[0] - f[1] - g[0] + g[1]) * dx * dy;
}

/* The j-th of places(a) signals on an axis: far outside, close outside, and across the table. */
static float place(const ks_axis_t *a, int32_t j, int32_t n) {
    if (j < FAR || j >= n - FAR) {
        float far = j == 0 || j == n - 1 ? 3e38f : 1e6f;
        return j < FAR ? -far : far;
    }
    return a->x0 + (float)(j - FAR - BEYOND) / ((float)PER_NODE * a->inv_step);
}

static int32_t places(const ks_axis_t *a) {
    return PER_NODE * ((int32_t)a->n - 1) + 1 + 2 * BEYOND + 2 * FAR;
}

uint32_t cmsis_differences(const ks_table_t *t, const float *values) {
    const instance_t s = {KS_CMSIS_ROWS, KS_CMSIS_COLS, ks_cmsis_data};
    const ks_axis_t *row = &t->axis[0];
    const ks_axis_t *column = &t->axis[1];
    float y[SIGNAL_N] = {0.0f};
    uint32_t bad = 0;
    if (ks_table_check(t, values, 0) != KS_OK || t->n_axes != 2 || row->n + 1 != s.numRows ||
        column->n + 1 != s.numCols) {
        return 1;
    }
    for (int32_t j = 0; j < places(row); j++) {
        for (int32_t i = 0; i < places(column); i++) {
            y[row->signal] = place(row, j, places(row));
            y[column->signal] = place(column, i, places(column));
            float ours = ks_table_eval(t, values, y);
            float theirs = bilinear(&s, ks_cmsis_x(y[column->signal]), ks_cmsis_y(y[row->signal]));
            float off = ours - theirs;
            bad += !(off <= ROUNDING && off >= -ROUNDING);
        }
    }
    return bad;
}
