#ifndef KD_ECS_VALIDATE_H
#define KD_ECS_VALIDATE_H

/* A world that checks itself: for tests, and for programs that suspect a stray write. */

#include "runtime/ecs/world.h"

/** Check that all parts of the world agree: handles and rows, archetypes and tables, parents and children,
 * names, sparse values and enable bits, pairs, the tables that queries match, change versions. Errors
 * BAD_FORMAT, with a message that names the first part that disagrees Cost       a visit to every entity,
 * several times over: not for every frame Threading  the owner of the world, outside of jobs */
kd_status kd_world_validate(const kd_world *w);

#endif
