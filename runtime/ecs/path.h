#ifndef KD_ECS_PATH_H
#define KD_ECS_PATH_H

/* Entities by the names on the way to them: "ship/gun/barrel". A '/' or '\' that belongs to a name is written
 * with a '\' before it. Where siblings have the same name the first in the order of children is meant; among
 * roots, which have no order, the one that was named first. */

#include "runtime/ecs/world.h"

/** Write the path from the root to an entity, its own name last.
 *  Shapes   out: size bytes, always ended by a zero when size is not 0; NULL is allowed when it is
 *  Returns  the length of the whole path without the zero, also when it did not fit; 0, and an empty text,
 * when the entity is dead, or it or one above it has no name: no path leads there */
size_t kd_entity_path(const kd_world *w, kd_entity e, char *out, size_t size);

/** Find an entity by its path below `from`, or from the roots when that is KD_NO_ENTITY. Returns KD_NO_ENTITY
 * when there is none, for an empty path and for empty names ("a//b", "/a").
 *  Cost  a look-up of every name, and a walk over the children of each entity on the way */
kd_entity kd_find_path(const kd_world *w, kd_entity from, const char *path);

#endif
