#ifndef KD_JOBS_JOBS_H
#define KD_JOBS_JOBS_H

/* Work-stealing jobs. `threads` counts the calling thread: with 1 everything runs inline. The thread that made the pool
 * is worker 0 and the GPU lane: jobs sent to the lane run there, when it waits or drains. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct kd_jobs kd_jobs;
typedef void kd_job_fn(void *user, uint32_t worker);
typedef void kd_range_fn(void *user, uint32_t begin, uint32_t end, uint32_t worker);

/* A counter of unfinished jobs; starts as {0}. */
typedef struct kd_job_counter {
    _Atomic uint32_t pending;
} kd_job_counter;

kd_jobs *kd_jobs_make(uint32_t threads); /* 0: one per processor. NULL when memory is out */
void kd_jobs_destroy(kd_jobs *jobs);     /* waits for everything */
uint32_t kd_jobs_threads(const kd_jobs *jobs);

/** Run fn(user) on some worker. `counter` (may be NULL) is raised now and lowered when it is done. Threading: any worker. */
void kd_jobs_run(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter);
/** Submit n jobs fn(users[i]) with one publication. */
void kd_jobs_run_n(kd_jobs *jobs, kd_job_fn *fn, void *const *users, uint32_t n, kd_job_counter *counter);
/** Run on the GPU lane, in order of submission. */
void kd_jobs_run_lane(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter);
/** Wait until the counter is zero, running other jobs meanwhile (worker 0 also lane jobs). */
void kd_jobs_wait(kd_jobs *jobs, kd_job_counter *counter);
/** Lower a counter that was raised by hand, and wake who waits for zero. Threading: any worker. */
void kd_jobs_lower(kd_jobs *jobs, kd_job_counter *counter, uint32_t n);
/** Split [0, count) over the workers; grain 0 chooses. Runs inline when splitting gains nothing. Returns when all is done. */
void kd_jobs_parallel_for(kd_jobs *jobs, uint32_t count, uint32_t grain, kd_range_fn *fn, void *user);
/** Worker number of the calling thread; 0 for threads that are not workers. */
uint32_t kd_jobs_worker(const kd_jobs *jobs);

#define KD_GPU_LANE 0u

#endif
