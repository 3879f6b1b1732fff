/* The schedule as a table: k_s over up to four signals, multilinear, clipped at the edges.
 *
 * Axes are evenly spaced, so a lookup needs no division and no search. The image (ks_table_t and its
 * node values) is checked by ks_table_check before use; what fails the check is never used: the
 * built-in linear rule (doi 10.12177/emca.2025.011, Eq. 25) takes over and a fault is reported.
 * No 8-bit types: some targets do not have them. The CRC runs over 16-bit words.
 */
#ifndef SENSORLESS_KS_TABLE_H
#define SENSORLESS_KS_TABLE_H

#include <stdint.h>

#include "frames.h"

#define KS_TABLE_MAGIC 0x4B535442UL /* "KSTB" */
#define KS_TABLE_FORMAT 1UL
#define KS_TABLE_AXES 4       /* most axes a table can have */
#define KS_TABLE_NODES 1024   /* most nodes a table can have: 4 KiB */

#define KS_FORMAT_F32 0UL /* values: float, 0 ... 1 */
#define KS_FORMAT_Q15 1UL /* values: int16, 0 ... 0x7FFF; 0x7FFF is exactly 1 */

/* What ks_table_check found. */
#define KS_OK 0
#define KS_BAD_MAGIC 1
#define KS_BAD_FORMAT 2
#define KS_BAD_AXES 3
#define KS_BAD_VALUE 4
#define KS_BAD_CRC 5
#define KS_BAD_MOTOR 6

typedef struct {
    uint32_t signal;  /* SIGNAL_* this axis reads */
    uint32_t n;       /* nodes, at least 2 */
    float x0;         /* signal value of the first node */
    float inv_step;   /* nodes per unit of the signal */
} ks_axis_t;

/* Header of a table; the node values follow it in an array of their own, last axis fastest. */
typedef struct {
    uint32_t magic;
    uint32_t format;
    uint32_t value_format;  /* KS_FORMAT_* */
    uint32_t n_axes;
    uint32_t n_nodes;       /* product of the axes' n */
    ks_axis_t axis[KS_TABLE_AXES]; /* unused axes: all zero but n = 1 */
    float slew_per_s;       /* largest change of k_s per second */
    float fallback;         /* k_s for an input that is not finite */
    float rule_x_min;       /* built-in rule: k_s = 1 up to this speed signal, */
    float rule_x_max;       /*   0 from this one on */
    uint32_t policy_hash;   /* first 32 bits of the policy's SHA-256 */
    uint32_t motor_hash;    /* first 32 bits of the motor's SHA-256 */
    uint32_t crc;           /* over the header without this word, then the node values */
} ks_table_t;

/* Checks magic, format, axes, values and CRC, and the motor's hash (0 accepts any motor). Returns
 * KS_OK or the first KS_BAD_*. values: float or int16 node values, as value_format says. */
int ks_table_check(const ks_table_t *t, const void *values, uint32_t motor_hash);

/* CRC-32 (polynomial 0x04C11DB7 reflected, as in Ethernet and zlib) continued over one 16-bit word,
 * low byte first. Start with 0xFFFFFFFF, invert the end result. */
uint32_t ks_crc32_word(uint32_t crc, uint32_t word);

/* The CRC that belongs into t->crc: over the header's words in order without crc, then the node
 * values; of every 32-bit word the low half first. */
uint32_t ks_table_crc(const ks_table_t *t, const void *values);

/* k_s at the signals y[SIGNAL_N]; the table must have passed ks_table_check. */
float ks_table_eval(const ks_table_t *t, const void *values, const float *y);

/* The built-in rule on the speed signal: 1 below x_min, 0 above x_max, a line between. */
CORE_INLINE float ks_rule(float speed, float x_min, float x_max) {
    float k_s = (x_max - speed) / max_f(x_max - x_min, 1.0e-6f);
    return speed == speed ? clamp_f(k_s, 0.0f, 1.0f) : 1.0f;
}

/* k_s for n rows of signals. */
void ks_table_eval_many(const ks_table_t *t, const void *values, const float *y, float *k_s,
                        uint32_t n, uint32_t stride);

#endif
