/* The schedule as a table: k_s over up to four signals, multilinear, clipped at the edges.
 *
 * Axes are evenly spaced, so a lookup needs no division and no search. A table is a header
 * (ks_table_t) and an array of node values; ks_table_check must accept both before either is used.
 * The header has its own CRC and is checked first: sizes are used only after that, so that a
 * damaged table never leads to a read beyond its values. ks_schedule.h says what replaces a refused
 * table. There are no 8-bit types, which some targets do not have; CRCs run over 16-bit words.
 */
#ifndef SENSORLESS_KS_TABLE_H
#define SENSORLESS_KS_TABLE_H

#include <stdint.h>

#include "frames.h"

#define KS_TABLE_MAGIC 0x4B535442UL /* "KSTB" */
#define KS_TABLE_FORMAT 1UL

enum {
    KS_TABLE_AXES = 4,     /* most axes a table can have */
    KS_TABLE_NODES = 1024, /* most nodes a table can have: 4 KiB */
    KS_KIND_Q15 = 0x100    /* in ks_table_t.kind: 16-bit values */
};

/* Kind of the node values. */
#define KS_VALUES_F32 0x46333220UL /* "F32 ": float, 0 ... 1 */
#define KS_VALUES_Q15 0x51313520UL /* "Q15 ": int16, 0 ... 0x7FFF; 0x7FFF is exactly 1 */

/* Results of ks_table_check. */
enum {
    KS_OK = 0,
    KS_BAD_MAGIC,  /* not a table */
    KS_BAD_FORMAT, /* a table of another version, or an unknown kind of values */
    KS_BAD_CRC,    /* header or values are not what was exported */
    KS_BAD_AXES,   /* number, signal, size or spacing of an axis */
    KS_BAD_VALUE,  /* node, fallback or slew limit not finite or out of range */
    KS_BAD_MOTOR   /* made for another machine */
};

typedef struct {
    uint32_t signal; /* SIGNAL_* that this axis reads */
    uint32_t n;      /* nodes, at least 2 */
    float x0;        /* signal value of the first node */
    float inv_step;  /* nodes per unit of the signal */
    float top;       /* n - 1 */
} ks_axis_t;

/* Header of a table; node values are in a separate array, last axis fastest. */
typedef struct {
    uint32_t magic;                /* KS_TABLE_MAGIC */
    uint32_t format;               /* KS_TABLE_FORMAT */
    uint32_t value_format;         /* KS_VALUES_* */
    uint32_t n_axes;               /* axes in use */
    uint32_t n_nodes;              /* product of the axes' n */
    uint32_t kind;                 /* n_axes, plus KS_KIND_Q15 for Q15: selects the lookup */
    ks_axis_t axis[KS_TABLE_AXES]; /* unused axes are all zero */
    float slew_per_s;              /* largest change of k_s per second [1/s] */
    float fallback;                /* k_s for a signal that is not finite */
    uint32_t policy_hash;          /* first 32 bits of the policy's SHA-256 */
    uint32_t motor_hash;           /* first 32 bits of the motor's SHA-256 */
    uint32_t crc_values;           /* over the node values */
    uint32_t crc_header;           /* over all words above */
} ks_table_t;

#ifdef __cplusplus
extern "C" {
#endif

/* CRC-32 (polynomial 0x04C11DB7 reflected, as in Ethernet and zlib) continued over one 16-bit word,
 * low byte first. Start with 0xFFFFFFFF and invert the final result. */
uint32_t ks_crc32_word(uint32_t crc, uint32_t word);

/* The CRC that belongs in t->crc_header; the low half of every 32-bit word comes first. */
uint32_t ks_header_crc(const ks_table_t *t);

/* The CRC that belongs in t->crc_values. */
uint32_t ks_values_crc(const ks_table_t *t, const void *values);

/* Checks magic, formats, header CRC, axes, value CRC, ranges and the motor's hash (0 accepts any
 * motor). Returns KS_OK or the first KS_BAD_*. values: float or int16, as t->value_format says. */
int ks_table_check(const ks_table_t *t, const void *values, uint32_t motor_hash);

/* k_s at the signals y[SIGNAL_N]; the table must have passed ks_table_check. */
float ks_table_eval(const ks_table_t *t, const void *values, const float *y);

/* k_s for n rows of signals, `stride` floats apart. */
void ks_table_eval_many(const ks_table_t *t, const void *values, const float *y, float *k_s,
                        uint32_t n, uint32_t stride);

#ifdef __cplusplus
}
#endif

#endif
