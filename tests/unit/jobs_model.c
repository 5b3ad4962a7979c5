/* Every execution that C11's memory model allows to a few operations on the deque. The code under test is
 * deque.h itself: its atomics are replaced by steps of a model, which an explorer interleaves in all ways.
 *
 * The model. A memory cell is the list of all writes to it. Each thread has a view: how far into each list it
 * must have seen. A load may return any write from its view on, however stale; a release write carries its
 * writer's view, and who acquires it joins that. Sequentially consistent accesses happen in the order in
 * which they are explored: such a load sees at least the last such write to its cell and what such loads saw.
 * A read-modify-write takes the last write. Not modelled is a load that reads from a store which its own
 * thread could only make because of it; no implementation does that.
 *
 * A thread is run from its beginning with the results so far, up to its first new access, which is noted and
 * left by longjmp: so a state is plain data and can be copied. States seen before are not explored again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

struct job_ring;
static int64_t model_load_i64(const volatile void *p, int order);
static uint64_t model_load_u64(const volatile void *p, int order);
static struct job_ring *model_load_ring(const volatile void *p, int order);
static void model_store(const volatile void *p, uint64_t value, int order);
static bool model_exchange(const volatile void *p, int64_t *expected, int64_t desired, int order);
static void *model_malloc(size_t size);

#undef atomic_load_explicit
#undef atomic_store_explicit
#undef atomic_compare_exchange_strong_explicit
#undef atomic_load
#undef atomic_init
#define atomic_load_explicit(p, order)                                                                       \
    _Generic((p),                                                                                            \
        _Atomic int64_t *: model_load_i64,                                                                   \
        _Atomic uint64_t *: model_load_u64,                                                                  \
        _Atomic(struct job_ring *) *: model_load_ring)((p), (order))
#define atomic_load(p)                         atomic_load_explicit((p), memory_order_seq_cst)
#define atomic_store_explicit(p, value, order) model_store((p), (uint64_t)(uintptr_t)(value), (order))
#define atomic_init(p, value)                  atomic_store_explicit((p), (value), memory_order_relaxed)
#define atomic_compare_exchange_strong_explicit(p, expected, desired, order, failure)                        \
    ((void)(failure), model_exchange((p), (expected), (desired), (order)))
#define malloc model_malloc
#include "runtime/jobs/deque.h"
#undef malloc

enum {
    THREADS = 3,
    SMALL = 2, /* slots of the first ring, so that slots are used again and the ring grows */
    LARGE = 4,
    TOP = 0,
    BOTTOM = 1,
    RING = 2,
    SLOTS = 3, /* two words of each slot are cells: enough to notice a torn job */
    CELLS = SLOTS + 2 * (SMALL + LARGE),
    MAX_WRITES = 24,
    MAX_STEPS = 80,
    MAX_JOBS = 8,
    SEEN_BITS = 22,
};

typedef struct view {
    uint8_t at[CELLS];
} view;

typedef struct cell_write {
    uint64_t value;
    view carried; /* what acquiring it brings */
} cell_write;

typedef struct step_result {
    uint64_t value;
    bool ok;
} step_result;

typedef struct thread_state {
    view seen;
    uint32_t steps;
    step_result results[MAX_STEPS];
} thread_state;

typedef struct model_state {
    cell_write writes[CELLS][MAX_WRITES];
    uint8_t count[CELLS];
    view consistent; /* lower bound for sequentially consistent loads */
    thread_state threads[THREADS];
} model_state;

typedef enum step_kind { STEP_LOAD, STEP_STORE, STEP_EXCHANGE } step_kind;

typedef struct step {
    step_kind kind;
    int cell, order;
    uint64_t value, expected;
} step;

/* How the orders are spoilt, to show that the model notices. */
typedef enum flaw {
    FLAW_NONE,
    FLAW_NOT_CONSISTENT,   /* seq_cst counts as acquire and release */
    FLAW_NO_RELEASE,       /* stores carry nothing */
    FLAW_RING_NOT_ACQUIRED /* thieves read the ring's address relaxed */
} flaw;

static job_deque deque;
static alignas(64) unsigned char ring_memory[2][sizeof(job_ring) + LARGE * sizeof(job_slot)];
static const char *programs[THREADS];
static flaw spoilt;
static uint64_t *seen_states, state_count;
static uint32_t errors;

/* The thread that is being run again. */
static const thread_state *replayed;
static uint32_t position;
static step next_step;
static jmp_buf stopped;
static int rings_made;
static uint64_t taken[MAX_JOBS * THREADS];
static uint32_t taken_count;

/* ---- accesses of the deque ---- */

/* Number of the cell at an address; -1 for the words of a slot that the model leaves out. */
static int cell_at(const volatile void *p)
{
    if (p == &deque.top)
        return TOP;
    if (p == &deque.bottom)
        return BOTTOM;
    if (p == &deque.ring)
        return RING;
    for (int ring = 0; ring < 2; ring++)
        for (int i = 0; i < (ring ? LARGE : SMALL); i++) {
            job_slot *slot = &((job_ring *)(void *)ring_memory[ring])->slots[i];
            if (p == &slot->words[0] || p == &slot->words[3])
                return SLOTS + 2 * (ring * SMALL + i) + (p == &slot->words[3]);
        }
    return -1;
}

static step_result perform(step s)
{
    if (s.cell < 0)
        return (step_result){0, false};
    if (position == replayed->steps) {
        next_step = s;
        longjmp(stopped, 1);
    }
    return replayed->results[position++];
}

static uint64_t model_load_u64(const volatile void *p, int order)
{
    return perform((step){STEP_LOAD, cell_at(p), order, 0, 0}).value;
}

static int64_t model_load_i64(const volatile void *p, int order)
{
    return (int64_t)model_load_u64(p, order);
}

static struct job_ring *model_load_ring(const volatile void *p, int order)
{
    return (struct job_ring *)(uintptr_t)model_load_u64(p, order);
}

static void model_store(const volatile void *p, uint64_t value, int order)
{
    perform((step){STEP_STORE, cell_at(p), order, value, 0});
}

static bool model_exchange(const volatile void *p, int64_t *expected, int64_t desired, int order)
{
    step_result r = perform((step){STEP_EXCHANGE, cell_at(p), order, (uint64_t)desired, (uint64_t)*expected});
    *expected = (int64_t)r.value;
    return r.ok;
}

static void *model_malloc(size_t size)
{
    assert_true(rings_made < 2 && size <= sizeof ring_memory[0]);
    return ring_memory[rings_made++];
}

/* ---- programs: p push, t take, s steal ---- */

static job numbered(uint64_t number)
{
    return (job){.fn = (kd_job_fn *)(uintptr_t)number, .range = ~number};
}

static void note_taken(const job *j)
{
    uint64_t number = (uint64_t)(uintptr_t)j->fn;
    taken[taken_count++] = number == ~j->range ? number : 0; /* 0: torn, or never written */
}

static void run_program(const char *program)
{
    uint64_t pushed = 0;
    for (const char *p = program; *p; p++) {
        job j;
        int64_t top;
        if (*p == 'p') {
            j = numbered(++pushed);
            job_deque_push(&deque, &j);
        } else if (*p == 't') {
            if (job_deque_take(&deque, &j))
                note_taken(&j);
        } else if (job_deque_look(&deque, &top) > 0 && job_deque_steal(&deque, top, &j)) {
            note_taken(&j);
        }
    }
}

/* Run thread t up to its next access. False when it has ended; what it took is added to `taken`. */
static bool find_step(const model_state *s, int t, step *next)
{
    replayed = &s->threads[t];
    position = 0;
    rings_made = 1;
    deque.known_top = 0;
    uint32_t taken_before = taken_count;
    if (setjmp(stopped)) {
        taken_count = taken_before;
        *next = next_step;
        return true;
    }
    run_program(programs[t]);
    return false;
}

/* ---- the memory model ---- */

static bool is_consistent(const step *s)
{
    return s->order == memory_order_seq_cst && spoilt != FLAW_NOT_CONSISTENT;
}

static bool acquires(const step *s)
{
    return s->order != memory_order_relaxed && s->order != memory_order_release &&
           !(spoilt == FLAW_RING_NOT_ACQUIRED && s->cell == RING);
}

static bool releases(const step *s)
{
    return s->order != memory_order_relaxed && s->order != memory_order_acquire && spoilt != FLAW_NO_RELEASE;
}

static void join(view *a, const view *b)
{
    for (int i = 0; i < CELLS; i++)
        a->at[i] = a->at[i] > b->at[i] ? a->at[i] : b->at[i];
}

static void finish_step(thread_state *t, uint64_t value, bool ok)
{
    assert_true(t->steps < MAX_STEPS);
    t->results[t->steps++] = (step_result){value, ok};
}

/* Read write number `at`. */
static void do_load(model_state *s, int thread, const step *a, uint8_t at, bool ordered)
{
    thread_state *t = &s->threads[thread];
    const cell_write *w = &s->writes[a->cell][at];
    t->seen.at[a->cell] = at;
    if (ordered && acquires(a))
        join(&t->seen, &w->carried);
    if (ordered && is_consistent(a) && at > s->consistent.at[a->cell])
        s->consistent.at[a->cell] = at;
    finish_step(t, w->value, false);
}

static void do_write(model_state *s, int thread, const step *a, const view *inherited)
{
    thread_state *t = &s->threads[thread];
    uint8_t at = s->count[a->cell]++;
    cell_write *w = &s->writes[a->cell][at];
    assert_true(at < MAX_WRITES);
    t->seen.at[a->cell] = at;
    *w = (cell_write){.value = a->value};
    if (releases(a))
        w->carried = t->seen;
    if (inherited) /* a read-modify-write continues the release sequence */
        join(&w->carried, inherited);
    if (is_consistent(a))
        s->consistent.at[a->cell] = at;
}

/* ---- exploring ---- */

static uint64_t hash_state(const model_state *s)
{
    const unsigned char *bytes = (const unsigned char *)s;
    uint64_t h = 1469598103934665603u, word;
    for (size_t i = 0; i + 8 <= sizeof *s; i += 8) {
        memcpy(&word, bytes + i, 8);
        h = (h ^ word) * 0x9E3779B97F4A7C15u;
        h ^= h >> 29;
    }
    return h | 1;
}

/* False when the state was explored before. */
static bool enter(const model_state *s)
{
    uint64_t h = hash_state(s), mask = ((uint64_t)1 << SEEN_BITS) - 1;
    for (uint64_t i = h >> 20;; i++) {
        if (seen_states[i & mask] == h)
            return false;
        if (seen_states[i & mask] == 0) {
            seen_states[i & mask] = h;
            assert_true(++state_count < mask / 2);
            return true;
        }
    }
}

/* All threads have ended: every job was taken once, or is still there. */
static void check_end(const model_state *s)
{
    uint32_t pushed = 0, count[MAX_JOBS + 1] = {0};
    for (const char *p = programs[0]; *p; p++)
        pushed += *p == 'p';
    for (uint32_t i = 0; i < taken_count; i++)
        count[taken[i] <= pushed ? taken[i] : 0]++;
    uint64_t top = s->writes[TOP][s->count[TOP] - 1].value;
    uint64_t bottom = s->writes[BOTTOM][s->count[BOTTOM] - 1].value;
    const job_ring *ring = (const job_ring *)(uintptr_t)s->writes[RING][s->count[RING] - 1].value;
    for (uint64_t i = top; i < bottom && i < top + MAX_JOBS; i++) {
        int cell = cell_at(&ring->slots[i & (uint64_t)(ring->size - 1)].words[0]);
        uint64_t number = s->writes[cell][s->count[cell] - 1].value;
        count[number <= pushed ? number : 0]++;
    }
    for (uint32_t i = 0; i <= pushed; i++)
        errors += count[i] != (i > 0);
}

static void explore(const model_state *s);

static void explore_load(const model_state *s, int t, const step *a, bool failed_exchange)
{
    uint8_t from = s->threads[t].seen.at[a->cell];
    bool ordered = !failed_exchange;
    if (ordered && is_consistent(a) && s->consistent.at[a->cell] > from)
        from = s->consistent.at[a->cell];
    for (uint8_t at = from; at < s->count[a->cell]; at++) {
        if (failed_exchange && s->writes[a->cell][at].value == a->expected)
            continue;
        model_state next = *s;
        do_load(&next, t, a, at, ordered);
        explore(&next);
    }
}

static void explore_exchange(const model_state *s, int t, const step *a)
{
    uint8_t last = (uint8_t)(s->count[a->cell] - 1);
    if (s->writes[a->cell][last].value == a->expected) {
        model_state next = *s;
        thread_state *thread = &next.threads[t];
        view carried = next.writes[a->cell][last].carried;
        thread->seen.at[a->cell] = last;
        if (acquires(a))
            join(&thread->seen, &carried);
        do_write(&next, t, a, &carried);
        finish_step(thread, a->expected, true);
        explore(&next);
    }
    explore_load(s, t, a, true);
}

static void explore_step(const model_state *s, int t, const step *a)
{
    if (a->kind == STEP_LOAD) {
        explore_load(s, t, a, false);
    } else if (a->kind == STEP_EXCHANGE) {
        explore_exchange(s, t, a);
    } else {
        model_state next = *s;
        do_write(&next, t, a, NULL);
        finish_step(&next.threads[t], 0, true);
        explore(&next);
    }
}

/* The owner reading what it alone writes: no other thread's step makes a difference. */
static bool is_private(int t, const step *a)
{
    return t == 0 && a->kind == STEP_LOAD && (a->cell == BOTTOM || a->cell == RING);
}

static void explore(const model_state *s)
{
    step next[THREADS];
    bool runs[THREADS], any = false;
    if (!enter(s))
        return;
    taken_count = 0;
    for (int t = 0; t < THREADS; t++) {
        runs[t] = find_step(s, t, &next[t]);
        any = any || runs[t];
    }
    if (!any) {
        check_end(s);
    } else if (runs[0] && is_private(0, &next[0])) {
        explore_step(s, 0, &next[0]);
    } else {
        for (int t = 0; t < THREADS; t++)
            if (runs[t])
                explore_step(s, t, &next[t]);
    }
}

/* Explore all executions of an owner and up to two thieves. Returns how many ended wrong. */
static uint32_t run_model(const char *owner, const char *thief, const char *second, flaw f)
{
    static model_state start;
    memset(&start, 0, sizeof start);
    memset(seen_states, 0, sizeof *seen_states << SEEN_BITS);
    programs[0] = owner;
    programs[1] = thief;
    programs[2] = second;
    spoilt = f;
    state_count = errors = 0;
    rings_made = 0;
    job_ring *ring = job_ring_make(SMALL, NULL);
    for (int i = 0; i < CELLS; i++)
        start.count[i] = 1;
    start.writes[RING][0].value = (uint64_t)(uintptr_t)ring;
    explore(&start);
    return errors;
}

static void each_job_is_taken_once_in_every_execution(void **state)
{
    static const char *const rows[][3] = {
        {"pt", "s", ""},                            /* the last job, wanted by two */
        {"ppt", "ss", ""},                          /* the owner's job may be the thief's second */
        {"pptt", "ss", ""},     {"ptpt", "ss", ""}, /* slots used again */
        {"ppptt", "ss", ""},                        /* the ring grows under the thief */
        {"ptppp", "sss", ""},   {"ppt", "s", "s"},     {"pptt", "s", "s"},     {"pppt", "ss", "s"},
        {"pptpttt", "sss", ""}, {"ptptpt", "sss", ""}, {"pppptttt", "ss", ""},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        uint32_t wrong = run_model(rows[i][0], rows[i][1], rows[i][2], FLAW_NONE);
        print_message("owner %s, thieves %s %s: %llu states\n", rows[i][0], rows[i][1], rows[i][2],
                      (unsigned long long)state_count);
        if (wrong)
            fail_msg("owner %s, thieves %s %s: %u executions lose or double a job", rows[i][0], rows[i][1],
                     rows[i][2], wrong);
        assert_true(state_count > 20);
    }
}

static void weaker_orders_are_caught(void **state)
{
    (void)state;
    assert_int_not_equal(run_model("ppt", "ss", "", FLAW_NOT_CONSISTENT), 0);
    assert_int_not_equal(run_model("p", "s", "", FLAW_NO_RELEASE), 0);
    assert_int_not_equal(run_model("ppp", "s", "", FLAW_RING_NOT_ACQUIRED), 0);
}

static int make_seen(void **state)
{
    (void)state;
    seen_states = calloc((size_t)1 << SEEN_BITS, sizeof *seen_states);
    return seen_states ? 0 : -1;
}

static int free_seen(void **state)
{
    (void)state;
    free(seen_states);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_job_is_taken_once_in_every_execution),
        cmocka_unit_test(weaker_orders_are_caught),
    };
    return cmocka_run_group_tests(tests, make_seen, free_seen);
}
