#ifndef KD_ECS_INSTANCE_H
#define KD_ECS_INSTANCE_H

/* Copies of subtrees, and many deaths at once. */

#include "runtime/ecs/query.h"

/** Make n copies of `prototype` and everything below it, as last children of `parent` (KD_NO_ENTITY: as
 * roots): components, enable bits, names and the order of siblings. A KD_ENTITY field that points into the
 * prototype's subtree, and a pair with such a target, points to the same place in the copy; others stay. The
 * prototype may be any living entity. Shapes  roots: n handles, or NULL Errors  NOT_FOUND for a dead
 * prototype or parent; UNSUPPORTED, with a message, for a component that owns something (on_remove): its
 * bytes cannot be copied; OUT_OF_RANGE when it would lie too deep; NO_MEMORY. No copy is left then Cost    a
 * bulk write a node of the prototype, not a spawn an entity */
kd_status kd_instantiate(kd_world *w, kd_entity prototype, kd_entity parent, uint32_t n, kd_entity *roots);
/** Make one copy beside the entity, as the last child of the same parent. Returns KD_NO_ENTITY for the errors
 * of kd_instantiate. */
kd_entity kd_clone(kd_world *w, kd_entity e);

/** Destroy many, in this order, with their children; dead handles are passed over. Observers are told once
 * all are gone. */
void kd_destroy_n(kd_world *w, const kd_entity *entities, uint32_t n);
/** Destroy all entities that match, with their children: table by table, without looking up a handle where
 * nothing hangs on the rows. Errors NO_MEMORY, nothing is destroyed: only for queries of sparse components or
 * of components with enable bits, which need a list */
kd_status kd_destroy_query(kd_query *q);

#endif
