/* What the page calls besides the core's own functions. */
#include "drive/ks_table.h"
#include "sim/trace.h"

/* A curve of the page: one column of a trace, or the length of the vector of two, in its unit. */
typedef struct {
    int32_t column;
    int32_t other; /* second column of the vector, -1: none */
    double scale;
} plotted_t;

/* One decision and the periods up to the next: the table chooses the weight, the drive runs under
 * it. Writes TRACE_N numbers per period to rows; returns the number of periods. */
int32_t page_decide(sim_t *s, const ks_table_t *table, const void *values, int32_t periods,
                    double *rows);

/* Least and largest value of n curves over so many rows of a trace. */
void page_range(const double *rows, int32_t periods, const plotted_t *curves, int32_t n,
                float *least, float *most);

int32_t page_decide(sim_t *s, const ks_table_t *table, const void *values, int32_t periods,
                    double *rows) {
    float signals[SIGNAL_N];
    sim_signals(s, 1, signals);
    return sim_trace(s, periods, ks_table_eval(table, values, signals), rows);
}

void page_range(const double *rows, int32_t periods, const plotted_t *curves, int32_t n,
                float *least, float *most) {
    for (int32_t c = 0; c < n; c++) {
        const plotted_t curve = curves[c];
        double low = 1e300, high = -1e300;
        for (int32_t j = 0; j < periods; j++) {
            const double *row = &rows[(long)j * TRACE_N];
            const double a = row[curve.column];
            const double b = curve.other < 0 ? 0.0 : row[curve.other];
            const double x = curve.scale * (curve.other < 0 ? a : __builtin_sqrt(a * a + b * b));
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        least[c] = (float)low;
        most[c] = (float)high;
    }
}
