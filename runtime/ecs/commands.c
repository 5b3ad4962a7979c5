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
 * the lasting one.
 *
 * A loop over a query records the same change of entity after entity. Sets of one component that follow each
 * other under one key are one command with many items: half the bytes, and what a merge can apply at once. */

#include <assert.h>

#include "runtime/ecs/commands_format.h"
#include "runtime/ecs/relation.h"

#define WORKER_BITS 6u
#define MERGE_MASK  0x1ffffffu

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

void ecs_commands_settle_fields(const kd_world *w, kd_component_id id, uint8_t *value)
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

/* 0, noted in the buffer, for a description that the world refuses. */
static kd_component_id id_of(kd_commands *c, const kd_component_desc *desc)
{
    kd_component_id id = kd_component_ensure(c->world, desc);
    if (!id)
        c->failed = ecs_worse(c->failed, ecs_component_refusal(c->world, desc));
    return id;
}

static bool bytes_reserve(kd_commands *c, size_t n)
{
    if (n <= c->byte_capacity - c->byte_count)
        return true;
    bool done = c->byte_count + n <= UINT32_MAX && ecs_reserve(c->world, &c->bytes, &c->byte_capacity,
                                                               c->byte_count, c->byte_count + (uint32_t)n, 8);
    if (!done)
        c->failed = KD_NO_MEMORY;
    return done;
}

/* Take n units at the end, for which there is room. */
static void *take_units(kd_commands *c, size_t n)
{
    void *at = c->bytes + (size_t)c->byte_count * 8;
    c->byte_count += (uint32_t)n;
    return at;
}

/* Start a command of n units in all; NULL (noted in the buffer) when memory is out. */
static void *record(kd_commands *c, size_t n)
{
    if (!bytes_reserve(c, n))
        return NULL;
    if (c->head_count == c->head_capacity &&
        !ecs_reserve(c->world, &c->heads, &c->head_capacity, c->head_count, c->head_count + 1,
                     sizeof *c->heads)) {
        c->failed = KD_NO_MEMORY;
        return NULL;
    }
    c->heads[c->head_count++] = (ecs_command_head){c->key, c->byte_count, c->worker};
    return take_units(c, n);
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
        ecs_commands_settle_fields(w, id, bytes);
    return bytes + (size_t)command_units(size) * 8;
}

static size_t value_units(const kd_world *w, kd_component_id id, const void *value)
{
    return command_units(sizeof(command_value)) + (value ? command_units(w->components[id].size) : 0);
}

kd_entity kd_commands_spawn(kd_commands *c, const kd_value *values, uint32_t count)
{
    kd_world *w = c->world;
    kd_component_id ids[ECS_MAX_COMPONENTS];
    size_t n = command_units(sizeof(command));
    assert(count <= ECS_MAX_COMPONENTS);
    for (uint32_t i = 0; i < count; i++) {
        ids[i] = id_of(c, values[i].desc);
        if (!ids[i])
            return KD_NO_ENTITY;
        if (!ecs_needs_no_target(w, ids[i])) {
            c->failed = ecs_worse(c->failed, KD_UNSUPPORTED);
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
    command *at = record(c, command_units(sizeof *at));
    if (at)
        *at = (command){COMMAND_DESTROY, 0, lasting(c->world, e)};
}

/* The set that was recorded last, when another item can follow it; else NULL. */
static command_set *open_set(const kd_commands *c, command_value value)
{
    const ecs_command_head *last = c->head_count ? &c->heads[c->head_count - 1] : NULL;
    if (!last || last->key != c->key)
        return NULL;
    command_set *s = (command_set *)(void *)(c->bytes + (size_t)last->offset * 8);
    return s->kind == COMMAND_SET && s->value.id == value.id && s->value.size == value.size ? s : NULL;
}

static uint8_t *record_item(kd_commands *c, command_value value)
{
    size_t n = 1 + command_units(value.size);
    if (open_set(c, value)) {
        if (!bytes_reserve(c, n))
            return NULL;
        open_set(c, value)->count++;
        return take_units(c, n);
    }
    command_set *s = record(c, command_units(sizeof *s) + n);
    if (!s)
        return NULL;
    *s = (command_set){COMMAND_SET, 1, value};
    return (uint8_t *)(s + 1);
}

kd_status kd_commands_set(kd_commands *c, kd_entity e, kd_value value)
{
    kd_world *w = c->world;
    kd_component_id id = id_of(c, value.desc);
    uint32_t size = value.value ? w->components[id].size : 0;
    uint8_t *at = id ? record_item(c, (command_value){id, size}) : NULL;
    if (!at)
        return id ? KD_NO_MEMORY : ecs_component_refusal(w, value.desc);
    e = lasting(w, e);
    memcpy(at, &e, sizeof e);
    if (size)
        memcpy(at + sizeof e, value.value, size);
    if (size && w->components[id].has_entities)
        ecs_commands_settle_fields(w, id, at + sizeof e);
    return KD_OK;
}

void kd_commands_remove(kd_commands *c, kd_entity e, const kd_component_desc *desc)
{
    kd_component_id id = id_of(c, desc);
    command *at = id ? record(c, command_units(sizeof *at)) : NULL;
    if (at)
        *at = (command){COMMAND_REMOVE, id, lasting(c->world, e)};
}

void kd_commands_enable(kd_commands *c, kd_entity e, const kd_component_desc *desc, bool enabled)
{
    kd_component_id id = id_of(c, desc);
    command *at = id ? record(c, command_units(sizeof *at) + 1) : NULL;
    uint64_t word = enabled;
    if (!at)
        return;
    *at = (command){COMMAND_ENABLE, id, lasting(c->world, e)};
    memcpy(at + 1, &word, sizeof word);
}

void kd_commands_set_parent(kd_commands *c, kd_entity child, kd_entity parent)
{
    command *at = record(c, command_units(sizeof *at) + command_units(sizeof parent));
    if (!at)
        return;
    *at = (command){COMMAND_PARENT, 0, lasting(c->world, child)};
    parent = lasting(c->world, parent);
    memcpy(at + 1, &parent, sizeof parent);
}

void kd_commands_set_name(kd_commands *c, kd_entity e, const char *name)
{
    size_t length = name ? strlen(name) + 1 : 1;
    command *at = record(c, command_units(sizeof *at) + command_units(length));
    if (!at)
        return;
    *at = (command){COMMAND_NAME, 0, lasting(c->world, e)};
    memcpy(at + 1, name ? name : "", length);
}

/* The target comes before the value. */
void kd_commands_relate(kd_commands *c, kd_entity source, kd_value relation, kd_entity target)
{
    kd_component_id id = id_of(c, relation.desc);
    size_t n = command_units(sizeof(command)) + command_units(sizeof target);
    command *at = id ? record(c, n + value_units(c->world, id, relation.value)) : NULL;
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
    kd_component_id id = id_of(c, relation);
    command *at = id ? record(c, command_units(sizeof *at) + command_units(sizeof target)) : NULL;
    if (!at)
        return;
    *at = (command){COMMAND_UNRELATE, id, lasting(c->world, source)};
    target = lasting(c->world, target);
    memcpy(at + 1, &target, sizeof target);
}

bool kd_world_has_commands(const kd_world *w)
{
    for (uint32_t i = 0; i < KD_MAX_WORKERS; i++)
        if (w->commands[i].head_count)
            return true;
    return false;
}
