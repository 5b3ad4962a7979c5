#ifndef KD_SYSTEMS_VOXEL_PAGES_STALE_H
#define KD_SYSTEMS_VOXEL_PAGES_STALE_H

#include "components/voxel_scene.h"

/* Parts of the static layer that are to be built anew: what cascades have uncovered or left to one another
 * by moving, and where members came, went or changed. Kept as boxes of whole dense cells, in cells of the
 * world's lattice, and as bits of these cells. */
typedef struct stale_parts {
    struct kd_stale_box *boxes; /* from the cascade's low corner */
    uint32_t count, capacity;
    uint32_t *bits;    /* of dense cells, by wrapped Morton code */
    uint32_t *patches; /* words of leaf parents with stale cells */
    uint32_t patch_count;
    bool all;
} stale_parts;

/** Begin a frame: nothing is stale but what the move of the cascades makes so. Errors KD_NO_MEMORY */
kd_status stale_begin(stale_parts *stale, const kd_voxel_scene *scene);

/** A static object comes to cascade c, or leaves it, for another reason than the move: its bounds are stale.
 */
void stale_add(stale_parts *stale, const kd_voxel_scene *scene, uint32_t c, kd_vec3 low, kd_vec3 high);

/** The layer in whose pages the object's voxels lie. */
kd_voxel_layer voxel_layer_of(const kd_voxel_scene *scene, const kd_voxel_object *object);

/** The object comes to cascade c or leaves it: if it is static, and not brought or left behind by the move of
 * the cascade alone, whose own doing is noted already, its place is stale. */
void stale_note(stale_parts *stale, const kd_voxel_scene *scene, const kd_voxel_object *object, uint32_t c,
                bool comes);

/** All of it is stale. */
void stale_add_all(stale_parts *stale, const kd_voxel_scene *scene);

/** Hand boxes and bits to the GPU; sets static_changed. Errors KD_GPU, KD_NO_MEMORY */
kd_status stale_upload(stale_parts *stale, kd_gpu *gpu, kd_voxel_scene *scene);

void stale_fini(stale_parts *stale);

#endif
