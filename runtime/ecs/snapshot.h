#ifndef KD_ECS_SNAPSHOT_H
#define KD_ECS_SNAPSHOT_H

/* A whole world as one block of bytes, and what makes two worlds different.
 *
 *     kd_snapshot s = {0};
 *     if (kd_snapshot_write(w, &s) == KD_OK) …   later …   kd_snapshot_restore(w, s.data, s.size);
 *     kd_snapshot_fini(&s);
 *
 * A snapshot holds every entity with its handle, row, components, pairs, name, parent and place among its
 * siblings, the handles that are free, the tables in their order, and the singletons of plain data. So a
 * restored world has the same checksum (but for transient components, which it lacks), is iterated in the
 * same order, and answers the same calls with the same handles. A singleton of plain data that was not yet
 * made goes back to its default value; no singleton's address changes.
 *
 * Not in it: components and singletons declared KD_COMPONENT_TRANSIENT, and singletons that own something
 * (on_remove): a restore leaves these singletons as they are; queries and their change versions (after a
 * restore everything counts as changed). A component that owns something (on_remove) and is not transient
 * cannot be copied as bytes: writing is refused.
 *
 * The bytes: header (magic, version, byte order, size, XXH3 of all that follows), component table (name,
 * size, hash of the fields), tables (columns copied), free handles, children, names, singletons, sparse
 * values, pairs. They are for programs with the same components on machines of the same byte order;
 * everything else is refused. */

#include "runtime/core/json.h"
#include "runtime/ecs/world.h"

typedef struct kd_snapshot {
    void *data;
    size_t size, capacity; /* bytes */
} kd_snapshot;

/** Write the world into `s`, which starts as {0} and may be used again and again: its memory is kept.
 *  Errors  UNSUPPORTED for a component that owns something and is not transient, or when commands wait for a
 *          merge; TOO_LARGE; NO_MEMORY. s->size is 0 then
 *  Cost    a copy of every column and one pass of XXH3 */
kd_status kd_snapshot_write(const kd_world *w, kd_snapshot *s);
void kd_snapshot_fini(kd_snapshot *s);

/** Replace what the world holds. Its components must be registered (kd_component_ensure, KD_ID), queries stay
 * valid, handles and pointers of before do not. Nothing is changed when an error is returned.
 *  Shapes  data: size bytes as written, at any address; untrusted bytes are checked
 *  Errors  BAD_FORMAT for truncated, foreign, damaged or mismatched data; UNSUPPORTED for another version or
 *          byte order, or when commands wait for a merge; NOT_FOUND for a component the world does not know;
 *          NO_MEMORY. One message says what and where
 *  Cost    a copy of every column. A table that is there already (an earlier state of the same world) keeps
 * its blocks; of others old and new content are held at once until it is done */
kd_status kd_snapshot_restore(kd_world *w, const void *data, size_t size);

/** Write to and restore from a file; a file appears whole or not at all. Errors also those of files. */
kd_status kd_snapshot_save(const kd_world *w, const char *path);
kd_status kd_snapshot_load(kd_world *w, const char *path);

/** Write the world as one JSON object for people: entities in order of iteration with handle, name, parent
 * and components by field, the pairs of its relations; then singletons. Components without described fields
 * give null. */
void kd_world_write_json(const kd_world *w, kd_json *j);

/* ---- what differs ---- */
typedef enum kd_difference_kind {
    KD_DIFFERENCE_ENTITY,    /* only one of the worlds has it: `in` says which, 0 or 1 */
    KD_DIFFERENCE_COMPONENT, /* the entity has it in one world only */
    KD_DIFFERENCE_VALUE,     /* `field` is the first that differs, NULL when none is described */
    KD_DIFFERENCE_ENABLED,   /* it is disabled in one of them: `in` says in which */
    KD_DIFFERENCE_NAME,
    KD_DIFFERENCE_PARENT,
    KD_DIFFERENCE_PAIR,       /* it is related to `target` in one world only */
    KD_DIFFERENCE_PAIR_ORDER, /* its targets, or its sources, come in another order */
    KD_DIFFERENCE_SIBLING,    /* the same parent, but another sibling follows */
    KD_DIFFERENCE_ORDER, /* the first entity at which the orders of iteration part, last of all: once for the
                            tables, then for each sparse component */
} kd_difference_kind;

typedef struct kd_difference {
    kd_difference_kind kind;
    kd_entity entity;
    uint32_t in;
    const kd_component_desc *component; /* NULL where none is concerned */
    const kd_field *field;
    kd_entity target; /* of a pair, else KD_NO_ENTITY */
} kd_difference;

/** Compare two worlds by handle; components are matched by name, and only described bytes count, as for the
 * checksum; singletons count in neither.
 *  Shapes  out: capacity entries, may be NULL when capacity is 0; the first ones in order of index
 *  Returns the number of all differences: 0 for worlds of equal checksum */
uint32_t kd_world_diff(const kd_world *a, const kd_world *b, kd_difference *out, uint32_t capacity);
/** Say a difference in words: "entity 12.1 walker: transform.position differs". Returns `out`. */
const char *kd_difference_text(const kd_world *a, const kd_world *b, const kd_difference *d, char *out,
                               size_t out_size);

#endif
