/* Applying what workers recorded: the commands of all buffers in one order, and runs of them at once. */

#include <stdlib.h>

#include "runtime/core/log.h"
#include "runtime/ecs/commands_format.h"
#include "runtime/ecs/relation.h"

#define SHORTEST_RUN 4u /* rows that are worth moving together */

/* ---- values of one entity ---- */
static const void *read_value(kd_world *w, uint8_t **at, kd_component_id *id)
{
    command_value head;
    memcpy(&head, *at, sizeof head);
    uint8_t *bytes = *at + sizeof head;
    *id = head.id;
    *at = bytes + (size_t)command_units(head.size) * 8;
    if (head.size && w->components[head.id].has_entities)
        ecs_commands_settle_fields(w, head.id, bytes);
    return head.size ? bytes : NULL;
}

/* Release a value where it was recorded, at a multiple of 8: a hook is given one at a multiple of what its
 * type asks for. */
static void release_recorded(kd_world *w, kd_component_id id, uint8_t *value)
{
    const kd_component_desc *desc = w->components[id].desc;
    _Alignas(64) uint8_t small[1024];
    if (!desc->on_remove)
        return;
    if (desc->align <= 8 || (uintptr_t)value % desc->align == 0) {
        ecs_release_value(w, id, value);
        return;
    }
    uint8_t *copy = desc->size <= sizeof small ? small : ecs_grow(w, NULL, 0, desc->size);
    if (!copy) {
        kd_log(KD_LOG_ERROR, "component %s: no memory to release a recorded value; what it owns is lost",
               desc->name);
        return;
    }
    memcpy(copy, value, desc->size);
    ecs_release_value(w, id, copy);
    if (copy != small)
        ecs_free(w, copy);
}

/* Values that find no place: what they own was given to the buffer, so it is released here. */
static void drop_values(kd_world *w, uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        command_value head;
        memcpy(&head, bytes, sizeof head);
        bytes += sizeof head;
        if (head.size)
            release_recorded(w, head.id, bytes);
        bytes += (size_t)command_units(head.size) * 8;
    }
}

static kd_status apply_spawn(kd_world *w, kd_commands *c, const command *at)
{
    kd_component_id ids[ECS_MAX_COMPONENTS];
    const void *values[ECS_MAX_COMPONENTS];
    uint8_t *first = (uint8_t *)(uintptr_t)(at + 1), *bytes = first;
    for (uint32_t i = 0; i < at->count; i++)
        values[i] = read_value(w, &bytes, &ids[i]);
    kd_entity e = ecs_spawn_ids(w, ids, values, at->count);
    c->spawned[at->e.index] = e;
    if (!e.generation)
        drop_values(w, first, at->count);
    return e.generation ? KD_OK : KD_NO_MEMORY;
}

/* ---- sets ---- */
static uint8_t *item_at(const command_set *s, uint32_t i)
{
    return (uint8_t *)(uintptr_t)(s + 1) + i * command_stride(s);
}

static kd_entity item_entity(const command_set *s, uint32_t i)
{
    kd_entity e;
    memcpy(&e, item_at(s, i), sizeof e);
    return e;
}

/* NULL: the default. */
static void *item_value(kd_world *w, const command_set *s, uint32_t i)
{
    uint8_t *value = item_at(s, i) + sizeof(kd_entity);
    if (s->value.size && w->components[s->value.id].has_entities)
        ecs_commands_settle_fields(w, s->value.id, value);
    return s->value.size ? value : NULL;
}

/* How many items from i on add the component to entities that lie one behind the other in one table, which is
 * what a loop over a query records. 0 when item i adds nothing to a table. */
static uint32_t run_length(const kd_world *w, const command_set *s, uint32_t i, ecs_table **t, uint32_t *row)
{
    if (w->components[s->value.id].sparse || !ecs_locate(w, item_entity(s, i), t, row) ||
        ecs_column_of(*t, s->value.id))
        return 0;
    const ecs_record *records = w->head.records;
    uint32_t limit = w->head.entity_limit, n = 1;
    for (; n < s->count - i; n++) {
        kd_entity e = item_entity(s, i + n);
        if (e.index >= limit || e.generation > ECS_MAX_GENERATION ||
            records[e.index] != ecs_record_make((*t)->index, *row + n, e.generation))
            break;
    }
    return n;
}

/* Add the component to n rows at once: whole stretches of columns are copied. False when memory is out. */
static bool apply_run(kd_world *w, const command_set *s, uint32_t i, uint32_t n, ecs_table *t, uint32_t row)
{
    kd_component_id id = s->value.id;
    ecs_table *to = ecs_neighbour(w, t, id);
    if (!to || n > ECS_ROW_MASK - to->count || !ecs_table_reserve(w, to, to->count + n))
        return false;
    uint32_t first = to->count, column = to->column_of[id];
    ecs_table_move_rows(w, t, row, n, to);
    for (uint32_t k = 0; k < n && column != ECS_TAG_COLUMN; k++)
        ecs_write_value(w, id, to->columns[column].data + (size_t)(first + k) * to->columns[column].size,
                        item_value(w, s, i + k));
    for (uint32_t k = 0; k < n && w->observed[id]; k++)
        ecs_event(w, KD_ON_ADD, ecs_entities(to)[first + k], id, NULL);
    return true;
}

static kd_status apply_item(kd_world *w, const command_set *s, uint32_t i)
{
    void *value = item_value(w, s, i);
    kd_status status = ecs_set_id(w, item_entity(s, i), s->value.id, value);
    if (status && value)
        release_recorded(w, s->value.id, value);
    return status;
}

static kd_status apply_set(kd_world *w, const command_set *s)
{
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < s->count;) {
        ecs_table *t;
        uint32_t row, n = run_length(w, s, i, &t, &row);
        if (n >= SHORTEST_RUN && apply_run(w, s, i, n, t, row)) {
            i += n;
            continue;
        }
        for (uint32_t end = n > 1 ? i + n : i + 1; i < end; i++)
            status = ecs_worse(status, apply_item(w, s, i));
    }
    return status;
}

static void drop_items(kd_world *w, const command_set *s)
{
    for (uint32_t i = 0; i < s->count && s->value.size; i++)
        release_recorded(w, s->value.id, item_at(s, i) + sizeof(kd_entity));
}

/* ---- all kinds ---- */
static kd_status apply_relate(kd_world *w, const command *at)
{
    kd_entity target;
    uint8_t *first = (uint8_t *)(uintptr_t)(at + 1) + sizeof target, *bytes = first;
    kd_component_id id;
    memcpy(&target, at + 1, sizeof target);
    const void *value = read_value(w, &bytes, &id);
    kd_status status = ecs_relate_id(w, at->e, id, value, target);
    if (status)
        drop_values(w, first, 1);
    return status;
}

static kd_status apply(kd_world *w, kd_commands *c, const command *at)
{
    const void *bytes = at + 1;
    kd_entity other;
    uint64_t word;
    switch (at->kind) {
    case COMMAND_SPAWN: return apply_spawn(w, c, at);
    case COMMAND_DESTROY: kd_destroy(w, at->e); return KD_OK;
    case COMMAND_SET: return apply_set(w, (const command_set *)(const void *)at);
    case COMMAND_REMOVE: return kd_remove_id(w, at->e, at->count);
    case COMMAND_ENABLE:
        memcpy(&word, bytes, sizeof word);
        return kd_enable_id(w, at->e, at->count, word != 0);
    case COMMAND_PARENT: memcpy(&other, bytes, sizeof other); return kd_set_parent(w, at->e, other);
    case COMMAND_RELATE: return apply_relate(w, at);
    case COMMAND_UNRELATE:
        memcpy(&other, bytes, sizeof other);
        kd_unrelate_id(w, at->e, at->count, other);
        return KD_OK;
    default: return kd_set_name(w, at->e, bytes);
    }
}

/* ---- order ---- */
static int by_order(const void *a, const void *b)
{
    const ecs_command_head *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    if (x->offset != y->offset)
        return x->offset < y->offset ? -1 : 1;
    return x->worker < y->worker ? -1 : x->worker > y->worker;
}

static bool keys_ascend(const kd_commands *c)
{
    for (uint32_t i = 1; i < c->head_count; i++)
        if (c->heads[i].key < c->heads[i - 1].key)
            return false;
    return true;
}

/* All heads in order of application: one buffer's own array when it is in order already, else a sorted copy.
 */
static ecs_command_head *order_heads(kd_world *w, uint32_t total, bool *owned)
{
    uint32_t at = 0;
    *owned = false;
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++)
        if (w->commands[i].head_count == total && keys_ascend(&w->commands[i]))
            return w->commands[i].heads;
    ecs_command_head *heads = ecs_grow(w, NULL, 0, total * sizeof *heads);
    if (!heads)
        return NULL;
    *owned = true;
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        kd_commands *c = &w->commands[i];
        if (c->head_count)
            memcpy(heads + at, c->heads, c->head_count * sizeof *heads);
        at += c->head_count;
    }
    qsort(heads, total, sizeof *heads, by_order);
    return heads;
}

/* Forget what the last merge made and make room for what this one will. */
static bool spawned_reserve(kd_world *w)
{
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        kd_commands *c = &w->commands[i];
        if (!ecs_reserve(w, &c->spawned, &c->spawned_capacity, 0, c->spawn_count, sizeof *c->spawned))
            return false;
    }
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        kd_commands *c = &w->commands[i];
        if (c->spawn_count)
            memset(c->spawned, 0, c->spawn_count * sizeof *c->spawned);
        c->spawned_count = c->spawn_count;
        c->spawn_count = 0;
    }
    return true;
}

static const command *command_at(const kd_world *w, const ecs_command_head *head)
{
    return (const command *)(const void *)(w->commands[head->worker].bytes + (size_t)head->offset * 8);
}

static void tell_refused_parent(const kd_world *w, const command *at)
{
    kd_entity parent;
    memcpy(&parent, at + 1, sizeof parent);
    parent = kd_entity_resolve(w, parent);
    kd_log(KD_LOG_ERROR,
           "commands: entity %u cannot hang below entity %u, which is below it or at the greatest depth; "
           "compare "
           "parents before recording the command (told once a merge)",
           (unsigned)kd_entity_resolve(w, at->e).index, (unsigned)parent.index);
}

static kd_status apply_all(kd_world *w, const ecs_command_head *heads, uint32_t total)
{
    kd_status status = KD_OK;
    bool told = false;
    for (uint32_t i = 0; i < total; i++) {
        const command *at = command_at(w, &heads[i]);
        kd_status one = apply(w, &w->commands[heads[i].worker], at);
        if (one == KD_OUT_OF_RANGE && at->kind == COMMAND_PARENT && !told) {
            tell_refused_parent(w, at);
            told = true;
        }
        status = ecs_worse(status, one);
    }
    return status;
}

kd_status kd_world_merge(kd_world *w)
{
    uint64_t total = 0, spawns = 0;
    kd_status failed = KD_OK;
    bool owned;
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        total += w->commands[i].head_count;
        spawns += w->commands[i].spawn_count;
        failed = ecs_worse(failed, w->commands[i].failed);
    }
    if (total > UINT32_MAX)
        return KD_TOO_LARGE;
    ecs_command_head *heads = total ? order_heads(w, (uint32_t)total, &owned) : NULL;
    if (total && (!heads || (spawns && !spawned_reserve(w)))) {
        if (heads && owned)
            ecs_free(w, heads);
        return KD_NO_MEMORY;
    }
    w->merging = spawns != 0;
    w->event_hold++;
    if (total)
        ecs_structure_changed(w, "kd_world_merge");
    kd_status status = total ? apply_all(w, heads, (uint32_t)total) : KD_OK;
    w->merging = false;
    w->merge_number += spawns != 0;
    if (total && owned)
        ecs_free(w, heads);
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        w->commands[i].head_count = w->commands[i].byte_count = 0;
        w->commands[i].key = 0;
        w->commands[i].failed = KD_OK;
    }
    w->event_hold--;
    ecs_events_settle(w);
    return ecs_worse(failed, status);
}

void ecs_commands_fini(kd_world *w)
{
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        kd_commands *c = &w->commands[i];
        for (uint32_t k = 0; k < c->head_count; k++) {
            const command *at = command_at(w, &c->heads[k]);
            uint8_t *values = (uint8_t *)(uintptr_t)(at + 1);
            if (at->kind == COMMAND_SPAWN)
                drop_values(w, values, at->count);
            else if (at->kind == COMMAND_SET)
                drop_items(w, (const command_set *)(const void *)at);
            else if (at->kind == COMMAND_RELATE)
                drop_values(w, values + sizeof(kd_entity), 1);
        }
        ecs_free(w, c->heads);
        ecs_free(w, c->bytes);
        ecs_free(w, c->spawned);
    }
}
