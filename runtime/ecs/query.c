/* Queries keep a flat list of the tables they match. A table is appended when it is made, so walking a query
 * never searches; equal queries share one list and are counted. With by_depth the list is kept sorted by the
 * tables' depth.
 *
 * An iterator remembers the world's structure number. Whatever changes structure raises it, so an iterator
 * that goes on afterwards is caught, and one that was abandoned by a break leaves nothing behind. */

#include <assert.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/watch.h"

/* ---- matching ---- */
static bool accessed(uint8_t kind)
{
    return kind == KD_TERM_READ || kind == KD_TERM_WRITE || kind == KD_TERM_OPTIONAL ||
           kind == KD_TERM_OPTIONAL_WRITE || kind == KD_TERM_ANY;
}

static bool writable(uint8_t kind)
{
    return kind == KD_TERM_WRITE || kind == KD_TERM_OPTIONAL_WRITE;
}

bool ecs_query_matches(const kd_query *q, const ecs_table *t)
{
    bool any = !q->has_any;
    for (uint32_t i = 0; i < q->term_count; i++) {
        const ecs_component *c = &q->world->components[q->ids[i]];
        if (c->sparse || (c->side && q->kinds[i] == KD_TERM_WITHOUT)) { /* its rows will be asked */
            any |= q->kinds[i] == KD_TERM_ANY;
            continue;
        }
        bool here = ecs_column_of(t, q->ids[i]) != 0;
        switch (q->kinds[i]) {
        case KD_TERM_READ:
        case KD_TERM_WRITE:
        case KD_TERM_WITH:
            if (!here)
                return false;
            break;
        case KD_TERM_WITHOUT:
            if (here)
                return false;
            break;
        case KD_TERM_ANY:
            any |= here;
            break;
        default:
            break;
        }
    }
    return any;
}

static void insert_match(kd_query *q, ecs_table *t)
{
    uint32_t at = q->match_count++;
    while (q->by_depth && at && q->matches[at - 1].table->depth > t->depth) {
        q->matches[at] = q->matches[at - 1];
        at--;
    }
    ecs_match *m = &q->matches[at];
    m->table = t;
    for (uint32_t i = 0; i < q->term_count; i++)
        m->columns[i] = accessed(q->kinds[i]) ? (uint16_t)ecs_column_of(t, q->ids[i]) : 0;
}

static bool reserve_match(kd_world *w, kd_query *q)
{
    return ecs_reserve(w, &q->matches, &q->match_capacity, q->match_count, q->match_count + 1,
                       sizeof *q->matches);
}

bool ecs_queries_add_table(kd_world *w, ecs_table *t)
{
    for (kd_query *q = w->queries; q; q = q->next)
        if (!reserve_match(w, q))
            return false;
    for (kd_query *q = w->queries; q; q = q->next)
        if (ecs_query_matches(q, t))
            insert_match(q, t);
    return true;
}

/* ---- making ---- */
static void query_free(kd_world *w, kd_query *q)
{
    ecs_free(w, q->name);
    ecs_free(w, q->matches);
    ecs_free(w, q);
}

static bool fill_terms(kd_world *w, kd_query *q, const kd_query_desc *desc)
{
    q->by_depth = desc->by_depth;
    for (uint32_t i = 0; i < KD_MAX_TERMS && desc->terms[i].kind != KD_TERM_END; i++) {
        q->ids[i] = kd_component_ensure(w, desc->terms[i].desc);
        q->kinds[i] = (uint8_t)desc->terms[i].kind;
        q->has_any |= desc->terms[i].kind == KD_TERM_ANY;
        q->term_count = i + 1;
        if (!q->ids[i])
            return false;
        const ecs_component *c = &w->components[q->ids[i]];
        q->targets[i] = desc->terms[i].target;
        if (c->relation && (q->targets[i].generation & ECS_PENDING))
            q->targets[i] = kd_entity_resolve(w, q->targets[i]);
        if (q->targets[i].generation && !c->relation) {
            kd_fail(KD_UNSUPPORTED, "query %s: component %s is no relation and has no target",
                    desc->name ? desc->name : "without a name", c->desc->name);
            return false;
        }
        q->relation_terms |= (uint32_t)(c->relation != 0) << i;
        q->row_terms |= (uint32_t)(c->side != 0 || c->relation) << i;
        q->sparse_terms |= (uint32_t)(c->sparse && accessed(q->kinds[i])) << i;
    }
    return true;
}

static bool queries_equal(const kd_query *a, const kd_query *b)
{
    return a->term_count == b->term_count && a->by_depth == b->by_depth &&
           memcmp(a->kinds, b->kinds, a->term_count) == 0 &&
           memcmp(a->ids, b->ids, a->term_count * sizeof a->ids[0]) == 0 &&
           memcmp(a->targets, b->targets, a->term_count * sizeof a->targets[0]) == 0;
}

/* The lock is held. */
static kd_query *query_add(kd_world *w, const kd_query *like, const char *name)
{
    kd_query *q = ecs_grow(w, NULL, 0, sizeof *q);
    if (!q)
        return NULL;
    *q = *like;
    size_t length = name ? strlen(name) + 1 : 0;
    q->name = length ? ecs_grow(w, NULL, 0, length) : NULL;
    if (length && q->name)
        memcpy(q->name, name, length);
    bool done = !length || q->name;
    for (uint32_t i = 0; i < w->head.table_count && done; i++) {
        done = reserve_match(w, q);
        if (done && ecs_query_matches(q, w->head.tables[i]))
            insert_match(q, w->head.tables[i]);
    }
    if (!done) {
        query_free(w, q);
        return NULL;
    }
    q->next = w->queries;
    w->queries = q;
    return q;
}

kd_query *kd_query_make(kd_world *w, const kd_query_desc *desc)
{
    kd_query like = {.world = w};
    if (!fill_terms(w, &like, desc))
        return NULL;
    pthread_mutex_lock(&w->lock);
    kd_query *q = w->queries;
    while (q && !queries_equal(q, &like))
        q = q->next;
    if (!q)
        q = query_add(w, &like, desc->name);
    if (q)
        q->references++;
    pthread_mutex_unlock(&w->lock);
    return q;
}

void kd_query_destroy(kd_query *q)
{
    if (!q)
        return;
    kd_world *w = q->world;
    pthread_mutex_lock(&w->lock);
    if (--q->references == 0) {
        kd_query **link = &w->queries;
        while (*link != q)
            link = &(*link)->next;
        *link = q->next;
        query_free(w, q);
    }
    pthread_mutex_unlock(&w->lock);
}

void ecs_queries_fini(kd_world *w)
{
    while (w->queries) {
        kd_query *q = w->queries;
        w->queries = q->next;
        query_free(w, q);
    }
}

uint32_t kd_query_count(kd_query *q)
{
    uint32_t count = 0;
    if (q->row_terms) {
        for (kd_iter it = ecs_query_iter(q); kd_iter_next(&it);)
            count += it.count;
        return count;
    }
    for (uint32_t i = 0; i < q->match_count; i++)
        count += q->matches[i].table->count;
    return count;
}

uint64_t kd_world_version(const kd_world *w)
{
    return atomic_fetch_add_explicit(&((kd_world *)(uintptr_t)w)->version, 1, memory_order_relaxed);
}

/* ---- iterating ---- */
kd_iter ecs_query_iter(kd_query *q)
{
    return (kd_iter){.query = q, .internal = {NULL, (void *)(uintptr_t)q->world->structure}};
}

kd_iter kd_query_iter(kd_query *q)
{
    if (ecs_watching && ecs_watching->active)
        ecs_watch_query(q);
    return ecs_query_iter(q);
}

static bool still_valid(const kd_iter *it)
{
    const kd_world *w = it->query->world;
    if ((uintptr_t)w->structure == (uintptr_t)it->internal[1])
        return true;
    kd_log(KD_LOG_ERROR,
           "query %s: %s changed the world while it was iterated; record the change with kd_commands",
           it->query->name ? it->query->name : "without a name", w->last_change);
    assert(false && "structure changed while a query was iterated; record the change with kd_commands");
    return false;
}

static void show_rows(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end)
{
    const kd_query *q = it->query;
    const ecs_table *t = m->table;
    it->count = end - begin;
    it->next_row = end;
    it->entities = ecs_entities(t) + begin;
    it->parents = t->depth ? ecs_parents(t) + begin : NULL;
    for (uint32_t i = 0; i < q->term_count; i++) {
        uint32_t c = m->columns[i];
        if (c == 0)
            it->columns[i] = NULL;
        else if (c == ECS_TAG_COLUMN)
            it->columns[i] = q->world->tag_value;
        else
            it->columns[i] = t->columns[c].data + (size_t)begin * t->columns[c].size;
    }
    it->internal[0] = (void *)(uintptr_t)m;
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
        if (c && c != ECS_TAG_COLUMN && __atomic_load_n(&ecs_versions(t, c)[word], __ATOMIC_RELAXED) > since)
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

/* ---- rows that are asked one by one ---- */
static bool pair_present(const kd_iter *it, uint32_t term, kd_entity e, uint32_t *place)
{
    const ecs_relation *r = ecs_relation_of(it->query->world, it->query->ids[term]);
    *place = r ? ecs_pair_item(r, e, ecs_term_target(it, term)) : ECS_NONE;
    return *place != ECS_NONE;
}

/* Is the term's component there and enabled? *place: where the value of a sparse one lies. */
static bool term_present(const kd_iter *it, const ecs_table *t, uint32_t term, kd_entity e, uint32_t *place)
{
    const kd_query *q = it->query;
    uint32_t index = e.index;
    kd_component_id id = q->ids[term];
    if (q->relation_terms >> term & 1)
        return pair_present(it, term, e, place);
    const ecs_side *s = ecs_side_of(q->world, id);
    *place = ECS_NONE;
    if (!q->world->components[id].sparse)
        return ecs_column_of(t, id) && !ecs_side_disabled(s, index);
    *place = ecs_side_place(s, index);
    return *place != ECS_NONE && !ecs_side_disabled(s, index);
}

/* Does the row match, and which terms does it have (bits, of the row terms alone)? */
static bool row_matches(const kd_iter *it, const ecs_table *t, uint32_t row, uint32_t *present,
                        uint32_t *places)
{
    const kd_query *q = it->query;
    kd_entity e = ecs_entities(t)[row];
    bool any = !q->has_any;
    *present = 0;
    for (uint32_t i = 0; i < q->term_count; i++) {
        if (!(q->row_terms >> i & 1)) {
            any |= q->kinds[i] == KD_TERM_ANY && ecs_column_of(t, q->ids[i]);
            continue;
        }
        bool here = term_present(it, t, i, e, &places[i]);
        uint8_t kind = q->kinds[i];
        if (here ? kind == KD_TERM_WITHOUT
                 : kind == KD_TERM_READ || kind == KD_TERM_WRITE || kind == KD_TERM_WITH)
            return false;
        any |= here && kind == KD_TERM_ANY;
        *present |= (uint32_t)here << i;
    }
    return any;
}

/* Do the sparse values of this row lie `ahead` places behind those at `first`? */
static bool places_follow(const kd_query *q, uint32_t present, const uint32_t *first, const uint32_t *places,
                          uint32_t ahead)
{
    for (uint32_t i = 0; i < q->term_count; i++)
        if (q->sparse_terms & present & 1u << i && places[i] != first[i] + ahead &&
            (q->world->components[q->ids[i]].size || q->relation_terms >> i & 1))
            return false;
    return true;
}

static uint8_t *values_beside(const kd_query *q, uint32_t term)
{
    return q->relation_terms >> term & 1 ? ecs_relation_of(q->world, q->ids[term])->targets.values
                                         : ecs_side_of(q->world, q->ids[term])->values;
}

/* The columns of terms that hold for this run only. */
static void show_row_terms(kd_iter *it, uint32_t present, const uint32_t *places)
{
    const kd_query *q = it->query;
    for (uint32_t i = 0; i < q->term_count; i++) {
        if (!(q->row_terms >> i & 1))
            continue;
        if (!(present >> i & 1)) {
            it->columns[i] = NULL;
        } else if (q->sparse_terms >> i & 1) {
            uint32_t size = q->world->components[q->ids[i]].size;
            it->columns[i] = size ? values_beside(q, i) + (size_t)places[i] * size
                                  : (uint8_t *)(void *)q->world->tag_value;
        }
    }
}

uint32_t ecs_iter_show_run(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end)
{
    const kd_query *q = it->query;
    uint32_t present, first[KD_MAX_TERMS] = {0}, other, places[KD_MAX_TERMS] = {0};
    if (!row_matches(it, m->table, begin, &present, first))
        return begin;
    uint32_t until = begin + 1;
    while (until < end && row_matches(it, m->table, until, &other, places) && other == present &&
           places_follow(q, present, first, places, until - begin))
        until++;
    show_rows(it, m, begin, until);
    show_row_terms(it, present, first);
    return until;
}

/* Show the first run of matching rows in [begin, end) that agree in their row terms. */
static bool next_row_run(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end)
{
    while (begin < end && ecs_iter_show_run(it, m, begin, end) == begin)
        begin++;
    return begin < end;
}

/* Some required sparse component has no value at all: nothing can match. */
static bool nothing_there(const kd_query *q)
{
    for (uint32_t i = 0; i < q->term_count; i++) {
        uint8_t kind = q->kinds[i];
        const ecs_side *s = ecs_side_of(q->world, q->ids[i]);
        const ecs_relation *r = ecs_relation_of(q->world, q->ids[i]);
        if (q->world->components[q->ids[i]].sparse && (!s || !s->count) && (!r || !r->pair_count) &&
            (kind == KD_TERM_READ || kind == KD_TERM_WRITE || kind == KD_TERM_WITH))
            return true;
    }
    return false;
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
            show_rows(it, m, begin, end);
            return true;
        }
        if (next_row_run(it, m, begin, end))
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

bool kd_iter_next(kd_iter *it)
{
    const kd_query *q = it->query;
    if (!still_valid(it))
        return false;
    if (q->row_terms && nothing_there(q))
        it->next_table = q->match_count;
    else if (q->relation_terms && ecs_iter_is_led(it))
        return ecs_iter_next_led(it);
    for (; it->next_table < q->match_count; it->next_table++, it->next_row = 0) {
        const ecs_match *m = &q->matches[it->next_table];
        uint32_t count = m->table->count;
        if (it->next_row >= count)
            continue;
        if (it->changed_since || q->row_terms) {
            if (!next_narrowed(it, m))
                continue;
            return true;
        }
        if (it->next_table + 1 < q->match_count) { /* small tables are bound by reaching the next one */
            __builtin_prefetch(m[1].table);
            __builtin_prefetch(m[1].table->columns);
        }
        show_rows(it, m, 0, count);
        return true;
    }
    it->count = 0;
    return false;
}

/* Called by kd_iter_column where assertions are on. */
void ecs_iter_check(const kd_iter *it, uint32_t index, size_t size)
{
    const kd_query *q = it->query;
    assert(index < q->term_count && "no such term");
    assert(accessed(q->kinds[index]) && "the term is WITH or WITHOUT: it has no column");
    assert((!it->columns[index] || q->world->components[q->ids[index]].size == size) &&
           "the term is of another type");
    (void)q, (void)index, (void)size;
}

/* Rows within one chunk that bears the present version: what a small table looks like when it is visited
 * again. */
static inline bool stamped_already(const kd_world *w, const ecs_table *t, uint32_t column, uint32_t row,
                                   uint32_t count)
{
    uint32_t chunk = row / ECS_CHUNK_ROWS;
    uint64_t version = atomic_load_explicit(&((kd_world *)(uintptr_t)w)->version, memory_order_relaxed);
    return (row + count - 1) / ECS_CHUNK_ROWS == chunk &&
           __atomic_load_n(&ecs_versions(t, column)[1 + chunk], __ATOMIC_RELAXED) == version;
}

void *kd_iter_column_mut(kd_iter *it, uint32_t index, size_t size)
{
    const kd_query *q = it->query;
    assert(index < q->term_count && "no such term");
    if (!writable(q->kinds[index])) {
        kd_log(KD_LOG_ERROR,
               "%s%s%squery %s: component %s is written but declared as read; declare it with KD_WRITE",
               ecs_watching ? "system " : "", ecs_watching ? ecs_watching->system : "",
               ecs_watching ? ": " : "", q->name ? q->name : "without a name",
               q->world->components[q->ids[index]].desc->name);
        assert(false && "a column declared as read was asked for to write");
        return NULL;
    }
    assert((!it->columns[index] || q->world->components[q->ids[index]].size == size) &&
           "the term is of another type");
    (void)size;
    const ecs_match *m = it->internal[0];
    uint32_t c = m->columns[index];
    if (q->relation_terms >> index & 1 && it->columns[index])
        ecs_relation_stamp(q->world, ecs_relation_of(q->world, q->ids[index]));
    else if (q->sparse_terms >> index & 1 && it->columns[index])
        ecs_side_stamp(q->world, ecs_side_of(q->world, q->ids[index]));
    if (c && c != ECS_TAG_COLUMN &&
        !stamped_already(q->world, m->table, c, it->next_row - it->count, it->count))
        ecs_column_stamp(q->world, m->table, c, it->next_row - it->count, it->count);
    return it->columns[index];
}
