/* Copying subtrees. The prototype's nodes are visited in preorder; of each all n copies are appended to its
 * table in one go. Copy i of node k is made[k * n + i], and a hash from entity index to k says where a handle
 * that points into the prototype leads in a copy. */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/internal.h"
#include "runtime/ecs/relation.h"

typedef struct instancing {
    kd_world *w;
    kd_entity parent;
    uint32_t base, new_base; /* depths of the prototype and of its copies */
    uint32_t n, node_count, slot_mask;
    kd_entity *nodes; /* [node_count] */
    uint32_t *slots;  /* open addressing by entity index: k + 1 */
    kd_entity *made;  /* [node_count][n] */
    kd_entity few_nodes[2],
        few_made[8]; /* room for the most usual prototypes: nothing is allocated for them */
    uint32_t few_slots[4];
} instancing;

#define FEW(array) (sizeof(array) / sizeof *(array))

/* ---- the prototype ---- */
static uint32_t slot_of(const instancing *in, uint32_t index)
{
    uint32_t s = (index * 0x9e3779b1u) & in->slot_mask;
    while (in->slots[s] && in->nodes[in->slots[s] - 1].index != index)
        s = (s + 1) & in->slot_mask;
    return s;
}

/* Which node is it? ECS_NONE when it is not of the prototype. */
static uint32_t node_of(const instancing *in, kd_entity e)
{
    uint32_t k = in->slots[slot_of(in, e.index)] - 1;
    return k != ECS_NONE && kd_entity_equal(in->nodes[k], e) ? k : ECS_NONE;
}

static kd_status owns_something(const kd_world *w, kd_component_id id)
{
    return kd_fail(KD_UNSUPPORTED,
                   "component %s: owns memory and cannot be copied; remove it from the prototype",
                   w->components[id].desc->name);
}

static kd_status check_node(const instancing *in, uint32_t index)
{
    const kd_world *w = in->w;
    const ecs_table *t = ecs_table_of(w, index);
    if ((uint64_t)t->depth - in->base + in->new_base > ECS_MAX_DEPTH)
        return KD_OUT_OF_RANGE;
    for (uint32_t i = 0; t->archetype->hooked && i < t->archetype->id_count; i++)
        if (w->components[t->archetype->ids[i]].desc->on_remove)
            return owns_something(w, t->archetype->ids[i]);
    for (uint32_t i = 0; i < w->side_limit && i < w->side_count; i++)
        if (w->components[w->side_ids[i]].desc->on_remove && ecs_side_find(w, w->side_ids[i], index))
            return owns_something(w, w->side_ids[i]);
    for (uint32_t i = 0; w->pair_count && i < w->relation_count; i++)
        if (w->components[w->relation_ids[i]].desc->on_remove &&
            ecs_relation_find(w, w->relation_ids[i], ecs_handle_at(w, index)))
            return owns_something(w, w->relation_ids[i]);
    return KD_OK;
}

static kd_status list_nodes(instancing *in, uint32_t root)
{
    kd_world *w = in->w;
    kd_status status = KD_OK;
    for (uint32_t at = root; at != ECS_NONE && !status; at = ecs_subtree_next(w, root, at)) {
        status = check_node(in, at);
        in->node_count++;
    }
    if (status)
        return status;
    uint64_t total = (uint64_t)in->node_count * in->n;
    if (total > ECS_ROW_MASK)
        return KD_NO_MEMORY;
    for (in->slot_mask = 1; in->slot_mask < in->node_count; in->slot_mask *= 2) {
    }
    in->slot_mask = in->slot_mask * 2 - 1;
    bool few = in->node_count <= FEW(in->few_nodes);
    in->nodes = few ? in->few_nodes : ecs_grow(w, NULL, 0, in->node_count * sizeof *in->nodes);
    in->slots = few ? in->few_slots : ecs_grow(w, NULL, 0, (in->slot_mask + 1) * sizeof *in->slots);
    in->made =
        total <= FEW(in->few_made) ? in->few_made : ecs_grow(w, NULL, 0, (size_t)total * sizeof *in->made);
    if (in->made)
        memset(in->made, 0, (size_t)total * sizeof *in->made);
    if (!in->nodes || !in->slots || !in->made)
        return KD_NO_MEMORY;
    memset(in->slots, 0, (in->slot_mask + 1) * sizeof *in->slots);
    for (uint32_t at = root, k = 0; at != ECS_NONE; at = ecs_subtree_next(w, root, at), k++) {
        in->nodes[k] = ecs_handle_at(w, at);
        in->slots[slot_of(in, at)] = k + 1;
    }
    return KD_OK;
}

static void free_lists(instancing *in)
{
    if (in->nodes != in->few_nodes)
        ecs_free(in->w, in->nodes);
    if (in->slots != in->few_slots)
        ecs_free(in->w, in->slots);
    if (in->made != in->few_made)
        ecs_free(in->w, in->made);
}

/* ---- the copies of one node ---- */
static void fill_rows(ecs_table *to, uint32_t first, uint32_t n, const ecs_table *from, uint32_t row)
{
    for (uint32_t c = 1; c <= from->archetype->column_count; c++) {
        uint32_t size = from->columns[c].size;
        const uint8_t *value = from->columns[c].data + (size_t)row * size;
        uint8_t *at = to->columns[c].data + (size_t)first * size;
        for (uint32_t i = 0; i < n; i++, at += size)
            ecs_copy(at, value, size);
    }
}

static bool copy_sides(kd_world *w, uint32_t index, const kd_entity *made, uint32_t n)
{
    for (uint32_t s = 0; s < w->side_limit && s < w->side_count; s++) {
        kd_component_id id = w->side_ids[s];
        bool disabled = ecs_side_disabled(ecs_side_of(w, id), index);
        for (uint32_t i = 0; i < n; i++) {
            const void *value = w->components[id].sparse ? ecs_side_find(w, id, index) : NULL;
            if ((value && ecs_side_set(w, id, made[i], value)) ||
                (disabled && !ecs_side_disable(w, id, made[i].index, true)))
                return false;
        }
    }
    return true;
}

static void link_rows(instancing *in, uint32_t k, const ecs_table *from, uint32_t row, ecs_table *to,
                      uint32_t first)
{
    const kd_entity *made = in->made + (size_t)k * in->n;
    uint32_t above = k ? node_of(in, ecs_parents(from)[row]) : ECS_NONE;
    for (uint32_t i = 0; i < in->n; i++) {
        kd_entity parent = k ? in->made[(size_t)above * in->n + i] : in->parent;
        ecs_parents(to)[first + i] = parent;
        ecs_hierarchy_link(in->w, made[i].index, parent.index);
    }
}

static kd_status copy_node(instancing *in, uint32_t k)
{
    kd_world *w = in->w;
    const ecs_table *from = ecs_table_of(w, in->nodes[k].index);
    uint32_t row = ecs_row_of(w, in->nodes[k].index), n = in->n;
    ecs_table *to = ecs_table_ensure(w, from->archetype, from->depth - in->base + in->new_base);
    if (!to || n > ECS_ROW_MASK - to->count || !ecs_table_reserve(w, to, to->count + n) ||
        !ecs_handles_reserve(w, n) || (to->depth && !ecs_hierarchy_reserve(w, w->head.entity_limit + n)))
        return KD_NO_MEMORY;
    kd_entity *made = in->made + (size_t)k * n;
    uint32_t first = to->count;
    to->count += n;
    for (uint32_t i = 0; i < n; i++) {
        made[i] = ecs_entities(to)[first + i] = ecs_handle_take(w);
        ecs_place(w, made[i], to, first + i);
    }
    ecs_table_stamp(w, to, first, n);
    fill_rows(to, first, n, from, row);
    if (to->depth)
        link_rows(in, k, from, row, to, first);
    bool done = !w->side_limit || copy_sides(w, in->nodes[k].index, made, n);
    const char *name = kd_get_name(w, in->nodes[k]);
    for (uint32_t i = 0; i < n && *name && done; i++)
        done = kd_set_name(w, made[i], name) == KD_OK;
    return done ? KD_OK : KD_NO_MEMORY;
}

/* ---- handles that point into the prototype ---- */
static void lead_field(const instancing *in, const kd_field *f, uint8_t *value, uint32_t copy)
{
    for (uint32_t at = 0; at + sizeof(kd_entity) <= f->size; at += sizeof(kd_entity)) {
        kd_entity e;
        memcpy(&e, value + f->offset + at, sizeof e);
        uint32_t k = e.generation ? node_of(in, e) : ECS_NONE;
        if (k != ECS_NONE)
            memcpy(value + f->offset + at, &in->made[(size_t)k * in->n + copy], sizeof e);
    }
}

static void lead_value(const instancing *in, kd_component_id id, uint8_t *value, uint32_t copy)
{
    const kd_component_desc *desc = in->w->components[id].desc;
    for (uint32_t i = 0; i < desc->field_count; i++)
        if (desc->fields[i].type == KD_ENTITY)
            lead_field(in, &desc->fields[i], value, copy);
}

static void lead_handles(const instancing *in, uint32_t k)
{
    const kd_world *w = in->w;
    for (kd_component_id id = 1; id <= kd_component_count(w); id++) {
        if (!w->components[id].has_entities || w->components[id].relation || !kd_find_id(w, in->nodes[k], id))
            continue;
        for (uint32_t i = 0; i < in->n; i++) {
            const void *value = kd_find_id(w, in->made[(size_t)k * in->n + i], id);
            lead_value(in, id, (uint8_t *)(uintptr_t)value, i);
        }
    }
}

/* ---- pairs ---- */
/* Give copy i of node k the node's pair at `place`. */
static kd_status copy_pair(const instancing *in, kd_component_id id, uint32_t k, uint32_t place, uint32_t i)
{
    kd_world *w = in->w;
    const uint8_t *values = kd_target_values_id(w, in->nodes[k], id);
    const void *value = values ? values + (size_t)place * w->components[id].size : NULL;
    kd_entity source = in->made[(size_t)k * in->n + i], target = kd_targets_id(w, in->nodes[k], id).at[place];
    uint32_t within = node_of(in, target);
    target = within == ECS_NONE ? target : in->made[(size_t)within * in->n + i];
    kd_status status = ecs_relate_id(w, source, id, value, target);
    if (!status && w->components[id].has_entities)
        lead_value(in, id, (uint8_t *)(uintptr_t)kd_pair_find_id(w, source, id, target), i);
    return status;
}

static kd_status copy_pairs(const instancing *in, uint32_t k)
{
    const kd_world *w = in->w;
    kd_status status = KD_OK;
    for (uint32_t r = 0; r < w->relation_count && !status; r++) {
        kd_component_id id = w->relation_ids[r];
        uint32_t count = kd_targets_id(w, in->nodes[k], id).count;
        for (uint32_t i = 0; i < in->n && !status; i++)
            for (uint32_t place = 0; place < count && !status; place++)
                status = copy_pair(in, id, k, place, i);
    }
    return status;
}

/* ---- all of it ---- */
static kd_status copy_all(instancing *in, uint32_t root)
{
    kd_status status = list_nodes(in, root);
    for (uint32_t k = 0; k < in->node_count && !status; k++)
        status = copy_node(in, k);
    for (uint32_t k = 0; in->w->pair_count && k < in->node_count && !status; k++)
        status = copy_pairs(in, k);
    return status;
}

static void tell_of_copies(const instancing *in)
{
    kd_world *w = in->w;
    for (uint64_t i = 0; i < (uint64_t)in->node_count * in->n; i++) {
        ecs_event_row(w, KD_ON_ADD, ecs_table_of(w, in->made[i].index), ecs_row_of(w, in->made[i].index));
        ecs_relations_added(w, in->made[i]);
    }
}

static kd_status instantiate(instancing *in, uint32_t root)
{
    kd_world *w = in->w;
    bool observed = w->any_observed; /* nobody is told of a copy before all are complete */
    w->any_observed = false;
    kd_status status = copy_all(in, root);
    for (uint32_t i = 0; status && in->made && i < in->n; i++)
        kd_destroy(w, in->made[i]); /* the roots hold all others; no handle yet: nothing to do */
    for (uint32_t k = 0; k < in->node_count && !status; k++)
        lead_handles(in, k);
    w->any_observed = observed;
    if (!status && observed)
        tell_of_copies(in);
    return status;
}

kd_status kd_instantiate(kd_world *w, kd_entity prototype, kd_entity parent, uint32_t n, kd_entity *roots)
{
    ecs_table *t, *above = NULL;
    uint32_t row, parent_row;
    if (!ecs_locate(w, prototype, &t, &row) ||
        (parent.generation && !ecs_locate(w, parent, &above, &parent_row)))
        return KD_NOT_FOUND;
    if (!n)
        return KD_OK;
    instancing in = {.w = w, .base = t->depth, .new_base = above ? above->depth + 1u : 0, .n = n};
    in.parent = above ? ecs_entities(above)[parent_row] : KD_NO_ENTITY;
    ecs_structure_changed(w, "kd_instantiate");
    w->event_hold++;
    kd_status status = instantiate(&in, ecs_entities(t)[row].index);
    if (!status && roots)
        memcpy(roots, in.made, n * sizeof *roots);
    free_lists(&in);
    w->event_hold--;
    ecs_events_settle(w);
    return status;
}

kd_entity kd_clone(kd_world *w, kd_entity e)
{
    kd_entity copy;
    return kd_instantiate(w, e, kd_get_parent(w, e), 1, &copy) ? KD_NO_ENTITY : copy;
}
