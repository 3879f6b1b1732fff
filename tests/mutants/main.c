/* Runs the checks. Status 0: all good and the trajectory's sum is the one given; 1: a check failed;
 * 2: only the sum differs. */
#include <stdlib.h>
#include <string.h>

#include "checks.h"

int checks_failed = 0;

void check(const char *what, int good) {
    static const char *told[200];
    if (good) {
        return;
    }
    for (int j = 0; j < checks_failed && j < 200; j++) {
        if (strcmp(told[j], what) == 0) {
            return;
        }
    }
    told[checks_failed < 200 ? checks_failed : 199] = what;
    checks_failed++;
    printf("%s\n", what);
}

static uint32_t seed;

double draw(double lo, double hi) {
    seed = seed * 1664525U + 1013904223U;
    uint32_t x = seed ^ (seed >> 15);
    return lo + (hi - lo) * (double)(x >> 4) / 268435456.0;
}

float draw_f(double lo, double hi) { return (float)draw(lo, hi); }

int main(int argc, char **argv) {
    void (*const all[])(void) = {check_math,    check_estimators, check_coupled, check_control,
                                 check_start,   check_table,      check_drive,   check_lock,
                                 check_restart, check_match,      check_seek,    check_guard,
                                 check_state,   check_stall};
    for (unsigned j = 0; j < sizeof all / sizeof all[0]; j++) {
        seed = 12345U + j;
        all[j]();
    }
    seed = 77U;
    uint32_t sum = trajectory();
    printf("sum %08lx\n", (unsigned long)sum);
    int same = argc > 1 && strtoul(argv[1], NULL, 16) == sum;
    return checks_failed > 0 ? 1 : (same ? 0 : 2);
}
