/* Layout of a k_s table; ks_table.h has what it means and what works on it. */
#ifndef SENSORLESS_KS_TYPES_H
#define SENSORLESS_KS_TYPES_H

#include <stdint.h>

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

#endif
