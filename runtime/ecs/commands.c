/* Structural changes recorded by workers and merged in a defined order.
 *
 * A buffer is two arrays: heads (sort key, where the command lies) and bytes. A merge visits the heads of all
 * buffers ordered by (key, order of recording in the buffer, worker). What a job records is the same on any
 * worker, so when jobs that may run side by side use keys of their own (the scheduler gives each system one,
 * a parallel loop adds its range), the order of the merge, and with it every handle, is the same at any
 * thread count.
 *
 * That is also why a spawned entity cannot have its index before the merge: which index is free next depends
 * on all the commands before it. kd_commands_spawn gives a pending handle: ECS_PENDING, the number of the
 * merge to come, the worker and a serial number. The merge notes which entity each became; locating a pending
 * handle looks there. Every pending handle inside recorded values (fields of type KD_ENTITY) is replaced by
 * the lasting one. */

#include <assert.h>
#include <stdlib.h>

#include "runtime/ecs/internal.h"
#include "runtime/ecs/relation.h"

#define WORKER_BITS  6u
#define MERGE_MASK   0x1ffffffu
#define SHORTEST_RUN 4u /* rows that are worth moving together */

enum { COMMAND_SPAWN, COMMAND_DESTROY, COMMAND_SET, COMMAND_REMOVE, COMMAND_ENABLE, COMMAND_PARENT, COMMAND_NAME,
       COMMAND_RELATE, COMMAND_UNRELATE };

typedef struct command {
    uint32_t kind;
    uint32_t count; /* values that follow; serial number of a spawn comes in e.index */
    kd_entity e;
} command;

typedef struct command_value {
    kd_component_id id;
    uint32_t size; /* bytes that follow, padded to 8; 0: the default */
} command_value;

_Static_assert(KD_MAX_WORKERS <= 1u << WORKER_BITS, "a worker number fits into a pending handle");

/* ---- pending handles ---- */
static kd_entity pending_handle(const kd_commands *c, uint32_t serial)
{
    return (kd_entity){serial,
                       ECS_PENDING | (c->world->merge_number & MERGE_MASK) << WORKER_BITS | c->worker};
}

kd_entity ecs_commands_resolve(const kd_world *w, kd_entity e)
{
    uint32_t merge = (e.generation & ~ECS_PENDING) >> WORKER_BITS;
    uint32_t known = (w->merging ? w->merge_number : w->merge_number - 1) & MERGE_MASK;
    const kd_commands *c = &w->commands[e.generation & ((1u << WORKER_BITS) - 1)];
    return merge == known && e.index < c->spawned_count ? c->spawned[e.index] : KD_NO_ENTITY;
}

static kd_entity lasting(const kd_world *w, kd_entity e)
{
    if (!(e.generation & ECS_PENDING))
        return e;
    kd_entity known = ecs_commands_resolve(w, e);
    return known.generation ? known : e;
}

/* Replace the pending handles in the fields of a value by those known now. */
static void settle_fields(const kd_world *w, kd_component_id id, uint8_t *value)
{
    const kd_component_desc *desc = w->components[id].desc;
    for (uint32_t i = 0; i < desc->field_count; i++) {
        const kd_field *f = &desc->fields[i];
        for (uint32_t at = 0; f->type == KD_ENTITY && at + sizeof(kd_entity) <= f->size;
             at += sizeof(kd_entity)) {
            kd_entity e;
            memcpy(&e, value + f->offset + at, sizeof e);
            e = lasting(w, e);
            memcpy(value + f->offset + at, &e, sizeof e);
        }
    }
}

/* ---- recording ---- */
kd_commands *kd_world_commands(kd_world *w, uint32_t worker)
{
    assert(worker < KD_MAX_WORKERS);
    return &w->commands[worker];
}

void kd_commands_key(kd_commands *c, uint64_t sort_key)
{
    c->key = sort_key;
}

static uint32_t units(size_t bytes)
{
    return (uint32_t)((bytes + 7) / 8);
}

/* Start a command of n units in all; NULL (noted in the buffer) when memory is out. */
static void *record(kd_commands *c, size_t n)
{
    if (c->byte_count + n > UINT32_MAX ||
        !ecs_reserve(c->world, &c->heads, &c->head_capacity, c->head_count, c->head_count + 1,
                     sizeof *c->heads) ||
        !ecs_reserve(c->world, &c->bytes, &c->byte_capacity, c->byte_count, c->byte_count + (uint32_t)n, 8)) {
        c->failed = true;
        return NULL;
    }
    c->heads[c->head_count++] = (ecs_command_head){c->key, c->byte_count, c->worker};
    void *at = c->bytes + (size_t)c->byte_count * 8;
    c->byte_count += (uint32_t)n;
    return at;
}

static void *write_value(const kd_world *w, void *to, kd_component_id id, const void *value)
{
    const ecs_component *component = &w->components[id];
    uint32_t size = value ? component->size : 0;
    command_value head = {id, size};
    memcpy(to, &head, sizeof head);
    uint8_t *bytes = (uint8_t *)to + sizeof head;
    if (size)
        memcpy(bytes, value, size);
    if (size && component->has_entities)
        settle_fields(w, id, bytes);
    return bytes + (size_t)units(size) * 8;
}

static size_t value_units(const kd_world *w, kd_component_id id, const void *value)
{
    return units(sizeof(command_value)) + (value ? units(w->components[id].size) : 0);
}

kd_entity kd_commands_spawn(kd_commands *c, const kd_value *values, uint32_t count)
{
    kd_world *w = c->world;
    kd_component_id ids[ECS_MAX_COMPONENTS];
    size_t n = units(sizeof(command));
    assert(count <= ECS_MAX_COMPONENTS);
    for (uint32_t i = 0; i < count; i++) {
        ids[i] = kd_component_ensure(w, values[i].desc);
        if (!ids[i] || !ecs_needs_no_target(w, ids[i])) {
            c->failed = true;
            return KD_NO_ENTITY;
        }
        n += value_units(w, ids[i], values[i].value);
    }
    command *at = record(c, n);
    if (!at)
        return KD_NO_ENTITY;
    kd_entity e = pending_handle(c, c->spawn_count++);
    *at = (command){COMMAND_SPAWN, count, e};
    void *to = at + 1;
    for (uint32_t i = 0; i < count; i++)
        to = write_value(w, to, ids[i], values[i].value);
    return e;
}

void kd_commands_destroy(kd_commands *c, kd_entity e)
{
    command *at = record(c, units(sizeof *at));
    if (at)
        *at = (command){COMMAND_DESTROY, 0, lasting(c->world, e)};
}

kd_status kd_commands_set(kd_commands *c, kd_entity e, kd_value value)
{
    kd_component_id id = kd_component_ensure(c->world, value.desc);
    command *at = id ? record(c, units(sizeof *at) + value_units(c->world, id, value.value)) : NULL;
    c->failed |= !id;
    if (!at)
        return KD_NO_MEMORY;
    *at = (command){COMMAND_SET, 1, lasting(c->world, e)};
    write_value(c->world, at + 1, id, value.value);
    return KD_OK;
}

void kd_commands_remove(kd_commands *c, kd_entity e, const kd_component_desc *desc)
{
    kd_component_id id = kd_component_ensure(c->world, desc);
    command *at = id ? record(c, units(sizeof *at)) : NULL;
    c->failed |= !id;
    if (at)
        *at = (command){COMMAND_REMOVE, id, lasting(c->world, e)};
}

void kd_commands_enable(kd_commands *c, kd_entity e, const kd_component_desc *desc, bool enabled)
{
    kd_component_id id = kd_component_ensure(c->world, desc);
    command *at = id ? record(c, units(sizeof *at) + 1) : NULL;
    uint64_t word = enabled;
    c->failed |= !id;
    if (!at)
        return;
    *at = (command){COMMAND_ENABLE, id, lasting(c->world, e)};
    memcpy(at + 1, &word, sizeof word);
}

void kd_commands_set_parent(kd_commands *c, kd_entity child, kd_entity parent)
{
    command *at = record(c, units(sizeof *at) + units(sizeof parent));
    if (!at)
        return;
    *at = (command){COMMAND_PARENT, 0, lasting(c->world, child)};
    parent = lasting(c->world, parent);
    memcpy(at + 1, &parent, sizeof parent);
}

void kd_commands_set_name(kd_commands *c, kd_entity e, const char *name)
{
    size_t length = name ? strlen(name) + 1 : 1;
    command *at = record(c, units(sizeof *at) + units(length));
    if (!at)
        return;
    *at = (command){COMMAND_NAME, 0, lasting(c->world, e)};
    memcpy(at + 1, name ? name : "", length);
}

/* The target comes before the value. */
void kd_commands_relate(kd_commands *c, kd_entity source, kd_value relation, kd_entity target)
{
    kd_component_id id = kd_component_ensure(c->world, relation.desc);
    size_t n = units(sizeof(command)) + units(sizeof target);
    command *at = id ? record(c, n + value_units(c->world, id, relation.value)) : NULL;
    c->failed |= !id;
    if (!at)
        return;
    *at = (command){COMMAND_RELATE, 1, lasting(c->world, source)};
    target = lasting(c->world, target);
    memcpy(at + 1, &target, sizeof target);
    write_value(c->world, (uint8_t *)(at + 1) + sizeof target, id, relation.value);
}

void kd_commands_unrelate(kd_commands *c, kd_entity source, const kd_component_desc *relation,
                          kd_entity target)
{
    kd_component_id id = kd_component_ensure(c->world, relation);
    command *at = id ? record(c, units(sizeof *at) + units(sizeof target)) : NULL;
    c->failed |= !id;
    if (!at)
        return;
    *at = (command){COMMAND_UNRELATE, id, lasting(c->world, source)};
    target = lasting(c->world, target);
    memcpy(at + 1, &target, sizeof target);
}

/* ---- applying ---- */
static const void *read_value(kd_world *w, uint8_t **at, kd_component_id *id)
{
    command_value head;
    memcpy(&head, *at, sizeof head);
    uint8_t *bytes = *at + sizeof head;
    *id = head.id;
    *at = bytes + (size_t)units(head.size) * 8;
    if (head.size && w->components[head.id].has_entities)
        settle_fields(w, head.id, bytes);
    return head.size ? bytes : NULL;
}

/* Values that find no place: what they own was given to the buffer, so it is released here. */
static void drop_values(kd_world *w, uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        command_value head;
        memcpy(&head, bytes, sizeof head);
        bytes += sizeof head;
        if (head.size)
            ecs_release_value(w, head.id, bytes);
        bytes += (size_t)units(head.size) * 8;
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

static kd_status apply_set(kd_world *w, const command *at)
{
    uint8_t *first = (uint8_t *)(uintptr_t)(at + 1), *bytes = first;
    kd_component_id id;
    const void *value = read_value(w, &bytes, &id);
    kd_status status = ecs_set_id(w, at->e, id, value);
    if (status)
        drop_values(w, first, 1);
    return status;
}

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
    case COMMAND_SPAWN:
        return apply_spawn(w, c, at);
    case COMMAND_DESTROY:
        kd_destroy(w, at->e);
        return KD_OK;
    case COMMAND_SET:
        return apply_set(w, at);
    case COMMAND_REMOVE:
        return kd_remove_id(w, at->e, at->count);
    case COMMAND_ENABLE:
        memcpy(&word, bytes, sizeof word);
        return kd_enable_id(w, at->e, at->count, word != 0);
    case COMMAND_PARENT:
        memcpy(&other, bytes, sizeof other);
        return kd_set_parent(w, at->e, other);
    case COMMAND_RELATE:
        return apply_relate(w, at);
    case COMMAND_UNRELATE:
        memcpy(&other, bytes, sizeof other);
        kd_unrelate_id(w, at->e, at->count, other);
        return KD_OK;
    default:
        return kd_set_name(w, at->e, bytes);
    }
}

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

static kd_component_id set_id(const command *at)
{
    command_value value;
    memcpy(&value, at + 1, sizeof value);
    return value.id;
}

/* How many commands from here on add one component to entities that lie one behind the other in one table:
 * what a loop over a query records. 0 when the first one does not. */
static uint32_t run_length(const kd_world *w, const ecs_command_head *heads, uint32_t count, ecs_table **t,
                           uint32_t *row)
{
    const command *first = command_at(w, heads);
    if (first->kind != COMMAND_SET || w->components[set_id(first)].sparse ||
        !ecs_locate(w, first->e, t, row) || ecs_column_of(*t, set_id(first)))
        return 0;
    uint32_t n = 1;
    for (; n < count; n++) {
        const command *at = command_at(w, &heads[n]);
        ecs_table *other;
        uint32_t other_row;
        if (at->kind != COMMAND_SET || set_id(at) != set_id(first) ||
            !ecs_locate(w, at->e, &other, &other_row) || other != *t || other_row != *row + n)
            break;
    }
    return n;
}

/* Add the component to n rows at once: whole stretches of columns are copied. False when memory is out. */
static bool apply_run(kd_world *w, const ecs_command_head *heads, uint32_t n, ecs_table *t, uint32_t row)
{
    kd_component_id id = set_id(command_at(w, heads));
    ecs_table *to = ecs_neighbour(w, t, id);
    if (!to || n > ECS_ROW_MASK - to->count || !ecs_table_reserve(w, to, to->count + n))
        return false;
    uint32_t first = to->count, column = to->column_of[id];
    ecs_table_move_rows(w, t, row, n, to);
    for (uint32_t i = 0; i < n && column != ECS_TAG_COLUMN; i++) {
        uint8_t *bytes = (uint8_t *)(uintptr_t)(command_at(w, &heads[i]) + 1);
        const void *value = read_value(w, &bytes, &id);
        ecs_write_value(w, id, to->columns[column].data + (size_t)(first + i) * to->columns[column].size,
                        value);
    }
    for (uint32_t i = 0; i < n && w->observed[id]; i++)
        ecs_event(w, KD_ON_ADD, ecs_entities(to)[first + i], id, NULL);
    return true;
}

static kd_status apply_all(kd_world *w, const ecs_command_head *heads, uint32_t total)
{
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < total;) {
        ecs_table *t;
        uint32_t row, n = run_length(w, heads + i, total - i, &t, &row);
        if (n >= SHORTEST_RUN && apply_run(w, heads + i, n, t, row)) {
            i += n;
            continue;
        }
        for (uint32_t end = n > 1 ? i + n : i + 1; i < end; i++)
            if (apply(w, &w->commands[heads[i].worker], command_at(w, &heads[i])) == KD_NO_MEMORY)
                status = KD_NO_MEMORY; /* a dead entity or a cycle is no failure of the merge */
    }
    return status;
}

bool kd_world_has_commands(const kd_world *w)
{
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++)
        if (w->commands[i].head_count)
            return true;
    return false;
}

kd_status kd_world_merge(kd_world *w)
{
    uint64_t total = 0, spawns = 0;
    bool failed = false, owned;
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        total += w->commands[i].head_count;
        spawns += w->commands[i].spawn_count;
        failed |= w->commands[i].failed;
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
        w->commands[i].failed = false;
    }
    w->event_hold--;
    ecs_events_settle(w);
    return failed ? KD_NO_MEMORY : status;
}

void ecs_commands_fini(kd_world *w)
{
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++) {
        kd_commands *c = &w->commands[i];
        for (uint32_t k = 0; k < c->head_count; k++) {
            const command *at = command_at(w, &c->heads[k]);
            uint8_t *values = (uint8_t *)(uintptr_t)(at + 1);
            if (at->kind == COMMAND_SPAWN || at->kind == COMMAND_SET)
                drop_values(w, values, at->count);
            else if (at->kind == COMMAND_RELATE)
                drop_values(w, values + sizeof(kd_entity), 1);
        }
        ecs_free(w, c->heads);
        ecs_free(w, c->bytes);
        ecs_free(w, c->spawned);
    }
}
