/* Switching pattern of one period, and the machine from edge to edge. */
#include "carrier.h"

#define LEGS 3
#define SHORTEST 1.0e-12 /* edges closer than this count as one [s] */
#define FLUX_STEP 1.0e-6 /* step for the slope of the flux map [Vs] */
#define NO_CURRENT 1e-9  /* currents below this count as zero [A] */
#define ROUNDS 4         /* trials of a piece in which a current reaches zero */
#define SWEEPS 40        /* passes over the legs whose switches are off, each round */

typedef struct {
    double a;
    double b;
} ab64_t;

/* Directions of the three phases in the stator frame. */
static const ab64_t PHASE[LEGS] = {
    {1.0, 0.0}, {-0.5, 0.86602540378443865}, {-0.5, -0.86602540378443865}};

/* A stretch of the period in which no leg changes. */
typedef struct {
    double h;           /* length [s] */
    int32_t high[LEGS]; /* upper switch on, unless off */
    int32_t off[LEGS];  /* both switches off */
} piece_t;

/* Half the DC link, and the threshold voltages of transistors and diodes [V]. */
typedef struct {
    double half, transistor, diode;
} rails_t;

/* Where the rows of carrier_run go; row is NULL if none are wanted. */
typedef struct {
    double *row;
    double t;
} rows_t;

static double clamp_d(double x, double lo, double hi) {
    double y = x > lo ? x : lo;
    return y < hi ? y : hi;
}

static ab64_t legs_to_ab(const double *v) {
    ab64_t u = {0.0, 0.0};
    for (int j = 0; j < LEGS; j++) {
        u.a += 2.0 / 3.0 * PHASE[j].a * v[j];
        u.b += 2.0 / 3.0 * PHASE[j].b * v[j];
    }
    return u;
}

static ab64_t stator_current(const plant_state_t *x) {
    ab64_t i = {x->cos_e * x->i_d - x->sin_e * x->i_q, x->sin_e * x->i_d + x->cos_e * x->i_q};
    return i;
}

static double along(ab64_t x, int leg) { return PHASE[leg].a * x.a + PHASE[leg].b * x.b; }

/* Adds an instant to a sorted list if it is inside the period. */
static int edge_insert(double *edge, int n, double t, double period) {
    if (!(t > 0.0 && t < period)) {
        return n;
    }
    int j = n;
    for (; j > 0 && edge[j - 1] > t; j--) {
        edge[j] = edge[j - 1];
    }
    edge[j] = t;
    return n + 1;
}

/* The pieces of a period under the command u, in order; returns their number. */
static int pattern(const sensor_params_t *p, ab_t u, float u_dc, double period, piece_t *out) {
    legs_t leg = inverter_legs(u);
    double want[LEGS] = {(double)leg.a, (double)leg.b, (double)leg.c};
    double half_dead = 0.5 * (double)p->dead_time_share * period;
    double half_on[LEGS]; /* half the time a leg is high [s] */
    double edge[4 * LEGS + 1];
    int n = 0;
    for (int j = 0; j < LEGS; j++) {
        double d = u_dc > 0.0f ? clamp_d(0.5 + want[j] / (double)u_dc, 0.0, 1.0) : 0.5;
        half_on[j] = 0.5 * period * d;
        for (int side = -1; side <= 1 && d > 0.0 && d < 1.0; side += 2) {
            double early = (half_on[j] - half_dead) * side;
            double late = (half_on[j] + half_dead) * side;
            n = edge_insert(edge, n, 0.5 * period + early, period);
            n = edge_insert(edge, n, 0.5 * period + late, period);
        }
    }
    edge[n] = period;
    double t = 0.0;
    int pieces = 0;
    for (int k = 0; k <= n; k++) {
        if (edge[k] - t < SHORTEST) {
            continue;
        }
        piece_t *y = &out[pieces];
        double from_middle = 0.5 * (t + edge[k]) - 0.5 * period;
        from_middle = from_middle < 0.0 ? -from_middle : from_middle;
        y->h = edge[k] - t;
        for (int j = 0; j < LEGS; j++) {
            double inside = half_on[j] - from_middle;
            int switches = half_on[j] > 0.0 && half_on[j] < 0.5 * period;
            y->high[j] = inside > 0.0;
            y->off[j] = switches && inside < half_dead && -inside < half_dead;
        }
        t = edge[k];
        pieces += 1;
    }
    return pieces;
}

/* Whether the diodes of all legs that are off can carry the currents i at these leg voltages: each
 * leg is at the rail to which its current takes it, or without current. */
static int diodes_carry(const piece_t *c, const double *v, double half, ab64_t i) {
    int ok = 1;
    for (int j = 0; j < LEGS; j++) {
        double i_leg = along(i, j);
        int none = i_leg < NO_CURRENT && i_leg > -NO_CURRENT;
        int at_rail = i_leg > 0.0 ? v[j] <= -half : v[j] >= half;
        ok &= c->off[j] == 0 || none || at_rail;
    }
    return ok;
}

/* Currents at the state x with its flux linkages changed by d and q [A]. */
static dq64_t current_at(const plant_params_t *m, const plant_state_t *x, double d, double q) {
    dq64_t psi = {x->psi_d + d, x->psi_q + q};
    return plant_response(m, psi, x->cos_e, x->sin_e, m->extra, m->detail).i;
}

/* Voltages of the legs that are off, from a trial v that ends the piece with the currents i. A leg
 * is at the lower rail if its current ends positive, at the upper rail if it ends negative, and
 * between them if that ends it at zero: the stationary point of a convex quadratic form with
 * bounds, found leg by leg from the slope of the flux map at x. */
static void diodes_settle(const plant_params_t *m, const plant_state_t *x, const piece_t *c,
                          double half, ab64_t i, double *v) {
    dq64_t at = current_at(m, x, 0.0, 0.0);
    dq64_t i_d = current_at(m, x, FLUX_STEP, 0.0);
    dq64_t i_q = current_at(m, x, 0.0, FLUX_STEP);
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        for (int j = 0; j < LEGS; j++) {
            if (c->off[j] == 0) {
                continue;
            }
            double n_d = x->cos_e * PHASE[j].a + x->sin_e * PHASE[j].b;
            double n_q = x->cos_e * PHASE[j].b - x->sin_e * PHASE[j].a;
            double w = 2.0 / 3.0 * c->h / FLUX_STEP; /* current per volt of this leg: (g_d, g_q) */
            double g_d = w * (n_d * (i_d.d - at.d) + n_q * (i_q.d - at.d));
            double g_q = w * (n_d * (i_d.q - at.q) + n_q * (i_q.q - at.q));
            double to = clamp_d(v[j] - along(i, j) / (n_d * g_d + n_q * g_q), -half, half);
            double change = to - v[j];
            i.a += change * (x->cos_e * g_d - x->sin_e * g_q);
            i.b += change * (x->sin_e * g_d + x->cos_e * g_q);
            v[j] = to;
        }
    }
}

static void row_write(rows_t *rows, const plant_state_t *x, ab64_t u) {
    double *row = rows->row;
    row[CARRIER_T] = rows->t;
    row[CARRIER_U_ALPHA] = u.a;
    row[CARRIER_U_BETA] = u.b;
    row[CARRIER_I_D] = x->i_d;
    row[CARRIER_I_Q] = x->i_q;
    row[CARRIER_PSI_D] = x->psi_d;
    row[CARRIER_PSI_Q] = x->psi_q;
    row[CARRIER_TAU] = x->tau;
    row[CARRIER_OMEGA_M] = x->omega_m;
    row[CARRIER_THETA_E] = x->theta_e + (double)x->turns * (2.0 * PI_D);
    rows->row += CARRIER_N;
}

static void piece_advance(const plant_params_t *m, plant_state_t *x, const piece_t *c,
                          const rails_t *rail, double tau_load, rows_t *rows) {
    double v[LEGS];
    ab64_t i = stator_current(x);
    double half = rail->half + rail->diode; /* voltage at which a diode holds a leg */
    int any_off = 0;                        /* whether leg voltages are not settled */
    for (int j = 0; j < LEGS; j++) {
        double i_leg = along(i, j);
        if (c->off[j] != 0) {
            v[j] = i_leg < 0.0 ? half : -half;
        } else {
            /* voltage drops of a current out of the leg, and into it */
            double out = c->high[j] != 0 ? rail->transistor : rail->diode;
            double in = c->high[j] != 0 ? rail->diode : rail->transistor;
            v[j] = c->high[j] != 0 ? rail->half : -rail->half;
            v[j] += i_leg > 0.0 ? -out : (i_leg < 0.0 ? in : 0.0);
        }
        any_off |= c->off[j];
    }
    for (int round = 0; round < ROUNDS && any_off != 0; round++) {
        plant_state_t trial = *x;
        ab64_t u = legs_to_ab(v);
        plant_move(m, &trial, u.a, u.b, tau_load, c->h, 1, m->extra, m->detail);
        ab64_t end = stator_current(&trial);
        any_off = !diodes_carry(c, v, half, end);
        if (any_off != 0) {
            diodes_settle(m, x, c, half, end, v);
        }
    }
    ab64_t u = legs_to_ab(v);
    double h = c->h / m->n_sub;
    for (int j = 0; j < m->n_sub; j++) {
        if (rows->row) {
            row_write(rows, x, u);
        }
        plant_move(m, x, u.a, u.b, tau_load, h, 1, m->extra, m->detail);
        rows->t += h;
    }
}

static void period_advance(const sensor_params_t *p, const plant_params_t *m, plant_state_t *x,
                           ab_t u, float u_dc, double tau_load, rows_t *rows) {
    piece_t piece[PIECES_A_PERIOD];
    double period = m->h * m->n_sub;
    int n = pattern(p, u, u_dc, period, piece);
    rails_t rail = {0.5 * (double)u_dc, 0.0, 0.0};
    dq64_t psi_ab = plant_flux_ab(x);
    if (m->detail != 0) { /* diodes carry the current of the flux, which does not jump */
        rail.transistor = (double)p->u_on + 0.5 * (double)p->u_skew;
        rail.diode = (double)p->u_on - 0.5 * (double)p->u_skew;
        plant_output(m, x, m->extra, 1);
    }
    for (int k = 0; k < n; k++) {
        piece_advance(m, x, &piece[k], &rail, tau_load, rows);
    }
    if (m->detail != 0) {
        plant_add_iron(m, x, psi_ab, period);
    }
}

void carrier_advance(const sensor_params_t *p, const plant_params_t *m, plant_state_t *x, ab_t u,
                     float u_dc, double tau_load) {
    rows_t none = {0};
    period_advance(p, m, x, u, u_dc, tau_load, &none);
}

int32_t carrier_run(const sensor_params_t *p, const plant_params_t *m, plant_state_t *x,
                    const double *u, double *out, int32_t n) {
    rows_t rows = {out, 0.0};
    ab64_t zero = {0.0, 0.0};
    for (int32_t j = 0; j < n; j++) {
        ab_t command = {(float)u[4 * j], (float)u[4 * j + 1]};
        period_advance(p, m, x, command, (float)u[4 * j + 2], u[4 * j + 3], &rows);
    }
    row_write(&rows, x, zero);
    return (int32_t)((rows.row - out) / CARRIER_N);
}
