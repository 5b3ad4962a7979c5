/* parallel_for: lazy binary splitting (Tzannes et al. 2010). */
#include "runtime/core/clock.h"
#include "runtime/jobs/pool.h"

enum {
    PIECES_PER_WORKER = 16, /* of a loop with automatic grain */
    PROBE_SHARE = 256,      /* of such a loop's indices, one share is timed before anything is offered */
    INLINE_NS = 10000,      /* a loop shorter than a wake-up gains nothing from a second thread */
};

/* The frame of one parallel_for; its pieces are jobs with fn == NULL. */
typedef struct split_frame {
    kd_range_fn *fn;
    void *user;
    uint32_t grain, label;
    kd_job_counter counter;
} split_frame;

uint32_t jobs_piece_label(const job *piece)
{
    return ((const split_frame *)piece->user)->label;
}

/* Work through [begin, end) grain by grain. Whenever our deque is empty (somebody took what we offered, or
 * nothing is on offer yet), offer the upper half of what remains: without a thief there are as many jobs as
 * halvings, not as grains. */
void jobs_run_piece(kd_jobs *jobs, job_worker *w, const job *piece)
{
    split_frame *frame = piece->user;
    uint32_t begin = (uint32_t)piece->range, end = (uint32_t)(piece->range >> 32);
    while (begin < end) {
        while (end - begin > frame->grain && job_deque_is_empty(&w->deque)) {
            uint32_t middle = begin + (end - begin) / 2;
            jobs_submit(
                jobs,
                &(job){.user = frame, .counter = &frame->counter, .range = middle | (uint64_t)end << 32});
            end = middle;
        }
        uint32_t stop = end - begin > frame->grain ? begin + frame->grain : end;
        frame->fn(frame->user, begin, stop, w->index);
        begin = stop;
    }
}

/* On this thread alone, in order. */
static void run_here(const split_frame *frame, uint32_t count, uint32_t worker)
{
    for (uint32_t begin = 0, share; begin < count; begin += share) {
        share = count - begin < frame->grain ? count - begin : frame->grain;
        frame->fn(frame->user, begin, begin + share, worker);
    }
}

static void split(kd_jobs *jobs, split_frame *frame, uint32_t begin, uint32_t end)
{
    job piece = {.user = frame, .counter = &frame->counter, .range = begin | (uint64_t)end << 32};
    if (jobs_is_worker(jobs))
        jobs_run_piece(jobs, &jobs->workers[kd_jobs_worker(jobs)], &piece);
    else
        jobs_submit(jobs, &piece);
    kd_jobs_wait(jobs, &frame->counter);
}

/* Run the first share of a long loop and judge by it whether the rest is worth splitting. Returns how many
 * indices are done. */
static uint32_t probe(const split_frame *frame, uint32_t count, uint32_t worker)
{
    uint32_t share = count / PROBE_SHARE;
    uint64_t begin_ns = kd_clock_ns();
    frame->fn(frame->user, 0, share, worker);
    uint64_t took_ns = kd_clock_ns() - begin_ns;
    if (took_ns * PROBE_SHARE >= INLINE_NS)
        return share;
    frame->fn(frame->user, share, count, worker);
    return count;
}

void kd_jobs_parallel_for(kd_jobs *jobs, uint32_t count, uint32_t grain, kd_range_fn *fn, void *user)
{
    split_frame frame = {.fn = fn, .user = user, .grain = grain};
    uint32_t worker = kd_jobs_worker(jobs), done = 0;
    bool inside = jobs_is_worker(jobs);
    frame.label = inside ? jobs->workers[worker].label : 0;
    if (grain == 0)
        frame.grain = count / (jobs->threads * PIECES_PER_WORKER) + 1;
    if (inside && (jobs->threads == 1 || count <= frame.grain)) {
        frame.grain = grain ? grain : count;
        run_here(&frame, count, worker);
        return;
    }
    if (inside && grain == 0 && count >= PROBE_SHARE)
        done = probe(&frame, count, worker);
    if (done < count)
        split(jobs, &frame, done, count);
}
