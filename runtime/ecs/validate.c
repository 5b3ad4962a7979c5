/* The invariants of internal.h, checked one by one. What is followed (lists of children, of names, of free
 * handles) is followed no further than the world is large, so that a broken list ends too. */

#include "runtime/ecs/validate.h"
#include "runtime/ecs/internal.h"

static kd_status broken(const char *what, uint32_t where)
{
    return kd_fail(KD_BAD_FORMAT,
                   "world: %s (at %u); memory was overwritten, or this is a defect of the ECS: report it",
                   what, where);
}

static bool is_living(const kd_world *w, uint32_t index)
{
    return index < w->head.entity_limit && ecs_record_generation(w->head.records[index]);
}

static bool is_living_handle(const kd_world *w, kd_entity e)
{
    return e.generation && is_living(w, e.index) &&
           ecs_record_generation(w->head.records[e.index]) == e.generation;
}

/* ---- handles ---- */
static kd_status check_handles(const kd_world *w)
{
    uint32_t alive = 0;
    if (w->head.entity_limit > w->record_capacity)
        return broken("more handles than there is room for", w->head.entity_limit);
    for (uint32_t i = 0; i < w->head.entity_limit; i++) {
        ecs_record r = w->head.records[i];
        if (!ecs_record_generation(r))
            continue;
        alive++;
        if (ecs_record_table(r) >= w->head.table_count ||
            ecs_record_row(r) >= w->head.tables[ecs_record_table(r)]->count)
            return broken("an entity lies outside of its table", i);
        kd_entity e = ecs_entities(w->head.tables[ecs_record_table(r)])[ecs_record_row(r)];
        if (e.index != i || e.generation != ecs_record_generation(r))
            return broken("an entity's row holds another handle", i);
    }
    return alive == w->alive_count ? KD_OK : broken("the number of living entities is wrong", alive);
}

static kd_status check_free(const kd_world *w)
{
    uint32_t index = w->free_first;
    uint64_t listed = 0,
             dead = 0; /* sums of their indices: a list that visits one twice leaves another out */
    if (w->free_count > w->head.entity_limit - w->alive_count)
        return broken("more free handles than dead entities", w->free_count);
    for (uint32_t i = 0; i < w->free_count; i++) {
        if (index >= w->head.entity_limit || is_living(w, index))
            return broken("a free handle is in use", index);
        if (ecs_record_next_generation(w->head.records[index]) < 2) /* the first one was given */
            return broken("a free handle would give a handle of before", index);
        listed += index;
        index = ecs_record_row(w->head.records[index]);
    }
    for (uint32_t i = 0; i < w->head.entity_limit; i++) /* ECS_DEAD rests for ever */
        dead += !is_living(w, i) && w->head.records[i] != ECS_DEAD ? i : 0;
    return listed == dead ? KD_OK : broken("the list of free handles is torn", index);
}

/* ---- archetypes and tables ---- */
static kd_status check_archetype(const kd_world *w, uint32_t index)
{
    const ecs_archetype *a = w->archetypes[index];
    uint32_t columns = 0;
    if (a->index != index)
        return broken("an archetype has another's number", index);
    for (uint32_t i = 0; i < a->id_count; i++) {
        kd_component_id id = a->ids[i];
        if (!id || id > kd_component_count(w) || (i && a->ids[i - 1] >= id))
            return broken("an archetype's components are not in order", index);
        uint32_t expected = w->components[id].size ? ++columns : ECS_TAG_COLUMN;
        if (id >= a->column_limit || a->column_of[id] != expected)
            return broken("an archetype's columns are wrong", index);
    }
    if (a->column_count != columns)
        return broken("an archetype's columns are miscounted", index);
    for (uint32_t id = 1; id < a->edge_limit; id++)
        if (a->edges[id] != ECS_NONE &&
            (a->edges[id] >= w->archetype_count || w->archetypes[a->edges[id]]->edge_limit <= id ||
             w->archetypes[a->edges[id]]->edges[id] != index))
            return broken("an edge between archetypes does not lead back", index);
    return KD_OK;
}

/* What look-ups by component and table read. */
static kd_status check_places(const kd_world *w, const ecs_table *t)
{
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        const ecs_places *p = &w->head.places[id];
        uint32_t c = ecs_column_of(t, id);
        const uint8_t *column = c && c != ECS_TAG_COLUMN ? t->columns[c].data : NULL;
        if ((t->index < p->limit ? p->columns[t->index] : NULL) != column ||
            (column && p->size != t->columns[c].size))
            return broken("look-ups would miss a column", t->index);
    }
    return KD_OK;
}

static kd_status check_versions(const kd_world *w, const ecs_table *t)
{
    uint64_t newest = atomic_load_explicit(&((kd_world *)(uintptr_t)w)->version, memory_order_relaxed);
    uint32_t chunks = (t->count + ECS_CHUNK_ROWS - 1) / ECS_CHUNK_ROWS;
    if (chunks > t->chunk_capacity)
        return broken("a table has rows without change versions", t->index);
    for (uint32_t c = 0; c < t->column_count && t->chunk_capacity; c++) {
        const uint64_t *versions = ecs_versions(t, c);
        if (versions[0] > newest)
            return broken("a column changed in the future", t->index);
        for (uint32_t i = 0; i < chunks; i++)
            if (versions[1 + i] > versions[0])
                return broken("a column's newest change is not its newest", t->index);
    }
    return KD_OK;
}

static kd_status check_table(const kd_world *w, uint32_t index)
{
    const ecs_table *t = w->head.tables[index];
    const ecs_archetype *a = t->archetype;
    if (t->index != index || t->depth >= a->depth_limit || a->tables[t->depth] != t)
        return broken("a table is not where its archetype looks", index);
    if (t->count > t->capacity || t->incoming || t->column_count != a->column_count + (t->depth ? 2u : 1u))
        return broken("a table's counts are wrong", index);
    for (uint32_t c = 0; c < t->column_count; c++)
        if ((t->capacity && !t->columns[c].data) || (uintptr_t)t->columns[c].data % 64)
            return broken("a column does not begin at a cache line", index);
    for (uint32_t row = 0; row < t->count; row++) {
        kd_entity e = ecs_entities(t)[row];
        if (!is_living_handle(w, e) || ecs_table_of(w, e.index) != t || ecs_row_of(w, e.index) != row)
            return broken("a row belongs to no entity", e.index);
    }
    kd_status status = check_places(w, t);
    return status ? status : check_versions(w, t);
}

/* ---- hierarchy ---- */
static kd_status check_children(const kd_world *w)
{
    uint32_t linked = 0, below = 0;
    for (uint32_t i = 0; i < w->head.table_count; i++) {
        const ecs_table *t = w->head.tables[i];
        below += t->depth ? t->count : 0;
        for (uint32_t row = 0; t->depth && row < t->count; row++) {
            kd_entity parent = ecs_parents(t)[row];
            if (!is_living_handle(w, parent) || ecs_table_of(w, parent.index)->depth + 1u != t->depth)
                return broken("an entity's parent is not one level above it", ecs_entities(t)[row].index);
        }
    }
    for (uint32_t parent = 0; parent < w->node_limit; parent++) {
        uint32_t previous = ECS_NONE;
        for (uint32_t child = w->nodes[parent].first; child != ECS_NONE; child = w->nodes[child].next) {
            if (child >= w->node_limit || !is_living(w, child) || !ecs_table_of(w, child)->depth ||
                ecs_parents(ecs_table_of(w, child))[ecs_row_of(w, child)].index != parent)
                return broken("a child hangs on a parent that is not its own", child);
            if (w->nodes[child].previous != previous || ++linked > below)
                return broken("a list of siblings is torn", child);
            previous = child;
        }
        if (w->nodes[parent].last != previous)
            return broken("a list of children does not end where it should", parent);
    }
    return linked == below ? KD_OK : broken("children stand in no list of siblings", below - linked);
}

/* ---- names ---- */
static kd_status check_names(const kd_world *w)
{
    uint32_t linked = 0, named = 0, groups = 0;
    for (uint32_t i = 0; i < w->name_limit; i++) {
        named += w->name_links[i].group != 0;
        if (w->name_links[i].group && (!is_living(w, i) || w->name_links[i].group > w->name_group_count))
            return broken("a dead entity has a name", i);
    }
    for (uint32_t g = 0; g < w->name_group_count; g++) {
        uint32_t previous = ECS_NONE;
        if (!w->name_groups[g].text)
            continue;
        groups++;
        if (w->name_groups[g].first == ECS_NONE)
            return broken("a name without entity is kept", g);
        for (uint32_t i = w->name_groups[g].first; i != ECS_NONE; i = w->name_links[i].next) {
            if (i >= w->name_limit || w->name_links[i].group != g + 1 ||
                w->name_links[i].previous != previous || ++linked > named)
                return broken("a list of equal names is torn", i);
            previous = i;
        }
        if (w->name_groups[g].last != previous || !kd_entity_equal(kd_find_named(w, w->name_groups[g].text),
                                                                   ecs_handle_at(w, w->name_groups[g].first)))
            return broken("a name is not found", g);
    }
    if (groups != w->name_slot_used)
        return broken("names are miscounted", groups);
    return linked == named ? KD_OK : broken("named entities stand in no list", named - linked);
}

/* ---- beside the tables ---- */
static kd_status check_side(const kd_world *w, kd_component_id id, const ecs_side *s)
{
    uint32_t indexed = 0, disabled = 0;
    for (uint32_t page = 0; page < s->page_limit; page++)
        for (uint32_t i = 0; s->pages[page] && i < ECS_PAGE; i++)
            indexed += s->pages[page][i] != 0;
    if (indexed != s->count || s->count > s->entity_capacity)
        return broken("a sparse component's values are miscounted", id);
    for (uint32_t place = 0; place < s->count; place++)
        if (!is_living_handle(w, s->entities[place]) || ecs_side_place(s, s->entities[place].index) != place)
            return broken("a sparse value belongs to no entity", s->entities[place].index);
    for (uint32_t index = 0; index < s->word_limit * 64; index++) {
        if (!ecs_side_disabled(s, index))
            continue;
        disabled++;
        if (!is_living(w, index) || !kd_find_id(w, ecs_handle_at(w, index), id))
            return broken("a component is disabled that is not there", index);
    }
    return disabled == s->disabled_count ? KD_OK : broken("disabled components are miscounted", id);
}

/* ---- relations ---- */
static kd_status check_run(const kd_world *w, const ecs_store *s, uint32_t index, uint32_t *items)
{
    ecs_run run = ecs_run_of(s, index);
    uint64_t room = run.room ? (uint64_t)1 << (run.room - 1) : 0;
    if ((run.count != 0) != (run.room != 0) || run.skip + run.count > room || run.base + room > s->used)
        return broken("an entity's pairs lie outside of their block", index);
    if (run.count && !is_living(w, index))
        return broken("a dead entity is related", index);
    *items += run.count;
    return KD_OK;
}

/* Every target that a source has stands where it says among the target's sources; counts do the rest. */
static kd_status check_source(const kd_world *w, kd_component_id id, const ecs_relation *r, uint32_t index)
{
    ecs_run run = ecs_run_of(&r->targets, index);
    if (run.count > 1 && w->components[id].desc->flags & KD_COMPONENT_EXCLUSIVE)
        return broken("an exclusive relation has two targets", index);
    for (uint32_t k = 0; k < run.count; k++) {
        uint32_t item = run.base + run.skip + k;
        kd_entity target = r->targets.entities[item];
        ecs_run sources = is_living_handle(w, target) ? ecs_run_of(&r->sources, target.index) : (ecs_run){0};
        if (r->targets.places[item] >= sources.count ||
            !kd_entity_equal(r->sources.entities[sources.base + r->targets.places[item]],
                             ecs_handle_at(w, index)))
            return broken("a target does not know its source", index);
        if (ecs_pair_place(r, ecs_handle_at(w, index), target) != k)
            return broken("a pair is there twice", index);
    }
    return KD_OK;
}

static kd_status check_relation(const kd_world *w, kd_component_id id, const ecs_relation *r)
{
    uint32_t targets = 0, sources = 0;
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < r->targets.page_limit * ECS_RUN_PAGE && !status; i++)
        status = check_run(w, &r->targets, i, &targets);
    for (uint32_t i = 0; i < r->sources.page_limit * ECS_RUN_PAGE && !status; i++)
        status = check_run(w, &r->sources, i, &sources);
    for (uint32_t i = 0; i < r->targets.page_limit * ECS_RUN_PAGE && !status; i++)
        status = check_source(w, id, r, i);
    if (!status && (targets != r->pair_count || sources != r->pair_count))
        return broken("pairs are miscounted", id);
    return status;
}

static kd_status check_relations(const kd_world *w)
{
    uint32_t pairs = 0, cascades = 0;
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < w->relation_limit && i < w->relation_count && !status; i++) {
        kd_component_id id = w->relation_ids[i];
        status = check_relation(w, id, &w->relations[i]);
        pairs += w->relations[i].pair_count;
        if (w->components[id].desc->flags & KD_COMPONENT_CASCADE)
            cascades += w->relations[i].pair_count;
    }
    if (!status && (pairs != w->pair_count || cascades != w->cascade_count || w->doomed_count ||
                    cascades > w->doomed_capacity))
        return broken("pairs of all relations are miscounted", pairs);
    return status;
}

/* ---- queries ---- */
static kd_status check_query(const kd_query *q)
{
    const kd_world *w = q->world;
    uint32_t expected = 0;
    for (uint32_t i = 0; i < w->head.table_count; i++)
        expected += ecs_query_matches(q, w->head.tables[i]);
    if (expected != q->match_count || !q->references || q->kept_count)
        return broken("a query misses a table, or has one too many", expected);
    for (uint32_t i = 0; i < q->match_count; i++) {
        const ecs_table *t = q->matches[i].table, *before = i ? q->matches[i - 1].table : NULL;
        if (!ecs_query_matches(q, t))
            return broken("a query visits a table that does not match", t->index);
        bool in_order = !before || (q->by_depth && before->depth != t->depth ? before->depth < t->depth
                                                                             : before->index < t->index);
        if (!in_order)
            return broken("a query's tables are not in order", t->index);
    }
    return KD_OK;
}

kd_status kd_world_validate(const kd_world *w)
{
    kd_status status = check_handles(w);
    if (!status)
        status = check_free(w);
    for (uint32_t i = 0; i < w->archetype_count && !status; i++)
        status = check_archetype(w, i);
    for (uint32_t i = 0; i < w->head.table_count && !status; i++)
        status = check_table(w, i);
    if (!status)
        status = check_children(w);
    if (!status)
        status = check_names(w);
    for (uint32_t i = 0; i < w->side_limit && i < w->side_count && !status; i++)
        status = check_side(w, w->side_ids[i], &w->sides[i]);
    if (!status)
        status = check_relations(w);
    for (const kd_query *q = w->queries; q && !status; q = q->next)
        status = check_query(q);
    return status;
}
