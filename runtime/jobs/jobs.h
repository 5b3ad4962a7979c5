#ifndef KD_JOBS_JOBS_H
#define KD_JOBS_JOBS_H

/* Work-stealing jobs. `threads` counts the calling thread: with 1 everything runs inline. The thread that
 * made the pool is worker 0 and the GPU lane: jobs sent to the lane run there, when it waits or drains.
 *
 * Threads that are no workers may call everything here too. Their jobs run on workers; with one thread that
 * is when worker 0 next waits or submits. They sleep while they wait instead of helping. A worker that finds
 * nothing to do spins for some microseconds, then sleeps. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct kd_jobs kd_jobs;
typedef void kd_job_fn(void *user, uint32_t worker);
typedef void kd_range_fn(void *user, uint32_t begin, uint32_t end, uint32_t worker);

/* A counter of unfinished jobs; starts as {0}. It may be freed when a wait for it has returned. */
typedef struct kd_job_counter {
#ifdef __cplusplus
    uint32_t pending; /* opaque there */
#else
    _Atomic uint32_t pending; /* 0: all done. The top bit says that jobs wait for it */
#endif
    struct kd_job_after *after; /* those, owned by the pool */
} kd_job_counter;

kd_jobs *kd_jobs_make(uint32_t threads); /* 0: one per processor. NULL when memory is out */
void kd_jobs_destroy(kd_jobs *jobs);     /* waits for everything */
uint32_t kd_jobs_threads(const kd_jobs *jobs);

/* ---- submitting ---- */
/** Run fn(user) on some worker. `counter` (may be NULL) is raised now and lowered when it is done. */
void kd_jobs_run(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter);
/** Submit n jobs fn(users[i]) with one publication. */
void kd_jobs_run_n(kd_jobs *jobs, kd_job_fn *fn, void *const *users, uint32_t n, kd_job_counter *counter);
/** Run before all jobs that are not yet begun: for the chain that decides how long the frame takes.
 *  Cost  a mutex; keep it for few jobs */
void kd_jobs_run_first(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter);
/** Run on the GPU lane, in order of submission. */
void kd_jobs_run_lane(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter);
/** Run once `before` is zero, at once if it is; nobody needs to wait for `before`. `counter` (may be NULL,
 * not `before`) is raised now. Allocates only when more jobs wait at once than ever before. */
void kd_jobs_run_after(kd_jobs *jobs, kd_job_counter *before, kd_job_fn *fn, void *user,
                       kd_job_counter *counter);
/** Split [0, count) over the workers and return when all is done. `grain`: indices a call of fn gets at most
 *  (fewer at ends); 0 chooses it, and times the first of 256 shares: a loop of some microseconds runs inline.
 */
void kd_jobs_parallel_for(kd_jobs *jobs, uint32_t count, uint32_t grain, kd_range_fn *fn, void *user);

/* ---- waiting ---- */
/** Wait until the counter is zero, running other jobs meanwhile (worker 0 also lane jobs). */
void kd_jobs_wait(kd_jobs *jobs, kd_job_counter *counter);
/** Lower a counter that was raised by hand, and wake who waits for zero. */
void kd_jobs_lower(kd_jobs *jobs, kd_job_counter *counter, uint32_t n);

/* ---- watching: what profilers hook in ---- */
/* Called on a worker round each job that it takes. `label` is that of who started the loop of which the job
 * is a part, 0 for other jobs. */
typedef struct kd_jobs_hooks {
    void (*begin)(void *user, uint32_t worker, uint32_t label);
    void (*end)(void *user, uint32_t worker, uint32_t label);
    void *user;
} kd_jobs_hooks;
/** Set the hooks (NULL: none). Threading: worker 0, while no job is under way. */
void kd_jobs_set_hooks(kd_jobs *jobs, const kd_jobs_hooks *hooks);
/** Label the loops that the calling worker starts from now on. Returns the label before. Threading: that
 * worker. */
uint32_t kd_jobs_set_label(kd_jobs *jobs, uint32_t worker, uint32_t label);

/** Worker number of the calling thread in this pool (NULL: in the one that it belongs to); 0 for threads that
 * are not workers. */
uint32_t kd_jobs_worker(const kd_jobs *jobs);

#define KD_GPU_LANE 0u

#endif
