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
#include "ks_types.h"

/* Results of ks_table_check. */
enum {
    KS_OK = 0,
    KS_BAD_MAGIC,  /* not a table */
    KS_BAD_FORMAT, /* a table of another version, or an unknown kind of values */
    KS_BAD_CRC,    /* header or values are not what was exported */
    KS_BAD_AXES,   /* number, signal, size or spacing of an axis */
    KS_BAD_VALUE,  /* node, fallback or slew limit not finite or out of range */
    KS_BAD_MOTOR,  /* made for another machine */
    KS_GOOD = 16   /* only in a state, where 0 means that its init has not run: KS_OK */
};

#ifdef __cplusplus
extern "C" {
#endif

/* CRC-32 (polynomial 0x04C11DB7 reflected, as in Ethernet and zlib) continued over one 16-bit word,
 * low byte first. Start with 0xFFFFFFFF and invert the final result. */
uint32_t ks_crc32_word(uint32_t crc, uint32_t word);

/* The same with a word of 32 bits, its lower half first. */
CORE_INLINE uint32_t ks_crc32_u32(uint32_t crc, uint32_t x) {
    return ks_crc32_word(ks_crc32_word(crc, x), x >> 16);
}

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
