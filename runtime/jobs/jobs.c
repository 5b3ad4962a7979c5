/* The pool: one Chase-Lev deque a worker, mutex-guarded queues for the GPU lane, for jobs that go first and
 * for jobs from foreign threads, one sleeping place a worker.
 *
 * No wake-up is lost. Who sleeps first sets its bit in `parked` (and in `waiting` when it waits for a
 * counter), then looks at the deques, the queues and its counter once more. Who submits or finishes first
 * publishes, then reads the mask. All four are sequentially consistent, so at least one of the two sees the
 * other.
 *
 * Finished jobs of one counter are subtracted together, before a job of another counter begins or the worker
 * runs dry: the counter could not have become zero earlier, and workers do not fight for its cache line.
 *
 * Jobs that wait for a counter hang in a list at it; a bit in `pending` says so. The bit is never there
 * alone: who lowers the rest takes list and bit away in the step that makes the word zero, and from then on
 * touches the counter no more, since whoever waits for it may free it. */
#include "runtime/jobs/jobs.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "runtime/core/clock.h"
#include "runtime/core/log.h"
#include "runtime/jobs/deque.h"
#include "runtime/jobs/queue.h"

enum {
    MAX_WORKERS = 64,
    DEQUE_SIZE = 1024,
    QUEUE_SIZE = 64,
    AFTER_BLOCK = 64,
    SPIN_NS = 20000, /* about the price of a sleep and a wake-up: longer would waste more than it saves */
    MAX_PAUSES = 32, /* looking at a deque takes its cache line away: look less often when nothing comes */
    PIECES_PER_WORKER = 16, /* of a parallel_for with automatic grain */
    PROBE_SHARE = 256,      /* of such a loop's indices, one share is timed before anything is offered */
    INLINE_NS = 10000,      /* a loop shorter than a wake-up gains nothing from a second thread */
};
#define HAS_AFTER 0x80000000u /* in a counter's pending: jobs wait for it */

/* A job that waits for a counter. */
typedef struct kd_job_after {
    job waiting;
    struct kd_job_after *next;
} job_after;

typedef struct after_block {
    struct after_block *older;
    job_after items[AFTER_BLOCK];
} after_block;

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

    const void *owner; /* the thread that is worker 0, by its thread-local record */
    bool lane_busy;    /* worker 0 alone: a lane job is running */
    job_queue lane, first, inbox;

    alignas(128) pthread_mutex_t after_lock; /* guards the lists at all counters */
    job_after *after_free;
    after_block *after_blocks;

    pthread_mutex_t outside_lock;
    pthread_cond_t outside_signal;
    _Atomic uint32_t outside_waiting; /* foreign threads that wait for a counter */

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

uint32_t kd_jobs_worker(const kd_jobs *jobs) {
    return job_thread.jobs == jobs ? job_thread.worker : 0;
}

static bool is_worker(const kd_jobs *jobs) {
    return job_thread.jobs == jobs || jobs->owner == &job_thread;
}

/* No other thread runs jobs and none is running: submitting means doing. */
static bool runs_inline(const kd_jobs *jobs) {
    return jobs->threads == 1 && is_worker(jobs) && !jobs->inside;
}

uint32_t kd_jobs_threads(const kd_jobs *jobs) {
    return jobs->threads;
}

/* ---- sleeping and waking ---- */

static void unpark(job_worker *w) {
    pthread_mutex_lock(&w->lock);
    w->signaled = true;
    pthread_cond_signal(&w->signal);
    pthread_mutex_unlock(&w->lock);
}

static bool wake(kd_jobs *jobs, uint32_t worker) {
    uint64_t bit = (uint64_t)1 << worker;
    if (!(atomic_fetch_and(&jobs->parked, ~bit) & bit))
        return false;
    unpark(&jobs->workers[worker]);
    return true;
}

/* Wake up to n sleepers, the highest first: worker 0 has the lane to care for. */
static void wake_some(kd_jobs *jobs, uint32_t n) {
    while (n > 0) {
        uint64_t parked = atomic_load(&jobs->parked);
        if (!parked)
            return;
        if (wake(jobs, 63u - (uint32_t)__builtin_clzll(parked)))
            n--;
    }
}

static void wake_waiting(kd_jobs *jobs) {
    for (uint64_t waiting = atomic_load(&jobs->waiting); waiting; waiting &= waiting - 1)
        wake(jobs, (uint32_t)__builtin_ctzll(waiting));
    if (atomic_load(&jobs->outside_waiting) > 0) {
        pthread_mutex_lock(&jobs->outside_lock);
        pthread_cond_broadcast(&jobs->outside_signal);
        pthread_mutex_unlock(&jobs->outside_lock);
    }
}

static bool work_is_visible(kd_jobs *jobs, const job_worker *w) {
    int64_t top;
    for (uint32_t i = 0; i < jobs->threads; i++)
        if (job_deque_look(&jobs->workers[i].deque, &top) > 0)
            return true;
    if (atomic_load(&jobs->first.count) > 0 || atomic_load(&jobs->inbox.count) > 0)
        return true;
    return w->index == KD_GPU_LANE && !jobs->lane_busy && atomic_load(&jobs->lane.count) > 0;
}

/* Sleep until there may be work, the counter may be zero (NULL: none is awaited) or the pool stops. */
static void park(kd_jobs *jobs, job_worker *w, kd_job_counter *counter) {
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

static void pause_briefly(void) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("isb");
#endif
}

/* Nothing was found: pause, ever longer, then sleep. */
static void idle(kd_jobs *jobs, job_worker *w, kd_job_counter *counter, idle_state *state) {
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

static bool steal_any(kd_jobs *jobs, job_worker *w, job *out) {
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

static void release(kd_jobs *jobs, job_after *after);

/* Lower the last n of a counter for which jobs wait, if they still are the last. */
static bool lower_last(kd_jobs *jobs, kd_job_counter *counter, uint32_t n, job_after **after) {
    uint32_t pending = n | HAS_AFTER;
    pthread_mutex_lock(&jobs->after_lock);
    *after = counter->after;
    counter->after = NULL;
    bool lowered = atomic_compare_exchange_strong(&counter->pending, &pending, 0);
    if (!lowered)
        counter->after = *after;
    pthread_mutex_unlock(&jobs->after_lock);
    return lowered;
}

static void lower(kd_jobs *jobs, kd_job_counter *counter, uint32_t n) {
    uint32_t pending = n; /* guessed: then one exchange is enough */
    job_after *after = NULL;
    while (!atomic_compare_exchange_strong(&counter->pending, &pending, pending - n)) {
        if (pending != (n | HAS_AFTER))
            continue;
        if (lower_last(jobs, counter, n, &after)) {
            wake_waiting(jobs);
            release(jobs, after);
            return;
        }
        pending = n;
    }
    if (pending == n)
        wake_waiting(jobs);
}

static void flush(kd_jobs *jobs, finished_run *run) {
    finished_run done = *run;
    *run = (finished_run){0};
    if (done.counter)
        lower(jobs, done.counter, done.count);
}

static void run_piece(kd_jobs *jobs, job_worker *w, const job *piece);

static void execute(kd_jobs *jobs, job_worker *w, const job *j, finished_run *run) {
    if (run->counter != j->counter)
        flush(jobs, run);
    if (j->fn)
        j->fn(j->user, w->index);
    else
        run_piece(jobs, w, j);
    run->counter = j->counter;
    run->count += j->counter != NULL;
}

static bool find_job(kd_jobs *jobs, job_worker *w, job *out) {
    return job_queue_take(&jobs->first, out) || job_deque_take(&w->deque, out) ||
           job_queue_take(&jobs->inbox, out) || steal_any(jobs, w, out);
}

/* Run one job if there is one: the lane's before all others. */
static bool run_one(kd_jobs *jobs, job_worker *w, finished_run *run) {
    job j;
    if (w->index == KD_GPU_LANE && !jobs->lane_busy && job_queue_take(&jobs->lane, &j)) {
        jobs->lane_busy = true;
        execute(jobs, w, &j, run);
        jobs->lane_busy = false;
        return true;
    }
    if (!find_job(jobs, w, &j))
        return false;
    execute(jobs, w, &j, run);
    return true;
}

static void *worker_main(void *user) {
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

static void wait_helping(kd_jobs *jobs, job_worker *w, kd_job_counter *counter) {
    finished_run run = {0};
    idle_state state = {0};
    for (;;) {
        uint32_t known = run.counter == counter ? run.count : 0;
        if ((atomic_load_explicit(&counter->pending, memory_order_acquire) & ~HAS_AFTER) == known)
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

static void wait_outside(kd_jobs *jobs, kd_job_counter *counter) {
    atomic_fetch_add(&jobs->outside_waiting, 1);
    pthread_mutex_lock(&jobs->outside_lock);
    while (atomic_load(&counter->pending) != 0)
        pthread_cond_wait(&jobs->outside_signal, &jobs->outside_lock);
    pthread_mutex_unlock(&jobs->outside_lock);
    atomic_fetch_sub(&jobs->outside_waiting, 1);
}

/* Single thread: run all that the last job left behind. */
static void drain_inline(kd_jobs *jobs) {
    finished_run run = {0};
    jobs->inside = true;
    for (;;) {
        if (run_one(jobs, &jobs->workers[0], &run))
            continue;
        if (!run.counter)
            break;
        flush(jobs, &run); /* may let jobs go that waited */
    }
    jobs->inside = false;
}

void kd_jobs_wait(kd_jobs *jobs, kd_job_counter *counter) {
    if (atomic_load_explicit(&counter->pending, memory_order_acquire) == 0)
        return;
    if (!is_worker(jobs)) {
        wait_outside(jobs, counter);
        return;
    }
    bool outermost = runs_inline(jobs);
    if (outermost)
        jobs->inside = true; /* foreign threads may have sent jobs: what those submit must not nest */
    wait_helping(jobs, &jobs->workers[kd_jobs_worker(jobs)], counter);
    if (outermost)
        drain_inline(jobs);
}

void kd_jobs_lower(kd_jobs *jobs, kd_job_counter *counter, uint32_t n) {
    lower(jobs, counter, n);
}

/* ---- submitting ---- */

static void raise_counter(kd_job_counter *counter, uint32_t n) {
    if (counter)
        atomic_fetch_add_explicit(&counter->pending, n, memory_order_relaxed);
}

/* For jobs that no other place can take: there is no way on. */
static void put_or_stop(job_queue *queue, const job *j, const char *what) {
    if (job_queue_put(queue, j))
        return;
    kd_log(KD_LOG_ERROR, "out of memory (%u jobs wait %s); stopping", (unsigned)atomic_load(&queue->count),
           what);
    abort();
}

/* Publish a job whose counter is raised already. */
static void enqueue(kd_jobs *jobs, const job *j) {
    job_worker *w = &jobs->workers[kd_jobs_worker(jobs)];
    bool inside = is_worker(jobs);
    if (!inside)
        put_or_stop(&jobs->inbox, j, "that other threads sent");
    if (!inside || job_deque_push(&w->deque, j)) {
        wake_some(jobs, 1);
        return;
    }
    finished_run run = {0}; /* no memory for a larger ring: do it now */
    execute(jobs, w, j, &run);
    flush(jobs, &run);
}

static void submit(kd_jobs *jobs, const job *j) {
    raise_counter(j->counter, 1);
    enqueue(jobs, j);
}

void kd_jobs_run(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter) {
    assert(fn);
    if (runs_inline(jobs)) {
        jobs->inside = true;
        fn(user, 0);
        drain_inline(jobs);
        return;
    }
    submit(jobs, &(job){.fn = fn, .user = user, .counter = counter});
}

void kd_jobs_run_n(kd_jobs *jobs, kd_job_fn *fn, void *const *users, uint32_t n, kd_job_counter *counter) {
    job_worker *w = &jobs->workers[kd_jobs_worker(jobs)];
    bool batch = n > 1 && is_worker(jobs) && !runs_inline(jobs);
    job_ring *ring = batch ? job_deque_reserve(&w->deque, n) : NULL;
    if (!ring) {
        for (uint32_t i = 0; i < n; i++)
            kd_jobs_run(jobs, fn, users[i], counter);
        return;
    }
    raise_counter(counter, n);
    int64_t bottom = atomic_load_explicit(&w->deque.bottom, memory_order_relaxed);
    for (uint32_t i = 0; i < n; i++) /* the first one last, because the owner takes from the bottom */
        job_slot_write(ring, bottom + i, &(job){.fn = fn, .user = users[n - 1 - i], .counter = counter});
    job_deque_publish(&w->deque, n);
    wake_some(jobs, n < jobs->threads ? n : jobs->threads - 1);
}

void kd_jobs_run_first(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter) {
    job j = {.fn = fn, .user = user, .counter = counter};
    assert(fn);
    if (runs_inline(jobs)) {
        kd_jobs_run(jobs, fn, user, counter);
        return;
    }
    raise_counter(counter, 1);
    if (job_queue_put(&jobs->first, &j))
        wake_some(jobs, 1);
    else
        enqueue(jobs, &j);
}

void kd_jobs_run_lane(kd_jobs *jobs, kd_job_fn *fn, void *user, kd_job_counter *counter) {
    assert(fn);
    raise_counter(counter, 1);
    put_or_stop(&jobs->lane, &(job){.fn = fn, .user = user, .counter = counter}, "for the GPU lane");
    if (runs_inline(jobs))
        drain_inline(jobs);
    else if (atomic_load(&jobs->parked) & 1)
        wake(jobs, KD_GPU_LANE);
}

/* ---- jobs after a counter ---- */

/* Under after_lock: get a place for one job more. NULL when memory is out. */
static job_after *after_get(kd_jobs *jobs) {
    if (!jobs->after_free) {
        after_block *block = malloc(sizeof *block);
        if (!block)
            return NULL;
        block->older = jobs->after_blocks;
        jobs->after_blocks = block;
        for (uint32_t i = 0; i < AFTER_BLOCK; i++)
            block->items[i].next = i + 1 < AFTER_BLOCK ? &block->items[i + 1] : NULL;
        jobs->after_free = block->items;
    }
    job_after *after = jobs->after_free;
    jobs->after_free = after->next;
    return after;
}

/* Hang the job into the list at `before`. False when that is zero, or memory is out. */
static bool hold_back(kd_jobs *jobs, kd_job_counter *before, const job *j) {
    pthread_mutex_lock(&jobs->after_lock);
    uint32_t pending = atomic_load(&before->pending);
    job_after *after = pending ? after_get(jobs) : NULL;
    while (after && pending && !atomic_compare_exchange_weak(&before->pending, &pending, pending | HAS_AFTER))
        ;
    bool held = after && pending;
    if (after) { /* the bit keeps who lowers it out until the lock is given back */
        job_after **list = held ? &before->after : &jobs->after_free;
        *after = (job_after){*j, *list};
        *list = after;
    }
    pthread_mutex_unlock(&jobs->after_lock);
    return held;
}

/* Let jobs go that waited. The newest comes first in the list and so is taken last. */
static void release(kd_jobs *jobs, job_after *after) {
    job_after *last = NULL;
    for (job_after *a = after; a; a = a->next) {
        enqueue(jobs, &a->waiting);
        last = a;
    }
    pthread_mutex_lock(&jobs->after_lock);
    if (last) {
        last->next = jobs->after_free;
        jobs->after_free = after;
    }
    pthread_mutex_unlock(&jobs->after_lock);
    if (runs_inline(jobs))
        drain_inline(jobs);
}

void kd_jobs_run_after(kd_jobs *jobs, kd_job_counter *before, kd_job_fn *fn, void *user,
                       kd_job_counter *counter) {
    job j = {.fn = fn, .user = user, .counter = counter};
    assert(fn && before != counter);
    raise_counter(counter, 1);
    if (hold_back(jobs, before, &j))
        return;
    kd_jobs_wait(jobs, before); /* returns at once, or memory is out */
    enqueue(jobs, &j);
    if (runs_inline(jobs))
        drain_inline(jobs);
}

/* ---- parallel_for: lazy binary splitting (Tzannes et al. 2010) ---- */

/* Work through [begin, end) grain by grain. Whenever our deque is empty (somebody took what we offered, or
 * nothing is on offer yet), offer the upper half of what remains: without a thief there are as many jobs as
 * halvings, not as grains. */
static void run_piece(kd_jobs *jobs, job_worker *w, const job *piece) {
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

static void split(kd_jobs *jobs, split_frame *frame, uint32_t begin, uint32_t end) {
    job piece = {.user = frame, .counter = &frame->counter, .range = begin | (uint64_t)end << 32};
    if (is_worker(jobs))
        run_piece(jobs, &jobs->workers[kd_jobs_worker(jobs)], &piece);
    else
        submit(jobs, &piece);
    kd_jobs_wait(jobs, &frame->counter);
}

/* Run the first share of a long loop and judge by it whether the rest is worth splitting. Returns how many
 * indices are done. */
static uint32_t probe(const split_frame *frame, uint32_t count, uint32_t worker) {
    uint32_t share = count / PROBE_SHARE;
    uint64_t begin_ns = kd_clock_ns();
    frame->fn(frame->user, 0, share, worker);
    uint64_t took_ns = kd_clock_ns() - begin_ns;
    if (took_ns * PROBE_SHARE >= INLINE_NS)
        return share;
    frame->fn(frame->user, share, count, worker);
    return count;
}

void kd_jobs_parallel_for(kd_jobs *jobs, uint32_t count, uint32_t grain, kd_range_fn *fn, void *user) {
    split_frame frame = {.fn = fn, .user = user, .grain = grain};
    uint32_t worker = kd_jobs_worker(jobs), done = 0;
    bool inside = is_worker(jobs);
    if (grain == 0)
        frame.grain = count / (jobs->threads * PIECES_PER_WORKER) + 1;
    if (inside && count > 0 && (jobs->threads == 1 || count <= frame.grain)) {
        fn(user, 0, count, worker);
        return;
    }
    if (inside && grain == 0 && count >= PROBE_SHARE)
        done = probe(&frame, count, worker);
    if (done < count)
        split(jobs, &frame, done, count);
}

/* ---- making and destroying ---- */

static bool init_worker(kd_jobs *jobs, uint32_t index) {
    job_worker *w = &jobs->workers[index];
    w->jobs = jobs;
    w->index = index;
    memset(w->seen_top, 0xFF, sizeof w->seen_top); /* -1: nothing seen */
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->signal, NULL);
    return job_deque_init(&w->deque, DEQUE_SIZE);
}

static bool init_queues(kd_jobs *jobs) {
    pthread_mutex_init(&jobs->after_lock, NULL);
    pthread_mutex_init(&jobs->outside_lock, NULL);
    pthread_cond_init(&jobs->outside_signal, NULL);
    bool ok = job_queue_init(&jobs->lane, QUEUE_SIZE);
    ok = job_queue_init(&jobs->first, QUEUE_SIZE) && ok;
    return job_queue_init(&jobs->inbox, QUEUE_SIZE) && ok;
}

static void fini_queues(kd_jobs *jobs) {
    for (after_block *block = jobs->after_blocks; block;) {
        after_block *older = block->older;
        free(block);
        block = older;
    }
    job_queue_fini(&jobs->lane);
    job_queue_fini(&jobs->first);
    job_queue_fini(&jobs->inbox);
    pthread_mutex_destroy(&jobs->after_lock);
    pthread_mutex_destroy(&jobs->outside_lock);
    pthread_cond_destroy(&jobs->outside_signal);
}

static bool start_worker(job_worker *w) {
    return pthread_create(&w->thread, NULL, worker_main, w) == 0;
}

static uint32_t processor_count(void) {
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online < 1 ? 1 : online > MAX_WORKERS ? MAX_WORKERS : (uint32_t)online;
}

kd_jobs *kd_jobs_make(uint32_t threads) {
    threads = threads == 0 ? processor_count() : threads > MAX_WORKERS ? MAX_WORKERS : threads;
    size_t size = sizeof(kd_jobs) + threads * sizeof(job_worker);
    kd_jobs *jobs = aligned_alloc(128, (size + 127) / 128 * 128);
    if (!jobs)
        return NULL;
    memset(jobs, 0, size);
    jobs->threads = threads;
    jobs->owner = &job_thread;
    bool ok = init_queues(jobs);
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

void kd_jobs_destroy(kd_jobs *jobs) {
    if (!jobs)
        return;
    atomic_store(&jobs->stop, true);
    for (uint32_t i = 1; i < jobs->threads; i++)
        wake(jobs, i);
    kd_jobs_wait(jobs, &jobs->alive);
    for (uint32_t i = 1; i < jobs->started; i++)
        pthread_join(jobs->workers[i].thread, NULL);
    drain_inline(jobs);
    for (uint32_t i = 0; i < jobs->threads; i++) {
        job_deque_fini(&jobs->workers[i].deque);
        pthread_mutex_destroy(&jobs->workers[i].lock);
        pthread_cond_destroy(&jobs->workers[i].signal);
    }
    fini_queues(jobs);
    free(jobs);
}
