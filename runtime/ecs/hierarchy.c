/* The hierarchy: a parent column in every table below the roots, and intrusive lists of siblings in an array
 * by entity index. An entity's depth is its table's; so giving a subtree another parent moves its rows to
 * tables of other depths. */

#include "runtime/ecs/internal.h"

bool ecs_hierarchy_reserve(kd_world *w, uint32_t index)
{
    if (index < w->node_limit)
        return true;
    if (!ecs_reserve(w, &w->nodes, &w->node_capacity, w->node_limit, index + 1, sizeof *w->nodes))
        return false;
    while (w->node_limit < w->node_capacity)
        w->nodes[w->node_limit++] = (ecs_node){ECS_NONE, ECS_NONE, ECS_NONE, ECS_NONE};
    return true;
}

void ecs_hierarchy_link(kd_world *w, uint32_t child, uint32_t parent)
{
    ecs_node *p = &w->nodes[parent], *c = &w->nodes[child];
    c->previous = p->last;
    c->next = ECS_NONE;
    if (p->last != ECS_NONE)
        w->nodes[p->last].next = child;
    else
        p->first = child;
    p->last = child;
}

void ecs_hierarchy_unlink(kd_world *w, uint32_t child, uint32_t parent)
{
    ecs_node *p = &w->nodes[parent], *c = &w->nodes[child];
    if (c->previous != ECS_NONE)
        w->nodes[c->previous].next = c->next;
    else
        p->first = c->next;
    if (c->next != ECS_NONE)
        w->nodes[c->next].previous = c->previous;
    else
        p->last = c->previous;
    c->next = c->previous = ECS_NONE;
}

static uint32_t parent_index(const kd_world *w, uint32_t index)
{
    const ecs_table *t = ecs_table_of(w, index);
    return t->depth ? ecs_parents(t)[ecs_row_of(w, index)].index : ECS_NONE;
}

uint32_t ecs_subtree_next(const kd_world *w, uint32_t root, uint32_t at)
{
    uint32_t child = ecs_first_child(w, at);
    if (child != ECS_NONE)
        return child;
    while (at != root) {
        if (w->nodes[at].next != ECS_NONE)
            return w->nodes[at].next;
        at = parent_index(w, at);
    }
    return ECS_NONE;
}

static ecs_table *destination(kd_world *w, uint32_t index, uint32_t old_base, uint32_t new_base)
{
    const ecs_table *t = ecs_table_of(w, index);
    return ecs_table_ensure(w, t->archetype, t->depth - old_base + new_base);
}

/* Make every table and row that the move will need, so that the move itself cannot fail half-way. */
static kd_status reserve_subtree(kd_world *w, uint32_t root, uint32_t old_base, uint32_t new_base)
{
    kd_status status = KD_OK;
    uint32_t reserved = 0;
    for (uint32_t at = root; at != ECS_NONE && !status; at = ecs_subtree_next(w, root, at)) {
        const ecs_table *t = ecs_table_of(w, at);
        bool too_deep = t->depth - old_base + (uint64_t)new_base > ECS_MAX_DEPTH;
        ecs_table *to = too_deep ? NULL : destination(w, at, old_base, new_base);
        if (too_deep) {
            status = KD_OUT_OF_RANGE;
        } else if (!to || !ecs_table_reserve(w, to, to->count + to->incoming + 1)) {
            status = KD_NO_MEMORY;
        } else {
            to->incoming++;
            reserved++;
        }
    }
    for (uint32_t at = root; reserved; at = ecs_subtree_next(w, root, at), reserved--)
        destination(w, at, old_base, new_base)->incoming = 0;
    return status;
}

static void move_subtree(kd_world *w, uint32_t root, uint32_t old_base, uint32_t new_base)
{
    for (uint32_t at = root; at != ECS_NONE; at = ecs_subtree_next(w, root, at)) {
        ecs_table *from = ecs_table_of(w, at), *to = destination(w, at, old_base, new_base);
        uint32_t dropped = to->depth ? 0 : from->column_count - 1u; /* the parents */
        ecs_table_move_row(w, from, ecs_row_of(w, at), to, ecs_handle_at(w, at), dropped, 0);
    }
}

static bool is_below(const kd_world *w, uint32_t index, uint32_t ancestor)
{
    while (index != ancestor && index != ECS_NONE)
        index = parent_index(w, index);
    return index == ancestor;
}

kd_status kd_set_parent(kd_world *w, kd_entity child, kd_entity parent)
{
    ecs_table *t, *parent_table = NULL;
    uint32_t row, parent_row = 0;
    bool orphan = !parent.generation;
    if (!ecs_locate(w, child, &t, &row) || (!orphan && !ecs_locate(w, parent, &parent_table, &parent_row)))
        return KD_NOT_FOUND;
    child = ecs_entities(t)[row];
    if (!orphan)
        parent = ecs_entities(parent_table)[parent_row];
    if (orphan && !t->depth)
        return KD_OK;
    bool has_children = ecs_first_child(w, child.index) != ECS_NONE; /* what has none is above nobody */
    if (!orphan && (has_children || parent.index == child.index) && is_below(w, parent.index, child.index))
        return KD_OUT_OF_RANGE;
    uint32_t highest = orphan || child.index > parent.index ? child.index : parent.index;
    if (!ecs_hierarchy_reserve(w, highest))
        return KD_NO_MEMORY;
    uint32_t old_depth = t->depth, new_depth = orphan ? 0 : parent_table->depth + 1;
    if (old_depth != new_depth) {
        ecs_structure_changed(w, "kd_set_parent");
        kd_status status = reserve_subtree(w, child.index, old_depth, new_depth);
        if (status)
            return status;
    }
    if (old_depth)
        ecs_hierarchy_unlink(w, child.index, ecs_parents(t)[row].index);
    if (old_depth != new_depth)
        move_subtree(w, child.index, old_depth, new_depth);
    if (!orphan) {
        ecs_table *now = ecs_table_of(w, child.index);
        uint32_t now_row = ecs_row_of(w, child.index);
        ecs_parents(now)[now_row] = parent;
        ecs_table_stamp(w, now, now_row, 1); /* every query shows parents, whatever it reads */
        ecs_hierarchy_link(w, child.index, parent.index);
    }
    return KD_OK;
}

kd_entity kd_get_parent(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    return ecs_locate(w, e, &t, &row) && t->depth ? ecs_parents(t)[row] : KD_NO_ENTITY;
}

uint32_t kd_get_depth(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    return ecs_locate(w, e, &t, &row) ? t->depth : 0;
}

kd_entity kd_first_child(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row))
        return KD_NO_ENTITY;
    uint32_t child = ecs_first_child(w, ecs_entities(t)[row].index);
    return child == ECS_NONE ? KD_NO_ENTITY : ecs_handle_at(w, child);
}

kd_entity kd_next_sibling(const kd_world *w, kd_entity e)
{
    ecs_table *t;
    uint32_t row;
    if (!ecs_locate(w, e, &t, &row) || !t->depth)
        return KD_NO_ENTITY;
    uint32_t next = w->nodes[ecs_entities(t)[row].index].next;
    return next == ECS_NONE ? KD_NO_ENTITY : ecs_handle_at(w, next);
}
