#ifndef KD_SYSTEMS_VOXEL_PAGES_CACHES_H
#define KD_SYSTEMS_VOXEL_PAGES_CACHES_H

#include "components/voxel_scene.h"

/* Which caches there are, by what they were made of. */
typedef struct voxel_caches {
    uint32_t *heads;     /* cache plus one, chained through kd_voxel_cache.next */
    uint32_t head_count; /* a power of two */
    uint32_t capacity;   /* of kd_voxel_scene.caches */
    uint32_t free_head;  /* free entries, chained likewise */
    uint32_t live;
    uint32_t run; /* of system voxel_objects */
} voxel_caches;

/** Choose or ask for the cache of an object in cascade c, and note that it is wanted in this run. Errors
 * KD_NO_MEMORY */
kd_status caches_want(voxel_caches *table, kd_voxel_scene *scene, kd_voxel_object *object, uint32_t c);

/** The same for an object that will come to the cascade in so many frames, if the camera goes on as it does.
 */
kd_status caches_want_ahead(voxel_caches *table, kd_voxel_scene *scene, const kd_voxel_object *object,
                            uint32_t c, uint32_t frames);

/** End a run: give back caches that nothing has wanted for KEEP_RUNS runs, and those that are not wanted any
 * more before they were made. */
void caches_end_run(voxel_caches *table, kd_voxel_scene *scene);

void caches_fini(voxel_caches *table, kd_voxel_scene *scene);

/* Tiles are equal when they are the same box, or both the whole primitive. */
bool caches_same_tile(kd_voxel_tile a, kd_voxel_tile b);
uint32_t caches_tile_hash(kd_voxel_tile tile);

#endif
