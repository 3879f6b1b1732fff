/* Lost lock: a drive that asks for all its current and stands, and the pole that it tries after it. */
#include <string.h>

#include "checks.h"
#include "params.h"

/* A drive stalls that asks for i_stall either way without speed, n_stall times in a row; without that
 * current and with speed it turns its shaft. */
static void stalls(void) {
    lock_params_t p = PARAMS[4].lock;
    p.n_stall = 5;
    const struct {
        float size, omega; /* over i_stall, over slow */
        int stalls, turns;
    } cases[] = {{1.01f, 0.99f, 1, 0},   {0.99f, 0.99f, 0, 0},  {-1.01f, 0.0f, 1, 0},
                 {-1.01f, -0.99f, 1, 0}, {1.01f, -1.01f, 0, 1}, {1.01f, 1.01f, 0, 1},
                 {0.0f, -1.01f, 0, 1}};
    for (unsigned j = 0; j < sizeof cases / sizeof cases[0]; j++) {
        lock_state_t x;
        memset(&x, 0, sizeof x);
        for (int k = 1; k < 9; k++) {
            x.omega = cases[j].omega * p.slow;
            lock_stall(&p, &x, cases[j].size * p.i_stall);
            check("stall", x.stalled == cases[j].stalls * (k < 5 ? k : 5));
            check("stall: turned", x.turned == cases[j].turns * (k < 5 ? k : 5));
        }
        lock_judge(&p, &x, 0.0f, 1e9f);
        check("stall: told", x.bad == cases[j].stalls);
        x.reason = 0, x.bad = p.n_alarm;
        lock_judge(&p, &x, 0.0f, 1e9f);
        check("stall: reason", x.reason == (cases[j].stalls ? LOCK_STALL : 0));
        x.omega = 0.0f;
        lock_stall(&p, &x, 0.0f);
        check("stall: over", x.stalled == 0 && x.turned == 5 * cases[j].turns);
        x.stalled = x.turned = -1; /* damage */
        lock_stall(&p, &x, 2.0f * p.i_stall);
        check("stall: damaged", x.stalled == p.n_stall);
        x.omega = 2.0f * p.slow;
        lock_stall(&p, &x, 0.0f);
        check("turned: damaged", x.turned == p.n_stall);
        lock_begin(&p, &x, 0.0f);
        check("stall: anew", x.stalled == 0 && x.turned == p.n_stall);
    }
}

/* What a drive does after it: the current and the pole are its own. */
static void stalled_drive(void) {
    drive_params_t p = PARAMS[4];
    for (int j = 0; j < 12; j++) {
        drive_state_t x;
        drive_init(&p, &x, 0.0f, 0.0f, 0.5f);
        check("stall: begun", x.lock.stalled == 0 && x.lock.turned == 0);
        x.control.i_ref.q = 1.01f * p.lock.i_stall;
        drive_judge(&p, &x);
        check("stall: of the drive", x.lock.stalled == 1);
        int told = j % 2, turned = j / 2 % 2, coupled = j / 4 == 0;
        x.lock.stalled = p.lock.n_stall - !told, x.lock.turned = p.lock.n_stall - !turned;
        x.lock.restarts = 0, x.start.again = 1;
        p.lock.action = LOCK_RESTART, p.estimator = coupled ? ESTIMATE_COUPLED : ESTIMATE_SMO;
        drive_act(&p, &x);
        int other = told ? !turned : coupled;
        check("stall: pole", x.start.again == (other ? START_OTHER_POLE : START_SAME_POLE));
        check("stall: known", x.lock.turned == (told && turned ? p.lock.n_stall : 0));
        check("stall: counted", x.lock.restarts == 1);
    }
}

void check_stall(void) {
    stalls();
    stalled_drive();
}
