/* A query's rows shared among workers. Rows are numbered through all matched tables; a worker gets a stretch
 * of numbers and sees it table by table. How the stretches are cut depends on timing, so nothing may depend
 * on the cuts: commands are recorded under the number of the stretch's first row, which puts them in the
 * order of rows however they were cut. A loop under the caller's own key takes as many keys as it has rows,
 * and the caller goes on behind them. */

#include <assert.h>

#include "runtime/core/clock.h"
#include "runtime/ecs/internal.h"
#include "runtime/ecs/watch.h"
#include "runtime/jobs/jobs.h"

#define FEW_TABLES 256u
#define FEW_LINES  256u
#define TRIED_PART 8u
#define SHORT_NS   10000u /* about the price of waking a second thread */
/* Of 4-byte values a cache line: workers are given whole lines, so as not to fight for one. */
#define LINE_ROWS 16u

typedef struct parallel {
    kd_query *query;
    kd_rows_fn *fn;
    void *user;
    uint64_t key;
    uint32_t total, done;   /* rows; lines done before the rest was shared */
    const uint32_t *starts; /* [match_count + 1]: number of each table's first row, then of all rows */
} parallel;

static uint32_t number_rows(const kd_query *q, uint32_t *starts)
{
    uint64_t total = 0;
    for (uint32_t i = 0; i < q->match_count; i++) {
        starts[i] = (uint32_t)total;
        total += q->matches[i].table->count;
    }
    assert(total <= UINT32_MAX);
    starts[q->match_count] = (uint32_t)total;
    return (uint32_t)total;
}

/* The last table that begins at or before this number: the one that has it, empty ones being passed. */
static uint32_t table_at(const parallel *p, uint32_t number)
{
    uint32_t low = 0, high = p->query->match_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (p->starts[middle] <= number)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void visit(const parallel *p, uint32_t begin, uint32_t end, kd_commands *c)
{
    for (uint32_t table = table_at(p, begin); begin < end; table++) {
        uint32_t first = p->starts[table], until = p->starts[table + 1] < end ? p->starts[table + 1] : end;
        if (begin >= until)
            continue;
        kd_iter it = ecs_query_iter(p->query);
        ecs_iter_limit(&it, table, begin - first, until - first);
        while (ecs_iter_next_limited(&it))
            p->fn(&it, c, p->user);
        begin = until;
    }
}

static void run_range(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    const parallel *p = user;
    kd_commands *c = kd_world_commands(p->query->world, worker);
    uint64_t key = c->key; /* of whatever this worker does meanwhile: it may be helping out */
    uint32_t last = end * LINE_ROWS < p->total ? end * LINE_ROWS : p->total;
    c->key = p->key + begin * LINE_ROWS;
    visit(p, begin * LINE_ROWS, last, c);
    c->key = key;
}

/* A loop that is too short for kd_jobs_parallel_for to try it out: time its first part here. Returns the
 * lines done, which are all of them when the rest is not worth another thread either. */
static uint32_t try_out(parallel *p, uint32_t lines, uint32_t worker)
{
    uint32_t part = (lines + TRIED_PART - 1) / TRIED_PART;
    uint64_t begun = kd_clock_ns();
    run_range(p, 0, part, worker);
    if ((kd_clock_ns() - begun) * TRIED_PART >= SHORT_NS)
        return part;
    if (part < lines)
        run_range(p, part, lines, worker);
    return lines;
}

static void run_rest(void *user, uint32_t begin, uint32_t end, uint32_t worker)
{
    const parallel *p = user;
    run_range(user, begin + p->done, end + p->done, worker);
}

static void run_all(parallel *p, kd_jobs *jobs, uint32_t lines)
{
    uint32_t worker = kd_jobs_worker(jobs);
    if (!jobs || kd_jobs_threads(jobs) == 1) {
        run_range(p, 0, lines, worker);
        return;
    }
    if (lines < FEW_LINES)
        p->done = try_out(p, lines, worker);
    if (p->done < lines)
        kd_jobs_parallel_for(jobs, lines - p->done, 0, run_rest, p);
}

/* Run the loop, and let what the caller records next come behind what its rows recorded. */
static void run_in_order(parallel *p, kd_jobs *jobs)
{
    kd_commands *own = kd_world_commands(p->query->world, kd_jobs_worker(jobs));
    bool is_own = ecs_key_follows(own->key, p->key);
    p->key = is_own ? own->key : p->key;
    run_all(p, jobs, (p->total + LINE_ROWS - 1) / LINE_ROWS);
    if (is_own)
        own->key = p->key + p->total;
}

kd_status kd_query_parallel(kd_query *q, struct kd_jobs *jobs, uint64_t command_key, kd_rows_fn *fn,
                            void *user)
{
    uint32_t few[FEW_TABLES + 1], *starts = few;
    kd_world *w = q->world;
    if (ecs_watching && ecs_watching->active)
        ecs_watch_query(q);
    if (q->match_count > FEW_TABLES)
        starts = ecs_grow(w, NULL, 0, (q->match_count + 1) * sizeof *starts);
    if (!starts)
        return KD_NO_MEMORY;
    parallel p = {q, fn, user, command_key, number_rows(q, starts), 0, starts};
    uint64_t structure = w->structure;
    if (p.total)
        run_in_order(&p, jobs);
    assert(structure == w->structure &&
           "structure changed in kd_query_parallel; record the change with kd_commands");
    (void)structure;
    if (starts != few)
        ecs_free(w, starts);
    return KD_OK;
}
