/* The pool: one Chase-Lev deque a worker, one mutex-guarded queue for the GPU lane, one sleeping place a
 * worker.
 *
 * No wake-up is lost. Who sleeps first sets its bit in `parked` (and in `waiting` when it waits for a
 * counter), then looks at the deques, the lane and its counter once more. Who submits or finishes first
 * publishes, then reads the mask. All four are sequentially consistent, so at least one of the two sees the
 * other.
 *
 * Finished jobs of one counter are subtracted together, before a job of another counter begins or the worker
 * runs dry: the counter could not have become zero earlier, and workers do not fight for its cache line. */
#include "runtime/jobs/jobs.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "runtime/core/clock.h"
#include "runtime/core/log.h"
#include "runtime/jobs/deque.h"

enum {
    MAX_WORKERS = 64,
    DEQUE_SIZE = 1024,
    LANE_SIZE = 64,
    SPIN_NS = 20000, /* about the price of a sleep and a wake-up: longer would waste more than it saves */
    MAX_PAUSES = 32, /* looking at a deque takes its cache line away: look less often when nothing comes */
    PIECES_PER_WORKER = 16, /* of a parallel_for with automatic grain */
};

typedef struct job_worker {
    job_deque deque;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t signal;
    bool signaled; /* under lock */
    kd_jobs *jobs;
    uint32_t index;
    uint32_t victim; /* where to steal next */
    /* A lone job is stolen only when it is seen twice at the same place: its owner is most likely about to
     * run it, and a chain of jobs would wander between caches otherwise. */
    int64_t seen_top[MAX_WORKERS];
} job_worker;

struct kd_jobs {
    alignas(128) _Atomic uint64_t parked; /* bit i: worker i sleeps, or is about to */
    _Atomic uint64_t waiting;             /* bit i: and does so for a counter */
    _Atomic bool stop;
    kd_job_counter alive;      /* workers that have not left yet, without worker 0 */
    uint32_t threads, started; /* fewer started only when making the pool failed */
    bool inside;               /* single thread: a job is running */

    alignas(128) pthread_mutex_t lane_lock;
    job *lane; /* ring, under lane_lock */
    uint32_t lane_size, lane_head;
    _Atomic uint32_t lane_count;
    bool lane_busy; /* worker 0 alone: a lane job is running */

    job_worker workers[];
};

/* A run of finished jobs that its counter does not know of yet. */
typedef struct finished_run {
    kd_job_counter *counter;
    uint32_t count;
} finished_run;

typedef struct idle_state {
    uint64_t until_ns; /* 0: has just begun */
    uint32_t pauses;
} idle_state;

/* The frame of one parallel_for; its pieces are jobs with fn == NULL. */
typedef struct split_frame {
    kd_range_fn *fn;
    void *user;
    uint32_t grain;
    kd_job_counter counter;
} split_frame;

static _Thread_local struct {
    const kd_jobs *jobs;
    uint32_t worker;
} job_thread;

uint32_t kd_jobs_worker(const kd_jobs *jobs)
{
    return job_thread.jobs == jobs ? job_thread.worker : 0;
}

uint32_t kd_jobs_threads(const kd_jobs *jobs)
{
    return jobs->threads;
}

/* ---- sleeping and waking ---- */

static void unpark(job_worker *w)
{
    pthread_mutex_lock(&w->lock);
    w->signaled = true;
    pthread_cond_signal(&w->signal);
    pthread_mutex_unlock(&w->lock);
}

static bool wake(kd_jobs *jobs, uint32_t worker)
{
    uint64_t bit = (uint64_t)1 << worker;
    if (!(atomic_fetch_and(&jobs->parked, ~bit) & bit))
        return false;
    unpark(&jobs->workers[worker]);
    return true;
}

/* Wake up to n sleepers, the highest first: worker 0 has the lane to care for. */
static void wake_some(kd_jobs *jobs, uint32_t n)
{
    while (n > 0) {
        uint64_t parked = atomic_load(&jobs->parked);
        if (!parked)
            return;
        if (wake(jobs, 63u - (uint32_t)__builtin_clzll(parked)))
            n--;
    }
}

static void wake_waiting(kd_jobs *jobs)
{
    for (uint64_t waiting = atomic_load(&jobs->waiting); waiting; waiting &= waiting - 1)
        wake(jobs, (uint32_t)__builtin_ctzll(waiting));
}

static bool work_is_visible(kd_jobs *jobs, const job_worker *w)
{
    int64_t top;
    for (uint32_t i = 0; i < jobs->threads; i++)
        if (job_deque_look(&jobs->workers[i].deque, &top) > 0)
            return true;
    return w->index == KD_GPU_LANE && !jobs->lane_busy && atomic_load(&jobs->lane_count) > 0;
}

/* Sleep until there may be work, the counter may be zero (NULL: none is awaited) or the pool stops. */
static void park(kd_jobs *jobs, job_worker *w, kd_job_counter *counter)
{
    uint64_t bit = (uint64_t)1 << w->index;
    atomic_fetch_or(&jobs->parked, bit);
    if (counter)
        atomic_fetch_or(&jobs->waiting, bit);
    bool ready = counter ? atomic_load(&counter->pending) == 0 : atomic_load(&jobs->stop);
    if (!ready && !work_is_visible(jobs, w)) {
        pthread_mutex_lock(&w->lock);
        while (!w->signaled)
            pthread_cond_wait(&w->signal, &w->lock);
        w->signaled = false;
        pthread_mutex_unlock(&w->lock);
    }
    if (counter)
        atomic_fetch_and(&jobs->waiting, ~bit);
    atomic_fetch_and(&jobs->parked, ~bit);
}

static void pause_briefly(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("isb");
#endif
}

/* Nothing was found: pause, ever longer, then sleep. */
static void idle(kd_jobs *jobs, job_worker *w, kd_job_counter *counter, idle_state *state)
{
    uint64_t now = kd_clock_ns();
    if (state->until_ns == 0)
        *state = (idle_state){.until_ns = now + SPIN_NS, .pauses = 1};
    if (now >= state->until_ns) {
        park(jobs, w, counter);
        *state = (idle_state){0};
        return;
    }
    for (uint32_t i = 0; i < state->pauses; i++)
        pause_briefly();
    state->pauses = state->pauses < MAX_PAUSES ? state->pauses * 2 : MAX_PAUSES;
}

/* ---- finding and running ---- */

static bool take_lane(kd_jobs *jobs, job *out)
{
    if (atomic_load_explicit(&jobs->lane_count, memory_order_relaxed) == 0)
        return false;
    pthread_mutex_lock(&jobs->lane_lock);
    *out = jobs->lane[jobs->lane_head];
    jobs->lane_head = (jobs->lane_head + 1) % jobs->lane_size;
    atomic_fetch_sub(&jobs->lane_count, 1);
    pthread_mutex_unlock(&jobs->lane_lock);
    return true;
}

static bool steal_any(kd_jobs *jobs, job_worker *w, job *out)
{
    for (uint32_t i = 0; i < jobs->threads; i++) {
        uint32_t victim = w->victim;
        w->victim = victim + 1 < jobs->threads ? victim + 1 : 0;
        if (victim == w->index)
            continue;
        job_deque *deque = &jobs->workers[victim].deque;
        int64_t top, seen = w->seen_top[victim];
        int64_t count = job_deque_look(deque, &top);
        w->seen_top[victim] = count == 1 ? top : -1;
        if ((count > 1 || (count == 1 && seen == top)) && job_deque_steal(deque, top, out)) {
            w->victim = victim; /* there may be more */
            return true;
        }
    }
    return false;
}

static void flush(kd_jobs *jobs, finished_run *run)
{
    if (run->counter && atomic_fetch_sub(&run->counter->pending, run->count) == run->count)
        wake_waiting(jobs);
    run->counter = NULL;
    run->count = 0;
}

static void run_piece(kd_jobs *jobs, job_worker *w, const job *piece);

static void execute(kd_jobs *jobs, job_worker *w, const job *j, finished_run *run)
{
    if (run->counter != j->counter)
        flush(jobs, run);
    if (j->fn)
        j->fn(j->user, w->index);
    else
        run_piece(jobs, w, j);
    run->counter = j->counter;
    run->count += j->counter != NULL;
}

/* Run one job if there is one: the lane's first, then our own, then a stolen one. */
static bool run_one(kd_jobs *jobs, job_worker *w, finished_run *run)
{
    job j;
    if (w->index == KD_GPU_LANE && !jobs->lane_busy && take_lane(jobs, &j)) {
        jobs->lane_busy = true;
        execute(jobs, w, &j, run);
        jobs->lane_busy = false;
        return true;
    }
    if (!job_deque_take(&w->deque, &j) && !steal_any(jobs, w, &j))
        return false;
    execute(jobs, w, &j, run);
    return true;
}

static void *worker_main(void *user)
{
    job_worker *w = user;
    kd_jobs *jobs = w->jobs;
    job_thread.jobs = jobs;
    job_thread.worker = w->index;
    finished_run run = {0};
    idle_state state = {0};
    for (;;) {
        if (run_one(jobs, w, &run)) {
            state.until_ns = 0;
            continue;
        }
        flush(jobs, &run);
        if (atomic_load(&jobs->stop) && !work_is_visible(jobs, w))
            break;
        idle(jobs, w, NULL, &state);
    }
    run = (finished_run){&jobs->alive, 1};
    flush(jobs, &run);
    return NULL;
}

void kd_jobs_wait(kd_jobs *jobs, kd_job_counter *counter)
{
    job_worker *w = &jobs->workers[kd_jobs_worker(jobs)];
    finished_run run = {0};
    idle_state state = {0};
    for (;;) {
        uint32_t known = run.counter == counter ? run.count : 0;
        if (atomic_load_explicit(&counter->pending, memory_order_acquire) == known)
            break;
        if (run_one(jobs, w, &run)) {
            state.until_ns = 0;
            continue;
        }
        flush(jobs, &run);
        if (atomic_load_explicit(&counter->pending, memory_order_acquire) != 0)
            idle(jobs, w, counter, &state);
    }
    flush(jobs, &run);
}

void kd_jobs_lower(kd_jobs *jobs, kd_job_counter *counter, uint32_t n)
{
    flush(jobs, &(finished_run){counter, n});
}

/* Single thread: run all that the last job left behind. */
static void drain_inline(kd_jobs *jobs)
{
    finished_run run = {0};
    jobs->inside = true;
    while (run_one(jobs, &jobs->workers[0], &run))
        ;
    flush(jobs, &run);
    jobs->inside = false;
}

/* ---- submitting ---- */

static void submit(kd_jobs *jobs, const job *j)
{
    job_worker *w = &jobs->workers[kd_jobs_worker(jobs)];
    if (j->counter)
        atomic_fetch_add_explicit(&j->counter->pending, 1, memory_order_relaxed);
    if (job_deque_push(&w->deque, j)) {
        wake_some(jobs, 1);
        return;
    }
    finished_run run = {0}; /* no memory for a larger ring: do it now */
    execute(jobs, w, j, &run);
    flush(jobs, &run);
}

void kd_jobs_run(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter)
{
    assert(fn);
    if (jobs->threads == 1 && !jobs->inside) {
        jobs->inside = true;
        fn(user, 0);
        drain_inline(jobs);
        return;
    }
    submit(jobs, &(job){.fn = fn, .user = user, .counter = counter});
}

void kd_jobs_run_n(kd_jobs *jobs, kd_job_fn *fn, void *const *users, uint32_t n, kd_job_counter *counter)
{
    job_worker *w = &jobs->workers[kd_jobs_worker(jobs)];
    job_ring *ring = n > 1 && (jobs->threads > 1 || jobs->inside) ? job_deque_reserve(&w->deque, n) : NULL;
    if (!ring) {
        for (uint32_t i = 0; i < n; i++)
            kd_jobs_run(jobs, fn, users[i], counter);
        return;
    }
    if (counter)
        atomic_fetch_add_explicit(&counter->pending, n, memory_order_relaxed);
    int64_t bottom = atomic_load_explicit(&w->deque.bottom, memory_order_relaxed);
    for (uint32_t i = 0; i < n; i++) /* the first one last, because the owner takes from the bottom */
        job_slot_write(ring, bottom + i, &(job){.fn = fn, .user = users[n - 1 - i], .counter = counter});
    job_deque_publish(&w->deque, n);
    wake_some(jobs, n < jobs->threads ? n : jobs->threads - 1);
}

static void append_lane(kd_jobs *jobs, const job *j)
{
    uint32_t count = atomic_load_explicit(&jobs->lane_count, memory_order_relaxed);
    if (count == jobs->lane_size) {
        job *larger = malloc(sizeof(job) * jobs->lane_size * 2);
        if (!larger) { /* a lane job can run nowhere else, and the order must hold: there is no way on */
            kd_log(KD_LOG_ERROR, "out of memory (%u jobs wait for the GPU lane); stopping", (unsigned)count);
            abort();
        }
        for (uint32_t i = 0; i < count; i++)
            larger[i] = jobs->lane[(jobs->lane_head + i) % jobs->lane_size];
        free(jobs->lane);
        jobs->lane = larger;
        jobs->lane_head = 0;
        jobs->lane_size *= 2;
    }
    jobs->lane[(jobs->lane_head + count) % jobs->lane_size] = *j;
    atomic_fetch_add(&jobs->lane_count, 1);
}

void kd_jobs_run_lane(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter)
{
    assert(fn);
    if (counter)
        atomic_fetch_add_explicit(&counter->pending, 1, memory_order_relaxed);
    pthread_mutex_lock(&jobs->lane_lock);
    append_lane(jobs, &(job){.fn = fn, .user = user, .counter = counter});
    pthread_mutex_unlock(&jobs->lane_lock);
    if (jobs->threads == 1 && !jobs->inside)
        drain_inline(jobs);
    else if (atomic_load(&jobs->parked) & 1)
        wake(jobs, KD_GPU_LANE);
}

/* ---- parallel_for: lazy binary splitting (Tzannes et al. 2010) ---- */

/* Work through [begin, end) grain by grain. Whenever our deque is empty (somebody took what we offered, or
 * nothing is on offer yet), offer the upper half of what remains: without a thief there are as many jobs as
 * halvings, not as grains. */
static void run_piece(kd_jobs *jobs, job_worker *w, const job *piece)
{
    split_frame *frame = piece->user;
    uint32_t begin = (uint32_t)piece->range, end = (uint32_t)(piece->range >> 32);
    while (begin < end) {
        while (end - begin > frame->grain && job_deque_is_empty(&w->deque)) {
            uint32_t middle = begin + (end - begin) / 2;
            submit(jobs,
                   &(job){.user = frame, .counter = &frame->counter, .range = middle | (uint64_t)end << 32});
            end = middle;
        }
        uint32_t stop = end - begin > frame->grain ? begin + frame->grain : end;
        frame->fn(frame->user, begin, stop, w->index);
        begin = stop;
    }
}

void kd_jobs_parallel_for(kd_jobs *jobs, uint32_t count, uint32_t grain, kd_range_fn *fn, void *user)
{
    uint32_t worker = kd_jobs_worker(jobs);
    if (count == 0)
        return;
    if (grain == 0)
        grain = count / (jobs->threads * PIECES_PER_WORKER) + 1;
    if (jobs->threads == 1 || count <= grain) {
        fn(user, 0, count, worker);
        return;
    }
    split_frame frame = {.fn = fn, .user = user, .grain = grain};
    run_piece(jobs, &jobs->workers[worker], &(job){.user = &frame, .range = (uint64_t)count << 32});
    kd_jobs_wait(jobs, &frame.counter);
}

/* ---- making and destroying ---- */

static bool init_worker(kd_jobs *jobs, uint32_t index)
{
    job_worker *w = &jobs->workers[index];
    w->jobs = jobs;
    w->index = index;
    memset(w->seen_top, 0xFF, sizeof w->seen_top); /* -1: nothing seen */
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->signal, NULL);
    return job_deque_init(&w->deque, DEQUE_SIZE);
}

static bool start_worker(job_worker *w)
{
    return pthread_create(&w->thread, NULL, worker_main, w) == 0;
}

static uint32_t processor_count(void)
{
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online < 1 ? 1 : online > MAX_WORKERS ? MAX_WORKERS : (uint32_t)online;
}

kd_jobs *kd_jobs_make(uint32_t threads)
{
    threads = threads == 0 ? processor_count() : threads > MAX_WORKERS ? MAX_WORKERS : threads;
    size_t size = sizeof(kd_jobs) + threads * sizeof(job_worker);
    kd_jobs *jobs = aligned_alloc(128, (size + 127) / 128 * 128);
    if (!jobs)
        return NULL;
    memset(jobs, 0, size);
    jobs->lane_size = LANE_SIZE;
    jobs->lane = malloc(sizeof(job) * LANE_SIZE);
    pthread_mutex_init(&jobs->lane_lock, NULL);
    bool ok = jobs->lane != NULL;
    jobs->threads = threads;
    for (uint32_t i = 0; i < threads; i++)
        ok = init_worker(jobs, i) && ok;
    atomic_init(&jobs->alive.pending, threads - 1);
    jobs->started = 1;
    while (ok && jobs->started < threads && start_worker(&jobs->workers[jobs->started]))
        jobs->started++;
    if (ok && jobs->started == threads)
        return jobs;
    atomic_fetch_sub(&jobs->alive.pending, threads - jobs->started); /* those never lived */
    kd_jobs_destroy(jobs);
    return NULL;
}

void kd_jobs_destroy(kd_jobs *jobs)
{
    if (!jobs)
        return;
    atomic_store(&jobs->stop, true);
    for (uint32_t i = 1; i < jobs->threads; i++)
        wake(jobs, i);
    kd_jobs_wait(jobs, &jobs->alive);
    for (uint32_t i = 1; i < jobs->started; i++)
        pthread_join(jobs->workers[i].thread, NULL);
    if (jobs->lane)
        drain_inline(jobs);
    for (uint32_t i = 0; i < jobs->threads; i++) {
        job_deque_fini(&jobs->workers[i].deque);
        pthread_mutex_destroy(&jobs->workers[i].lock);
        pthread_cond_destroy(&jobs->workers[i].signal);
    }
    pthread_mutex_destroy(&jobs->lane_lock);
    free(jobs->lane);
    free(jobs);
}
