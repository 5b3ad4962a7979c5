/* Terms that are asked row by row: of sparse components, of relations, of components with enable bits. A
 * chunk is then a run of rows that agree. */

#include "runtime/ecs/internal.h"

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
    ecs_iter_show(it, m, begin, until);
    show_row_terms(it, present, first);
    return until;
}

bool ecs_iter_row_run(kd_iter *it, const ecs_match *m, uint32_t begin, uint32_t end)
{
    while (begin < end && ecs_iter_show_run(it, m, begin, end) == begin)
        begin++;
    return begin < end;
}

bool ecs_query_lacks_values(const kd_query *q)
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
