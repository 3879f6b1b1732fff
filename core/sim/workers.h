/* Independent pieces of work over several threads. */
#ifndef SENSORLESS_WORKERS_H
#define SENSORLESS_WORKERS_H

#include <stdint.h>

typedef void (*work_t)(void *job, int32_t piece);

/* Calls work(job, i) once for every i < pieces, on up to `threads` threads including the caller's,
 * and returns when all are done. Threads exist only during the call, so that a process may fork at
 * any time; if they cannot be started, the caller does their share. Every thread computes with the
 * processor's default rounding and with denormal numbers, whatever the process has set. */
void workers_run(work_t work, void *job, int32_t pieces, int32_t threads);

#endif
