#ifndef KD_SYSTEMS_SVO_REFERENCE_H
#define KD_SYSTEMS_SVO_REFERENCE_H

/* The order-free build in plain C, from voxels in the world: the same words as shaders/svo make when they
 * make a whole tree at once. Node numbers are then the ranks of the codes; in a tree that was kept they are
 * others. Tests compare the two; read beside the shaders it says what each buffer holds. */

#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/core/status.h"

/* Pages of one layer, as read back. */
typedef struct svo_reference_layer {
    const struct kd_voxel_segment *segments; /* [slots] */
    const uint32_t (
        *voxels)[KD_PAGE_WORDS]; /* [slots * KD_SEGMENT_VOXELS] page voxels of shaders/shared/voxel.h */
    uint32_t slots;
} svo_reference_layer;

typedef struct svo_reference_source {
    uint32_t cascades, leaf_level;
    int32_t origin[KD_MAX_CASCADES][3]; /* low corners in cells from the world's origin */
    svo_reference_layer layers[KD_LAYER_COUNT];
    const struct kd_voxel_object_params *objects;
    const uint32_t (*shape)[2]; /* the cache's words */
    const uint32_t *color;
} svo_reference_source;

/* Levels are counted from the dense one: level 0 has 64^3 cells a cascade. */
typedef struct svo_reference {
    uint32_t cascades, leaf_level, levels, layer_words;
    uint32_t *masks[KD_LAYER_COUNT], *ranks[KD_LAYER_COUNT]; /* [layer_words] */
    uint32_t cell_count[KD_LAYER_COUNT];
    uint32_t (*sums[KD_LAYER_COUNT])[KD_SUM_WORDS]; /* [cell_count] */
    uint32_t (*cells[KD_LAYER_COUNT])[4];           /* [cell_count] */
    uint32_t level_words[KD_MAX_NODE_LEVELS], node_count[KD_MAX_NODE_LEVELS];
    uint32_t *level_masks[KD_MAX_NODE_LEVELS], *level_ranks[KD_MAX_NODE_LEVELS]; /* [level_words] */
    uint32_t *lists[KD_MAX_NODE_LEVELS];                                         /* [node_count] */
    uint32_t (*nodes[KD_MAX_NODE_LEVELS])[8]; /* [node_count]; none at the level above the leaves */
    uint32_t *index;                          /* [cascades * 64^3] */
} svo_reference;

/** Build the octree of one frame. Errors KD_NO_MEMORY. Owns the arrays in `out`: svo_reference_free */
kd_status svo_reference_build(const svo_reference_source *source, svo_reference *out);
void svo_reference_free(svo_reference *tree);

/** Morton code as in shaders/include/morton.glsl, up to 10 bits an axis. */
uint32_t svo_morton(uint32_t x, uint32_t y, uint32_t z);
void svo_morton_cell(uint32_t code, uint32_t cell[3]);

/** Share of 256 and cell of corner i of a page voxel's block, as in shaders/include/splat.glsl. */
uint32_t svo_splat_weight(const uint32_t voxel[KD_PAGE_WORDS], uint32_t i);
void svo_splat_cell(const uint32_t voxel[KD_PAGE_WORDS], uint32_t i, int32_t cell[3]);

/** Morton code of the wrapped place of a cell of a cascade whose low corner stands at `origin`. */
uint32_t svo_wrapped_code(uint32_t leaf_level, const int32_t origin[3], const int32_t cell[3]);

/** Tell whether cascade c owns a cell: it is inside, and no finer cascade covers it. */
bool svo_owned(uint32_t resolution, uint32_t c, const int32_t cell[3]);

#endif
