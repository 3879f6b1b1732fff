/* The records of all corrections in this process. */
#include "flux_correction.h"

#include "drive/compiler.h"

#define PLACES 65536U /* of records; a key's is its remainder */

/* Entered once, they stay. */
static const flux_correction_t *entered[PLACES];

int32_t flux_correction_enter(const flux_correction_t *p) {
    const flux_correction_t **place = &entered[p->key % PLACES];
    if (*place == 0) {
        *place = p;
    }
    return (*place)->key == p->key;
}

/* The four splines of a cell and their slopes over its width, t from 0 to 1. */
typedef struct {
    double b[4];
    double slope[4];
} splines_t;

static splines_t splines_at(double t) {
    double r = 1.0 - t;
    double t2 = t * t;
    double r2 = r * r;
    splines_t y = {
        {r2 * r * (1.0 / 6.0), 2.0 / 3.0 - t2 * (1.0 - 0.5 * t), 2.0 / 3.0 - r2 * (1.0 - 0.5 * r),
         t2 * t * (1.0 / 6.0)},
        {-0.5 * r2, t * (1.5 * t - 2.0), r * (2.0 - 1.5 * r), 0.5 * t2},
    };
    return y;
}

/* Cell of a place x on n cells; *t: where in it. */
static int32_t cell_at(double x, int32_t n, double *t) {
    double last = (double)n;
    double y = x > 0.0 ? x : 0.0; /* also of NaN */
    y = y < last ? y : last;
    int32_t j = (int32_t)y;
    j = j < n ? j : n - 1;
    *t = y - (double)j;
    return j;
}

static dq64_t current_at(const flux_correction_t *p, dq64_t psi) {
    double t_d, t_q;
    double q = psi.q < 0.0 ? -psi.q : psi.q;
    int32_t j = cell_at((psi.d - p->psi_d0) * p->inv_h_d, p->n_d, &t_d);
    int32_t m = cell_at(q * p->inv_h_q, p->n_q, &t_q);
    splines_t d = splines_at(t_d);
    splines_t s = splines_at(t_q);
    dq64_t i = {0.0, 0.0};
    for (int k = 0; k < 4; k++) {
        const double *c = &p->c[j + k][m];
        i.d += d.slope[k] * (c[0] * s.b[0] + c[1] * s.b[1] + c[2] * s.b[2] + c[3] * s.b[3]);
        i.q += d.b[k] *
               (c[0] * s.slope[0] + c[1] * s.slope[1] + c[2] * s.slope[2] + c[3] * s.slope[3]);
    }
    i.d *= p->inv_h_d;
    i.q *= psi.q < 0.0 ? -p->inv_h_q : p->inv_h_q;
    return i;
}

dq64_t flux_correction_of(uint32_t key, dq64_t psi) {
    const flux_correction_t *p = entered[key % PLACES];
    dq64_t none = {__builtin_nan(""), __builtin_nan("")};
    return p != 0 && p->key == key ? current_at(p, psi) : none;
}

void flux_correction_currents(const flux_correction_t *p, const double *psi, double *i, int32_t n) {
    for (int32_t j = 0; j < n; j++) {
        dq64_t at = {psi[2 * j], psi[2 * j + 1]};
        dq64_t y = current_at(p, at);
        i[2 * j] = y.d;
        i[2 * j + 1] = y.q;
    }
}
