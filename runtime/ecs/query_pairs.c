/* Queries that require a pair with one target are led by the sources of that target: they are taken in their
 * order, each is looked up, and those that lie one behind the other in a table are shown together. Nothing
 * else is visited, however large the tables are. */

#include <assert.h>

#include "runtime/ecs/internal.h"

kd_iter kd_query_iter_to(kd_query *q, kd_entity target)
{
    kd_iter it = kd_query_iter(q);
    assert((q->relation_terms || !target.generation) && "the query has no term of a relation");
    it.target = target.generation & ECS_PENDING ? kd_entity_resolve(q->world, target) : target;
    if (target.generation && !it.target.generation) /* pending, and nothing came of it: nobody has that */
        it.target = (kd_entity){ECS_NONE, 1};
    return it;
}

kd_entity ecs_term_target(const kd_iter *it, uint32_t i)
{
    const kd_query *q = it->query;
    bool first = (q->relation_terms & ((1u << i) - 1)) == 0;
    return first && it->target.generation ? it->target : q->targets[i];
}

/* The first term that requires a pair with one target, ECS_NONE when there is none. */
static uint32_t leading_term(const kd_iter *it)
{
    const kd_query *q = it->query;
    for (uint32_t i = 0; i < q->term_count; i++) {
        bool required =
            q->kinds[i] == KD_TERM_READ || q->kinds[i] == KD_TERM_WRITE || q->kinds[i] == KD_TERM_WITH;
        if (required && q->relation_terms >> i & 1 && ecs_term_target(it, i).generation)
            return i;
    }
    return ECS_NONE;
}

bool ecs_iter_is_led(const kd_iter *it)
{
    return leading_term(it) != ECS_NONE;
}

/* The query's match of this table, NULL when it has none: they are sorted. */
static const ecs_match *match_of(const kd_query *q, const ecs_table *t)
{
    uint32_t low = 0, high = q->match_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        const ecs_table *other = q->matches[middle].table;
        if (other == t)
            return &q->matches[middle];
        bool before =
            q->by_depth && other->depth != t->depth ? other->depth < t->depth : other->index < t->index;
        low = before ? middle + 1 : low;
        high = before ? high : middle;
    }
    return NULL;
}

/* How many sources from `at` on lie one behind the other in the table, in chunks that are to be seen? */
static uint32_t neighbours(const kd_iter *it, const ecs_match *m, const kd_entity *at, uint32_t left,
                           uint32_t row)
{
    const kd_world *w = it->query->world;
    uint32_t n = 0;
    for (; n < left; n++) {
        bool starts_chunk = !n || (row + n) % ECS_CHUNK_ROWS == 0;
        if (ecs_table_of(w, at[n].index) != m->table || ecs_row_of(w, at[n].index) != row + n ||
            (starts_chunk && !ecs_iter_chunk_changed(it, m, (row + n) / ECS_CHUNK_ROWS)))
            break;
    }
    return n;
}

/* Show the next run among the sources from row_limit on, of tables at this depth when the query goes by
 * depth. */
static bool next_run(kd_iter *it, ecs_run run, const kd_entity *sources)
{
    const kd_query *q = it->query;
    while (it->row_limit < run.count) {
        const kd_entity *at = sources + it->row_limit;
        const ecs_table *t = ecs_table_of(q->world, at->index);
        const ecs_match *m = q->by_depth && t->depth != it->next_table ? NULL : match_of(q, t);
        uint32_t row = ecs_row_of(q->world, at->index);
        uint32_t n = m ? neighbours(it, m, at, run.count - it->row_limit, row) : 0;
        uint32_t shown = n ? ecs_iter_show_run(it, m, row, row + n) - row : 0;
        it->row_limit += shown ? shown : 1;
        if (shown)
            return true;
    }
    return false;
}

/* The least depth above `depth` of any of them, ECS_NONE when there is none. */
static uint32_t next_depth(const kd_world *w, ecs_run run, const kd_entity *sources, uint32_t depth)
{
    uint32_t least = ECS_NONE;
    for (uint32_t i = 0; i < run.count; i++) {
        uint32_t d = ecs_table_of(w, sources[i].index)->depth;
        least = d > depth && d < least ? d : least;
    }
    return least;
}

/* row_limit is the place among the sources, next_table the depth that is being visited. */
bool ecs_iter_next_led(kd_iter *it)
{
    const kd_query *q = it->query;
    const kd_world *w = q->world;
    uint32_t term = leading_term(it);
    kd_entity target = ecs_term_target(it, term);
    const ecs_relation *r = ecs_relation_of(w, q->ids[term]);
    ecs_run run = kd_alive(w, target) ? ecs_run_of(&r->sources, target.index) : (ecs_run){0};
    const kd_entity *sources = run.count ? r->sources.entities + run.base : NULL;
    it->count = 0;
    while (run.count && it->next_table != ECS_NONE) {
        if (next_run(it, run, sources))
            return true;
        it->row_limit = q->by_depth ? 0 : it->row_limit;
        it->next_table = q->by_depth ? next_depth(w, run, sources, it->next_table) : ECS_NONE;
    }
    return false;
}

const kd_entity *kd_iter_targets(const kd_iter *it, uint32_t index)
{
    const kd_query *q = it->query;
    assert(index < q->term_count && q->relation_terms >> index & 1 && "the term is not of a relation");
    assert(q->sparse_terms >> index & 1 && "the term is WITH or WITHOUT: it has no column");
    const ecs_relation *r = it->columns[index] ? ecs_relation_of(q->world, q->ids[index]) : NULL;
    uint32_t item = r ? ecs_pair_item(r, it->entities[0], ecs_term_target(it, index)) : ECS_NONE;
    return item == ECS_NONE ? NULL : r->targets.entities + item;
}
