/* Gains of gains.h over the axes of a k_s table: one place in the grid, several values.
 *
 * The grids follow each other in one array, each like the nodes of the k_s table; together they have
 * at most KS_TABLE_NODES nodes. Values are -1 ... 1, in 16 bits -0x7FFF ... 0x7FFF; 0 is the static
 * gain in both. The header belongs to one k_s table, whose header CRC it holds: gain_table_check
 * must accept both before either is used.
 */
#ifndef SENSORLESS_GAIN_TABLE_H
#define SENSORLESS_GAIN_TABLE_H

#include "gains.h"
#include "ks_table.h"

#define GAINS_MAGIC 0x47535442UL /* "GSTB" */
#define GAINS_FORMAT 1UL

typedef struct {
    uint32_t magic;              /* GAINS_MAGIC */
    uint32_t format;             /* GAINS_FORMAT */
    uint32_t n_gains;            /* grids, 1 ... GAIN_N */
    uint32_t n_nodes;            /* nodes of each grid: those of the k_s table */
    uint32_t gain[GAIN_N];       /* GAIN_* of each grid, rising; unused ones are 0 */
    gain_limits_t limit[GAIN_N]; /* of each grid; unused ones are 0 */
    uint32_t crc_table;          /* header CRC of the k_s table */
    uint32_t crc_values;         /* over the node values */
    uint32_t crc_header;         /* over all words above */
} gain_table_t;

/* A place in the grid of a k_s table. */
typedef struct {
    uint32_t at;            /* first node of the cell */
    uint32_t not_at;        /* its complement: damage to one of them shows */
    float f[KS_TABLE_AXES]; /* fraction on each axis; NaN: its signal is not finite */
} ks_cell_t;

#ifdef __cplusplus
extern "C" {
#endif

/* The CRCs that belong in t->crc_header and t->crc_values. */
uint32_t gain_header_crc(const gain_table_t *t);
uint32_t gain_values_crc(const gain_table_t *t, const ks_table_t *axes, const void *values);

/* Checks magic, format, CRCs, sizes and ranges. axes: the k_s table, which ks_table_check accepted;
 * its value_format is also that of `values`. Returns KS_OK or KS_BAD_*. */
int gain_table_check(const gain_table_t *t, const ks_table_t *axes, const void *values);

/* Place of the signals y[SIGNAL_N]. */
void ks_table_place(const ks_table_t *t, const float *y, ks_cell_t *cell);

/* k_s there: ks_table_eval to the bit. */
float ks_table_at(const ks_table_t *t, const void *values, const ks_cell_t *cell);

/* Value of grid g there, NaN if a signal is not finite; g < t->n_gains. */
float gain_table_at(const gain_table_t *t, const ks_table_t *axes, const void *values,
                    const ks_cell_t *cell, uint32_t g);

/* Values of all gains for n rows of signals, `stride` floats apart; wanted: n rows of GAIN_N. A gain
 * without a grid is 0. */
void gain_table_eval_many(const gain_table_t *t, const ks_table_t *axes, const void *values,
                          const float *y, float *wanted, uint32_t n, uint32_t stride);

#ifdef __cplusplus
}
#endif

#endif
