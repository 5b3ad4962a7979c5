#ifndef KD_ECS_WORLD_H
#define KD_ECS_WORLD_H

/* A world of entities in archetype tables. Same calls give the same handles and the same order, at any thread
 * count.
 *
 * A world holds up to 2^27 entities, 2^19 tables, 512 components and chains 65535 deep; calls that would pass
 * that fail as if memory were out. Pointers to values are valid until the next structural change (spawn,
 * destroy, adding or removing a component, a change of depth). Values given to a call may lie in the world
 * itself. on_remove hooks run while a table is being changed: they free what the value owns and call nothing
 * of the world. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"
#include "runtime/ecs/component.h"
#include "runtime/ecs/layout.h"

typedef struct kd_entity {
    uint32_t index;
    uint32_t generation; /* 0: no entity */
} kd_entity;

#define KD_NO_ENTITY ((kd_entity){0, 0})
static inline bool kd_entity_equal(kd_entity a, kd_entity b)
{
    return a.index == b.index && a.generation == b.generation;
}

typedef struct kd_world kd_world;
typedef uint32_t kd_component_id; /* 0: none */

/* ---- worlds ---- */
kd_world *kd_world_make(void); /* NULL when memory is out */
void kd_world_destroy(kd_world *w);

/* ---- components of a world ---- */
/** Find the id that `w` gave to the component, registering it first when it is new. `desc` must outlive the
 * world. Two descriptions of one name are one component. Returns 0 when memory is out, 512 are there,
 * sizes disagree or its flags or alignment cannot be had. Threading: any. */
static inline kd_component_id kd_component_ensure(kd_world *w, const kd_component_desc *desc);
/** Find by the name that scripts write. Returns 0 when there is none. */
kd_component_id kd_component_find(const kd_world *w, const char *name);
const kd_component_desc *kd_component_info(const kd_world *w, kd_component_id id);
uint32_t kd_component_count(const kd_world *w); /* ids run from 1 to this */
#define KD_ID(w, type) kd_component_ensure((w), &type##_desc)

/* ---- entities ---- */
typedef struct kd_value {
    const kd_component_desc *desc;
    const void *value; /* NULL: the component's default */
} kd_value;
#define KD_VAL(type, ...) ((kd_value){&type##_desc, &(const type)__VA_ARGS__})
/* The value that `pointer` (to the type; the compiler checks it) points to. */
#define KD_VAL_AT(type, pointer) ((kd_value){&type##_desc, (const type *){(pointer)}})
#define KD_TAG(type)             ((kd_value){&type##_desc, NULL})

/** Make one entity with all its values in one table write. Returns KD_NO_ENTITY when memory is out: the
 * caller keeps what the values own. */
kd_entity kd_spawn_values(kd_world *w, const kd_value *values, uint32_t count);
#define kd_spawn(w, ...)                                                                                     \
    kd_spawn_values((w), (const kd_value[]){__VA_ARGS__},                                                    \
                    (uint32_t)(sizeof((const kd_value[]){__VA_ARGS__}) / sizeof(kd_value)))
/** The same as the last child of `parent`. Returns KD_NO_ENTITY also when the parent is dead. */
kd_entity kd_spawn_child_values(kd_world *w, kd_entity parent, const kd_value *values, uint32_t count);
#define kd_spawn_child(w, parent, ...)                                                                       \
    kd_spawn_child_values((w), (parent), (const kd_value[]){__VA_ARGS__},                                    \
                          (uint32_t)(sizeof((const kd_value[]){__VA_ARGS__}) / sizeof(kd_value)))
/** Make n entities of one archetype; columns[i] holds n values of descs[i] or is NULL for defaults. out may
 * be NULL. */
kd_status kd_spawn_n(kd_world *w, uint32_t n, const kd_component_desc *const *descs,
                     const void *const *columns, uint32_t component_count, kd_entity *out);
/** Destroy an entity and its children, then the sources of relations that cascade (relation.h). A dead handle
 * does nothing. */
void kd_destroy(kd_world *w, kd_entity e);
bool kd_alive(const kd_world *w, kd_entity e);
/** The lasting handle of a living entity (see kd_commands_spawn), else KD_NO_ENTITY. */
kd_entity kd_entity_resolve(const kd_world *w, kd_entity e);
uint32_t kd_entity_count(const kd_world *w);

/* ---- values ---- */
/** Get a value to read. Returns NULL when the entity is dead or lacks it. Valid until the next structural
 * change. */
static inline const void *kd_find_id(const kd_world *w, kd_entity e, kd_component_id id);
/** Get a value to write: marks its chunk as changed. */
void *kd_find_mut_id(kd_world *w, kd_entity e, kd_component_id id);
/** Set a value, adding the component when missing. A value that is replaced is released first (on_remove); to
 * change a part of a component that owns something use kd_find_mut. Errors KD_NOT_FOUND for a dead entity,
 * KD_NO_MEMORY: the caller keeps what the value owns. */
kd_status kd_set_value(kd_world *w, kd_entity e, kd_value value);
/** Take a component off; one that it lacks is as good as taken. Moves the row to another table, so it can
 * fail: NO_MEMORY, nothing is changed. Errors also NOT_FOUND for a dead entity. */
kd_status kd_remove_id(kd_world *w, kd_entity e, kd_component_id id);
/** Tell whether it is there, without access to its value: any system may ask. */
static inline bool kd_has_id(const kd_world *w, kd_entity e, kd_component_id id);
#define kd_find(w, e, type)     ((const type *)kd_find_id((w), (e), KD_ID((kd_world *)(uintptr_t)(w), type)))
#define kd_find_mut(w, e, type) ((type *)kd_find_mut_id((w), (e), KD_ID((w), type)))
#define kd_set(w, e, type, ...) kd_set_value((w), (e), KD_VAL(type, __VA_ARGS__))
#define kd_add(w, e, type)      kd_set_value((w), (e), KD_TAG(type))
#define kd_remove(w, e, type)   kd_remove_id((w), (e), KD_ID((w), type))
#define kd_has(w, e, type)      kd_has_id((w), (e), KD_ID((kd_world *)(uintptr_t)(w), type))

/* ---- one component of many entities, in any order ---- */
/* What kd_find finds out each time, found out once: for loops that follow handles. */
typedef struct kd_lookup {
    const ecs_record *records;
    uint8_t *const *columns; /* by table */
    uint32_t entity_limit, table_limit, size;
    const kd_world *world;
    uint64_t structure;
} kd_lookup;
/** Prepare it for a component that lies in tables: one with a size, and not sparse. Like a pointer to a value
 * it is valid until the next structural change, and so is what it finds. Threading: whoever may read the
 * component. */
kd_lookup kd_lookup_make(kd_world *w, const kd_component_desc *desc);
/** Get a value to read. NULL when the entity is dead or lacks it, and for a handle of kd_commands_spawn: pass
 * those through kd_entity_resolve. */
static inline const void *kd_lookup_find(const kd_lookup *l, kd_entity e);
#define KD_LOOKUP(w, type) kd_lookup_make((w), &type##_desc)

/* ---- enable bits of components declared KD_COMPONENT_TOGGLE ---- */
/** Hide a component of an entity from queries, or show it again; it starts enabled. To a query a disabled
 * component is absent (rows with READ, WRITE or WITH are skipped, OPTIONAL gives NULL, WITHOUT matches);
 * kd_find, kd_set and kd_has still see it. No row moves, and calling it while a query is iterated is allowed:
 * rows shown later heed it. Removing the component forgets the bit.
 *  Errors  NOT_FOUND for a dead entity or one without it; UNSUPPORTED, with a message, when it is not
 * declared so Threading  the owner of the world; from jobs record kd_commands_enable */
kd_status kd_enable_id(kd_world *w, kd_entity e, kd_component_id id, bool enabled);
bool kd_is_enabled_id(const kd_world *w, kd_entity e, kd_component_id id); /* false also when it lacks it */
#define kd_enable(w, e, type)     kd_enable_id((w), (e), KD_ID((w), type), true)
#define kd_disable(w, e, type)    kd_enable_id((w), (e), KD_ID((w), type), false)
#define kd_is_enabled(w, e, type) kd_is_enabled_id((w), (e), KD_ID((kd_world *)(uintptr_t)(w), type))

/* ---- one of a kind: a value that belongs to the world (frame time, settings, stores) ---- */
void *kd_singleton_ensure(kd_world *w, const kd_component_desc *desc); /* starts as the default */
void *kd_singleton_find(const kd_world *w, kd_component_id id);        /* NULL when nobody asked for it yet */
#define kd_singleton(w, type) ((type *)kd_singleton_ensure((w), &type##_desc))

/* ---- names ---- */
kd_status kd_set_name(kd_world *w, kd_entity e,
                      const char *name);                 /* copied; need not be unique; NULL or "" removes */
const char *kd_get_name(const kd_world *w, kd_entity e); /* "" when it has none */
kd_entity kd_find_named(const kd_world *w, const char *name); /* named first among equals */
kd_entity kd_next_named(const kd_world *w, kd_entity e);      /* the next one of the same name */

/* ---- hierarchy: ordered children; depth 0 is a root ---- */
kd_status kd_set_parent(kd_world *w, kd_entity child,
                        kd_entity parent); /* KD_NO_ENTITY orphans; OUT_OF_RANGE for a cycle */
kd_entity kd_get_parent(const kd_world *w, kd_entity e);
uint32_t kd_get_depth(const kd_world *w, kd_entity e);
kd_entity kd_first_child(const kd_world *w, kd_entity e);
kd_entity kd_next_sibling(const kd_world *w, kd_entity e);

/* ---- commands: structural changes recorded now, applied at the next merge ---- */
/* While a query is being iterated, or from jobs, structure is changed through commands only. Each worker has
 * its own buffer; a merge applies them ordered by (sort key, order of recording, worker). Jobs that may run
 * side by side set sort keys of their own: then the result is the same whichever worker ran them. Nothing
 * recorded is seen before the merge; commands on entities that are dead by then do nothing. What a recorded
 * value owns belongs to the buffer, which releases it (on_remove) when it finds no place. A command for which
 * there is no memory is not recorded: kd_commands_spawn and kd_commands_set say so and leave the value to the
 * caller, and the merge reports it. */
typedef struct kd_commands kd_commands;
/** Get the buffer of one worker (0 … KD_MAX_WORKERS-1). */
kd_commands *kd_world_commands(kd_world *w, uint32_t worker);
void kd_commands_key(kd_commands *c, uint64_t sort_key); /* of what is recorded next; default 0 */
/** Record a new entity. The handle may be used in commands and in KD_ENTITY fields of recorded values at
 * once, and for everything else after the merge, until the next merge that spawns; kd_entity_resolve gives
 * the one to keep. */
kd_entity kd_commands_spawn(kd_commands *c, const kd_value *values, uint32_t count);
void kd_commands_destroy(kd_commands *c, kd_entity e);
kd_status kd_commands_set(kd_commands *c, kd_entity e, kd_value value);
void kd_commands_remove(kd_commands *c, kd_entity e, const kd_component_desc *desc);
void kd_commands_enable(kd_commands *c, kd_entity e, const kd_component_desc *desc, bool enabled);
void kd_commands_set_parent(kd_commands *c, kd_entity child, kd_entity parent);
void kd_commands_set_name(kd_commands *c, kd_entity e, const char *name);
bool kd_world_has_commands(const kd_world *w);
/** Apply everything recorded. Called between phases by the scheduler.
 *  Errors     NO_MEMORY when a command could not be recorded or applied (all others are), or when there was
 * no room to begin: then nothing is applied and everything waits still (kd_world_has_commands). Else what the
 *             direct call gives for the first command that is refused, with its message: OUT_OF_RANGE for a
 * parent below its child, UNSUPPORTED, BAD_FORMAT, …; all others are applied Threading  the caller owns the
 * world */
kd_status kd_world_merge(kd_world *w);

/* ---- statistics ---- */
uint64_t kd_world_checksum(const kd_world *w); /* of entities and described fields; no singletons */
size_t kd_world_bytes(const kd_world *w);      /* heap held */
void kd_world_limit_bytes(kd_world *w,
                          size_t bytes); /* calls that would pass it fail with KD_NO_MEMORY; 0: no limit */

#define KD_MAX_WORKERS 64

/* ---- inlined ---- */
kd_component_id ecs_component_ensure_slow(kd_world *w, const kd_component_desc *desc);
void ecs_lookup_check(const kd_lookup *l);
void ecs_watch_value(const kd_world *w, kd_component_id id, bool write); /* see kd_schedule_check */
const void *ecs_find_slow(const kd_world *w, kd_entity e, kd_component_id id);

static inline kd_component_id kd_component_ensure(kd_world *w, const kd_component_desc *desc)
{
    const ecs_world_head *head = (const ecs_world_head *)(const void *)w;
    uint32_t slot = ecs_desc_slot(desc);
    return __atomic_load_n(&head->desc_keys[slot], __ATOMIC_ACQUIRE) == desc
               ? head->desc_ids[slot]
               : ecs_component_ensure_slow(w, desc);
}

static inline const void *kd_lookup_find(const kd_lookup *l, kd_entity e)
{
#ifndef NDEBUG
    ecs_lookup_check(l);
#endif
    ecs_record r = e.index < l->entity_limit ? l->records[e.index] : ECS_DEAD;
    uint32_t table = ecs_record_table(r);
    if (ecs_record_generation(r) != e.generation || table >= l->table_limit)
        return NULL;
    const uint8_t *column = l->columns[table];
    return column ? column + (size_t)ecs_record_row(r) * l->size : NULL;
}

static inline const void *ecs_find(const kd_world *w, kd_entity e, kd_component_id id)
{
    const ecs_world_head *head = (const ecs_world_head *)(const void *)w;
    const ecs_places *p = &head->places[id <= ECS_MAX_COMPONENTS ? id : 0];
    ecs_record r = e.index < head->entity_limit ? head->records[e.index] : ECS_DEAD;
    uint32_t table = ecs_record_table(r);
    if (ecs_record_generation(r) == e.generation && table < p->limit && p->columns[table])
        return p->columns[table] + (size_t)ecs_record_row(r) * p->size;
    return ecs_find_slow(w, e, id); /* dead, absent, a tag, sparse, or a pending handle */
}

static inline const void *kd_find_id(const kd_world *w, kd_entity e, kd_component_id id)
{
#ifndef NDEBUG
    ecs_watch_value(w, id, false);
#endif
    return ecs_find(w, e, id);
}

static inline bool kd_has_id(const kd_world *w, kd_entity e, kd_component_id id)
{
    return ecs_find(w, e, id) != NULL;
}

#endif
