#ifndef KD_SYSTEMS_VOXEL_PAGES_LIGHT_UNIT_H
#define KD_SYSTEMS_VOXEL_PAGES_LIGHT_UNIT_H

#include "components/scene_store.h"
#include "runtime/ecs/query.h"

/** The brightest emission of all that is drawn, wherever it is: what comes near then changes nothing.
 * W/(m² sr), the brightest channel. */
float brightest_emission(const kd_scene_store *store, const kd_draw_list *drawn);

/** Radiance that the tree stores as 1, a power of two: 1 in ordinary light, more under a sun in lux, so that
 * half floats hold what is lit. Point lights count at a quarter of a metre; what is nearer may saturate.
 * \param lights query of kd_light
 * \param skies query of (kd_sky, kd_world_transform), whose sun is a light too
 * \param emission brightest of all that glows */
float stored_unit(kd_world *w, kd_query *lights, kd_query *skies, float emission);

#endif
