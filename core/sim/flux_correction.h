/* What a flux map has beyond its closed form, as an energy of its own.
 *
 * The energy over 3/2 is a sum of cubic splines on an even grid of the flux linkages,
 *   W = sum c_jm B(x - j) B(y - m),  x = (psi_d - psi_d0) / h_d,  y = |psi_q| / h_q,
 * with currents i_d = dW/dpsi_d, i_q = dW/dpsi_q: di_d/dpsi_q = di_q/dpsi_d whatever the numbers.
 * Splines that reach below y = 0 have mirror images, so that W is even in psi_q. Towards the other
 * edges of the grid W, its currents and their slopes go to zero; there is nothing beyond.
 *
 * Drives with one map share one record, which flux_map_t names by its key, a hash of the numbers:
 * a drive stays plain data, and its copy in another process means the same map or none.
 */
#ifndef SENSORLESS_FLUX_CORRECTION_H
#define SENSORLESS_FLUX_CORRECTION_H

#include <stdint.h>

#define CORRECTION_D 32 /* most rows of coefficients */
#define CORRECTION_Q 24 /* most of them a row */

typedef struct {
    double d;
    double q;
} dq64_t;

typedef struct {
    double psi_d0;                        /* first edge of the grid [Vs] */
    double inv_h_d, inv_h_q;              /* 1 / width of a cell [1/Vs] */
    double c[CORRECTION_D][CORRECTION_Q]; /* of cell (j, m): rows j ... j + 3, m ... m + 3 [Vs A] */
    int32_t n_d, n_q;                     /* cells */
    uint32_t key;                         /* not 0 */
    int32_t reserved;
} flux_correction_t;

/* Enters a record, which must not move from then on. Returns 0 if another one is in its
 * place. */
int32_t flux_correction_enter(const flux_correction_t *p);

/* Currents [A] at flux linkages psi [Vs] of the record with this key; without it, not numbers. */
dq64_t flux_correction_of(uint32_t key, dq64_t psi);

/* Currents [A] of a record that need not be entered, at n flux linkages (psi[2 j], psi[2 j + 1])
 * [Vs]. */
void flux_correction_currents(const flux_correction_t *p, const double *psi, double *i, int32_t n);

#endif
