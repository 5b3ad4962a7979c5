/* Walking a query: table by table, or where changes or terms beside the tables narrow it, run by run.
 *
 * An iterator remembers the world's structure number. Whatever changes structure raises it, so an iterator
 * that goes on afterwards is caught, and one that was abandoned by a break leaves nothing behind. */

#include <assert.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/watch.h"

uint64_t kd_world_version(const kd_world *w)
{
    return atomic_fetch_add_explicit(&((kd_world *)(uintptr_t)w)->version, 1, memory_order_relaxed);
}

static inline uint64_t version_now(const kd_world *w)
{
    return atomic_load_explicit(&((kd_world *)(uintptr_t)w)->version, memory_order_relaxed);
}

kd_iter ecs_query_iter(kd_query *q)
{
    return (kd_iter){.query = q, .internal = {NULL, (void *)(uintptr_t)q->world->structure, q->matches}};
}

kd_iter kd_query_iter(kd_query *q)
{
    if (ecs_watching && ecs_watching->active)
        ecs_watch_query(q);
    return ecs_query_iter(q);
}

static __attribute__((noinline, cold)) bool structure_changed(const kd_iter *it)
{
    kd_log(KD_LOG_ERROR,
           "query %s: %s changed the world while it was iterated; record the change with kd_commands",
           it->query->name ? it->query->name : "without a name", it->query->world->last_change);
    assert(false && "structure changed while a query was iterated; record the change with kd_commands");
    return false;
}

void ecs_iter_show(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end)
{
    const kd_query *q = it->query;
    const ecs_table *t = m->table;
    it->count = end - begin;
    it->next_row = end;
    it->marked = 0;
    it->entities = ecs_entities(t) + begin;
    it->parents = t->depth ? ecs_parents(t) + begin : NULL;
    for (uint32_t i = 0; i < q->term_count; i++) {
        const ecs_column *c = &t->columns[m->columns[i]];
        it->columns[i] = c->data ? c->data + (size_t)begin * c->size : NULL;
    }
    it->internal[0] = (void *)(uintptr_t)m;
}

/* The same for all rows, and with nothing to decide: what a loop over many small tables waits for. */
static inline void show_table(kd_iter *it, ecs_match *m, const ecs_table *t)
{
    const kd_query *q = it->query;
    uint64_t marks = __atomic_load_n(&m->marks, __ATOMIC_RELAXED);
    it->count = it->next_row = t->count;
    it->marked = marks >> KD_MAX_TERMS == version_now(q->world) ? (uint16_t)marks : 0;
    it->entities = ecs_entities(t);
    it->parents = (kd_entity *)(void *)t->columns[t->parents].data;
    for (uint32_t i = 0; i < q->term_count; i++)
        it->columns[i] = t->columns[m->columns[i]].data;
}

/* Does an accessed column bear a version after `since` in this word (0: of the whole table, 1 + i: of chunk
 * i), or have rows come or moved? */
static bool word_changed(const kd_query *q, const ecs_match *m, uint32_t word, uint64_t since)
{
    const ecs_table *t = m->table;
    if (__atomic_load_n(&t->versions[word], __ATOMIC_RELAXED) > since)
        return true;
    for (uint32_t i = 0; i < q->term_count; i++) {
        uint32_t c = m->columns[i];
        if (c < t->column_count && __atomic_load_n(&ecs_versions(t, c)[word], __ATOMIC_RELAXED) > since)
            return true;
    }
    return false;
}

/* Newest change to a component beside the tables; NULL when it was never used. */
static const uint64_t *version_beside(const kd_query *q, uint32_t term)
{
    ecs_side *s = ecs_side_of(q->world, q->ids[term]);
    ecs_relation *r = ecs_relation_of(q->world, q->ids[term]);
    return s ? &s->version : r ? &r->version : NULL;
}

static bool sparse_changed(const kd_query *q, uint64_t since)
{
    for (uint32_t i = 0; i < q->term_count; i++) {
        const uint64_t *version = q->sparse_terms >> i & 1 ? version_beside(q, i) : NULL;
        if (version && __atomic_load_n(version, __ATOMIC_RELAXED) > since)
            return true;
    }
    return false;
}

/* The next run of changed chunks of the table, from row next_row on. */
static bool next_changed_run(const kd_iter *it, const ecs_match *m, uint32_t *begin, uint32_t *until)
{
    const kd_query *q = it->query;
    uint32_t count = m->table->count, chunks = (count + ECS_CHUNK_ROWS - 1) / ECS_CHUNK_ROWS;
    if (sparse_changed(q, it->changed_since)) {
        *begin = it->next_row;
        *until = count;
        return true;
    }
    if (!word_changed(q, m, 0, it->changed_since))
        return false;
    uint32_t first = it->next_row / ECS_CHUNK_ROWS;
    while (first < chunks && !word_changed(q, m, 1 + first, it->changed_since))
        first++;
    if (first == chunks)
        return false;
    uint32_t end = first + 1;
    while (end < chunks && word_changed(q, m, 1 + end, it->changed_since))
        end++;
    *begin = first * ECS_CHUNK_ROWS > it->next_row ? first * ECS_CHUNK_ROWS : it->next_row;
    *until = end == chunks ? count : end * ECS_CHUNK_ROWS;
    return true;
}

/* Show the next rows of the table that are to be seen, as far as changes or row terms narrow them. */
static bool next_narrowed(kd_iter *it, const ecs_match *m)
{
    const kd_query *q = it->query;
    uint32_t limit = it->row_limit ? it->row_limit : m->table->count, begin = it->next_row, end = limit;
    while (begin < end) {
        if (it->changed_since && !next_changed_run(it, m, &begin, &end))
            return false;
        if (!q->row_terms) {
            ecs_iter_show(it, m, begin, end);
            return true;
        }
        if (ecs_iter_row_run(it, m, begin, end))
            return true;
        it->next_row = begin = end;
        end = limit;
    }
    return false;
}

void ecs_iter_limit(kd_iter *it, uint32_t match, uint32_t begin, uint32_t end)
{
    it->next_table = match;
    it->next_row = begin;
    it->row_limit = end;
}

bool ecs_iter_next_limited(kd_iter *it)
{
    return it->next_row < it->row_limit && next_narrowed(it, &it->query->matches[it->next_table]);
}

bool ecs_iter_chunk_changed(const kd_iter *it, const ecs_match *m, uint32_t chunk)
{
    return !it->changed_since || sparse_changed(it->query, it->changed_since) ||
           word_changed(it->query, m, 1 + chunk, it->changed_since);
}

static bool next_narrowed_table(kd_iter *it)
{
    const kd_query *q = it->query;
    if (q->row_terms && ecs_query_lacks_values(q))
        it->next_table = q->match_count;
    else if (q->relation_terms && ecs_iter_is_led(it))
        return ecs_iter_next_led(it);
    for (; it->next_table < q->match_count; it->next_table++, it->next_row = 0)
        if (it->next_row < q->matches[it->next_table].table->count &&
            next_narrowed(it, &q->matches[it->next_table]))
            return true;
    it->count = 0;
    return false;
}

bool kd_iter_next(kd_iter *it)
{
    const kd_query *q = it->query;
    if ((uintptr_t)q->world->structure != (uintptr_t)it->internal[1])
        return structure_changed(it);
    if (it->changed_since || q->row_terms)
        return next_narrowed_table(it);
    ecs_match *m = it->internal[2], *end = q->matches + q->match_count;
    for (; m < end; m++) {
        const ecs_table *t = m->table;
        if (!t->count)
            continue;
        if (m + 1 < end) { /* small tables are bound by reaching the next one */
            __builtin_prefetch(m[1].table);
            __builtin_prefetch(m[1].table->columns);
        }
        it->internal[0] = m;
        it->internal[2] = m + 1;
        show_table(it, m, t);
        return true;
    }
    it->internal[2] = end;
    it->count = 0;
    return false;
}

/* ---- access ---- */
void ecs_iter_check(const kd_iter *it, uint32_t index, size_t size)
{
    const kd_query *q = it->query;
    assert(index < q->term_count && "no such term");
    assert(ecs_term_accessed(q->kinds[index]) && "the term is WITH or WITHOUT: it has no column");
    assert((!it->columns[index] || q->world->components[q->ids[index]].size == size) &&
           "the term is of another type");
    (void)q, (void)index, (void)size;
}

static bool may_write(const kd_query *q, uint32_t index)
{
    if (q->kinds[index] == KD_TERM_WRITE || q->kinds[index] == KD_TERM_OPTIONAL_WRITE)
        return true;
    kd_log(KD_LOG_ERROR,
           "%s%s%squery %s: component %s is written but declared as read; declare it with KD_WRITE",
           ecs_watching ? "system " : "", ecs_watching ? ecs_watching->system : "", ecs_watching ? ": " : "",
           q->name ? q->name : "without a name", q->world->components[q->ids[index]].desc->name);
    assert(false && "a column declared as read was asked for to write");
    return false;
}

/* Note in the match that all rows of the table bear this version in the term's column. Rows that come later
 * bear it too, in column 0. A note that gets lost to another thread's only costs a second stamp. */
static void note_mark(ecs_match *m, uint32_t index, uint64_t version)
{
    uint64_t marks = __atomic_load_n(&m->marks, __ATOMIC_RELAXED);
    uint64_t kept = marks >> KD_MAX_TERMS == version ? marks : version << KD_MAX_TERMS;
    __atomic_store_n(&m->marks, kept | (uint64_t)1 << index, __ATOMIC_RELAXED);
}

void *ecs_iter_mark(kd_iter *it, uint32_t index)
{
    const kd_query *q = it->query;
    assert(index < q->term_count && "no such term");
    if (index >= q->term_count || !may_write(q, index))
        return NULL;
    ecs_match *m = it->internal[0];
    uint32_t c = m->columns[index], first = it->next_row - it->count;
    if (q->relation_terms >> index & 1 && it->columns[index])
        ecs_relation_stamp(q->world, ecs_relation_of(q->world, q->ids[index]));
    else if (q->sparse_terms >> index & 1 && it->columns[index])
        ecs_side_stamp(q->world, ecs_side_of(q->world, q->ids[index]));
    if (c < m->table->column_count && it->count) {
        ecs_column_stamp(q->world, m->table, c, first, it->count);
        if (it->count == m->table->count && !q->row_terms)
            note_mark(m, index, version_now(q->world));
    }
    return it->columns[index];
}
