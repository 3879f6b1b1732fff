/* Threads that fetch one piece after another. */
#include "workers.h"

#if defined(__SSE__)
#include <xmmintrin.h>
#define FP_DEFAULT 0x1f80U /* MXCSR: exceptions masked, round to nearest, denormals kept */
#endif

typedef struct {
    work_t work;
    void *job;
    int32_t pieces;
    int32_t next; /* first piece that no thread has begun; atomic */
} share_t;

#if defined(__GNUC__) && (defined(__unix__) || defined(__APPLE__))
#define HAVE_THREADS
#define FETCH_NEXT(x) __atomic_fetch_add(&(x)->next, 1, __ATOMIC_RELAXED)
#else
#define FETCH_NEXT(x) ((x)->next++)
#endif

static void work_on(share_t *share) {
#ifdef FP_DEFAULT
    unsigned int was = _mm_getcsr();
    _mm_setcsr(FP_DEFAULT);
#endif
    for (int32_t i = FETCH_NEXT(share); i < share->pieces; i = FETCH_NEXT(share)) {
        share->work(share->job, i);
    }
#ifdef FP_DEFAULT
    _mm_setcsr(was);
#endif
}

#ifdef HAVE_THREADS

#include <pthread.h>

#define MOST_THREADS 256 /* the caller's included */

static void *helper(void *share) {
    work_on(share);
    return 0;
}

void workers_run(work_t work, void *job, int32_t pieces, int32_t threads) {
    share_t share = {work, job, pieces, 0};
    pthread_t started[MOST_THREADS - 1];
    int32_t wanted = (threads < pieces ? threads : pieces) - 1;
    int32_t n = 0;
    while (n < wanted && n < MOST_THREADS - 1 &&
           pthread_create(&started[n], 0, helper, &share) == 0) {
        n++;
    }
    work_on(&share);
    while (n > 0) {
        n--;
        pthread_join(started[n], 0);
    }
}

#else

void workers_run(work_t work, void *job, int32_t pieces, int32_t threads) {
    (void)threads;
    share_t share = {work, job, pieces, 0};
    work_on(&share);
}

#endif
