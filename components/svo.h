#ifndef KD_COMPONENTS_SVO_H
#define KD_COMPONENTS_SVO_H

/* Singleton: the octree of this frame while it is being built. What the tracer reads of it is kd_tree (render_targets.h).
 *
 * Levels are counted by cells of a cascade: level L has 2^L cells along an edge. Level 6 is dense, levels 7 … leaf_level - 1
 * are sparse nodes, leaves are at leaf_level. Nodes of all cascades share one numbering a level: the rank of their mask bit. */

#include <stdbool.h>

#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/voxel.h"

#define KD_MAX_NODE_LEVELS 4 /* 6 … 9 */

typedef struct kd_svo {
    uint32_t cascades, leaf_level;
    uint32_t layer_words;                    /* mask words of one layer: all cascades */
    uint32_t mask_first[KD_MAX_NODE_LEVELS]; /* first word of level 6 + i in level_masks and level_ranks */
    uint32_t mask_words[KD_MAX_NODE_LEVELS];
    uint32_t node_capacity;                  /* nodes a level: stride of lists, nodes, data */
    uint32_t static_capacity, dynamic_capacity; /* cells of a layer: size of the buffers */
    uint32_t static_room, dynamic_room;      /* cells of a layer that are in use; ranks beyond have no cell */
    uint32_t list_capacity[2];               /* nodes a level when each list was written */
    bool failed;                             /* no memory for it: there is no indirect light */
    uint32_t current;                        /* which of the two lists is this frame's */

    kd_gpu_buffer uniform;                   /* "tree.uniform": kd_tree_params */
    kd_gpu_buffer masks, ranks;              /* "svo.masks": leaf cells, static layer then dynamic layer */
    kd_gpu_buffer level_masks, level_ranks;  /* "svo.levels": both layers joined */
    kd_gpu_buffer lists[2];                  /* node to code, this frame's and the last's */
    kd_gpu_buffer counters;                  /* KD_COUNT_*, KD_ARGS_* */
    kd_gpu_buffer sums;                      /* of the layer being added up */
    kd_gpu_buffer static_cells, dynamic_cells; /* "svo.cells" */
    kd_gpu_buffer index, nodes, leaves, data; /* "tree.nodes", "tree.leaves" */
    kd_gpu_buffer occupancy, was;            /* of dense levels, for the filter */
    kd_gpu_texture atlas;                    /* "tree.radiance" */
} kd_svo;
KD_COMPONENT_DECLARE(kd_svo);

static inline uint32_t kd_svo_leaf_parent_level(const kd_svo *svo)
{
    return svo->leaf_level - 1;
}

#endif
