#ifndef KD_JOBS_POOL_H
#define KD_JOBS_POOL_H

/* What the files of the pool share. One idea a file:
 *   deque.h          a worker's own jobs, stolen from the other end
 *   queue.h          jobs under a mutex: the GPU lane's, those that go first, those of foreign threads
 *   submit.c         into which of them a job goes
 *   worker.c         finding jobs and running them
 *   counter.c        unfinished jobs, and jobs that wait for others
 *   wait.c sleep.c   what a thread does that has nothing to do
 *   parallel_for.c   loops
 *   pool.c           making and destroying
 *   graph.c          graphs, on top of all this */

#include <pthread.h>
#include <stdalign.h>

#include "runtime/jobs/deque.h"
#include "runtime/jobs/queue.h"

enum { JOBS_MAX_WORKERS = 64 };
#define JOBS_HAS_AFTER 0x80000000u /* in a counter's pending: jobs wait for it */

/* A job that waits for a counter. */
typedef struct kd_job_after {
    job waiting;
    struct kd_job_after *next;
} job_after;

typedef struct jobs_after_block jobs_after_block;

typedef struct job_worker {
    job_deque deque;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t signal;
    bool signaled; /* under lock */
    kd_jobs *jobs;
    uint32_t index;
    uint32_t victim; /* where to steal next */
    uint32_t label;  /* of the loops that it starts */
    uint32_t stolen; /* jobs; how it goes with them: see worker.c */
    uint64_t stretch_ns, idle_ns, rest_ns, rest_until_ns;
    /* A lone job is stolen only when it is seen twice at the same place: its owner is most likely about to
     * run it, and a chain of jobs would wander between caches otherwise. */
    int64_t seen_top[JOBS_MAX_WORKERS];
} job_worker;

struct kd_jobs {
    alignas(128) _Atomic uint64_t parked; /* bit i: worker i sleeps, or is about to */
    _Atomic uint64_t waiting;             /* bit i: and does so for a counter */
    _Atomic bool stop;
    kd_job_counter alive;      /* workers that have not left yet, without worker 0 */
    uint32_t threads, started; /* fewer started only when making the pool failed */
    bool inside;               /* single thread: a job is running */
    kd_jobs_hooks hooks;       /* set while no job runs */

    const void *owner; /* the thread that is worker 0, by its thread-local record */
    bool lane_busy;    /* worker 0 alone: a lane job is running */
    job_queue lane, first, inbox;

    alignas(128) pthread_mutex_t after_lock; /* guards the lists at all counters */
    job_after *after_free;
    jobs_after_block *after_blocks;

    pthread_mutex_t outside_lock;
    pthread_cond_t outside_signal;
    _Atomic uint32_t outside_waiting; /* foreign threads that wait for a counter */

    job_worker workers[];
};

/* ---- the calling thread ---- */
typedef struct jobs_thread_record {
    const kd_jobs *jobs;
    uint32_t worker;
} jobs_thread_record;
extern _Thread_local jobs_thread_record jobs_thread;

static inline bool jobs_is_worker(const kd_jobs *jobs)
{
    return jobs_thread.jobs == jobs || jobs->owner == &jobs_thread;
}

/* No other thread runs jobs and none is running: submitting means doing. */
static inline bool jobs_runs_inline(const kd_jobs *jobs)
{
    return jobs->threads == 1 && jobs_is_worker(jobs) && !jobs->inside;
}

/* ---- sleep.c ---- */
typedef struct jobs_idle_state {
    uint64_t until_ns; /* 0: has just begun */
    uint32_t pauses;
} jobs_idle_state;

bool jobs_wake(kd_jobs *jobs, uint32_t worker);
void jobs_wake_sleepers(kd_jobs *jobs, uint32_t n);
void jobs_wake_waiting(kd_jobs *jobs);
bool jobs_work_is_visible(kd_jobs *jobs, const job_worker *w);
/* Nothing was found: pause, ever longer, then sleep until there may be work or `counter` (may be NULL) may be
 * zero. */
void jobs_idle(kd_jobs *jobs, job_worker *w, kd_job_counter *counter, jobs_idle_state *state);

/* Wake up to n workers, if that many sleep. What they are to find was published before. */
static inline void jobs_wake_some(kd_jobs *jobs, uint32_t n)
{
    if (atomic_load(&jobs->parked))
        jobs_wake_sleepers(jobs, n);
}

/* ---- counter.c ---- */
/* A run of finished jobs that its counter does not know of yet. */
typedef struct jobs_finished {
    kd_job_counter *counter;
    uint32_t count;
} jobs_finished;

static inline void jobs_raise(kd_job_counter *counter, uint32_t n)
{
    if (counter)
        atomic_fetch_add_explicit(&counter->pending, n, memory_order_relaxed);
}
static inline void jobs_flush(kd_jobs *jobs, jobs_finished *run)
{
    jobs_finished done = *run;
    *run = (jobs_finished){0};
    if (done.counter)
        kd_jobs_lower(jobs, done.counter, done.count);
}
void jobs_after_fini(kd_jobs *jobs);

/* ---- worker.c ---- */
void *jobs_worker_main(void *worker);
void jobs_execute(kd_jobs *jobs, job_worker *w, const job *j, jobs_finished *run);
/* Run one job if there is one: the lane's before all others. */
bool jobs_run_one(kd_jobs *jobs, job_worker *w, jobs_finished *run);
/* Single thread: run all that the last job left behind. */
void jobs_drain_inline(kd_jobs *jobs);

/* ---- submit.c ---- */
/* Publish a job whose counter is raised already. */
void jobs_enqueue(kd_jobs *jobs, const job *j);
void jobs_submit(kd_jobs *jobs, const job *j);

/* ---- parallel_for.c ---- */
void jobs_run_piece(kd_jobs *jobs, job_worker *w, const job *piece);
uint32_t jobs_piece_label(const job *piece);

#endif
