/* What the page calls besides the core's own functions. */
#include "drive/ks_table.h"
#include "sim/trace.h"

/* One decision and the periods up to the next: the table chooses the weight, the drive runs under
 * it. Writes TRACE_N numbers per period to rows; returns the number of periods. */
int32_t page_decide(sim_t *s, const ks_table_t *table, const void *values, int32_t periods,
                    double *rows);

int32_t page_decide(sim_t *s, const ks_table_t *table, const void *values, int32_t periods,
                    double *rows) {
    float signals[SIGNAL_N];
    sim_signals(s, 1, signals);
    return sim_trace(s, periods, ks_table_eval(table, values, signals), rows);
}
