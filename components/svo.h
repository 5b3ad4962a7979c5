#ifndef KD_COMPONENTS_SVO_H
#define KD_COMPONENTS_SVO_H

/* Singleton: the octree of this frame while it is being built. What the tracer reads of it is kd_tree
 * (render_targets.h).
 *
 * Levels are counted by cells of a cascade: level L has 2^L cells along an edge. Level 6 is dense, levels 7 …
 * leaf_level - 1 are sparse nodes, leaves are at leaf_level. Nodes of all cascades share one numbering a
 * level. A node keeps its number as long as it is occupied, so what is known of it can stay where it is; in a
 * tree made at once numbers follow the codes.
 *
 * Cells are kept under wrapped places: the world's cell number modulo the resolution
 * (shaders/include/tree_params.glsl).
 *
 * Changes: in the book, from places.news.x on, stands a bit a dense cell: leaves in it came or went in this
 * frame, or those of one layer did behind those of the other. The bit is the cascade's first one plus the
 * Morton code of the wrapped place; shaders bind kd_svo_bind_changes() and ask cells_changed_around() of
 * shaders/include/changes.glsl, after naming {"svo.changes", KD_USE_STORAGE_READ}. Where a cascade has moved,
 * a place stands for another cell of the world than before. With one layer, where nothing is known of the
 * frame before, who asks sets wants_changes once; occupancies are compared by sums then. */

#include <stdbool.h>

#include "runtime/ecs/world.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/voxel.h"

#define KD_MAX_NODE_LEVELS 4 /* 6 … 9 */

typedef struct kd_svo {
    uint32_t cascades, leaf_level;
    uint32_t layer_words;                    /* mask words of one layer: all cascades */
    uint32_t mask_first[KD_MAX_NODE_LEVELS]; /* first word of level 6 + i in level_masks */
    uint32_t mask_words[KD_MAX_NODE_LEVELS];
    uint32_t node_room[KD_MAX_NODE_LEVELS]; /* nodes of level 6 + i that there is room for */
    uint32_t node_capacity;                 /* of the leaf parents */
    uint32_t leaf_room;                     /* slots of static leaves; those of what moves lie behind them */
    uint32_t sum_capacity;                  /* cells */
    uint32_t dynamic_capacity;              /* leaf parents with dynamic cells */
    uint32_t dynamic_room;                  /* of these in use; ranks beyond have no cells */
    uint32_t fresh_words;                   /* room in `fresh` */
    uint32_t entry_room;                    /* in the chains of static voxels */
    bool strict;                            /* `light.leak=strict` when it was made */
    uint64_t most_bytes;                    /* of any one buffer that grows */
    bool failed;                            /* no memory for it: there is no indirect light */
    uint32_t given_up;                      /* levels of the cascades for want of room, 4 bits each */
    bool again;                             /* that has changed in this frame: the tree is made once more */
    struct kd_svo_places places;            /* in the book */
    uint32_t runs;                          /* frames with this tree, from 1 */
    uint32_t changed_run;                   /* the last of them in which anything of it was built */
    uint32_t lit_run, lit_known; /* the last one before lit_known in which light has changed a leaf */

    bool wants_changes; /* set by whoever reads what changed */
    kd_gpu_buffer told; /* "svo.changes": with one layer, a sum of each dense cell's leaves, now and before */
    kd_gpu_buffer uniform; /* "tree.uniform": kd_tree_params */
    bool asleep;           /* nothing has changed for long: of masks there is that of dense cells alone */
    kd_gpu_buffer masks;   /* "svo.masks": leaf parents with static cells */
    kd_gpu_buffer moving;  /* "svo.masks": leaf parents of the dynamic layer, mask and ranks */
    bool glows;            /* there is room for static cells' emission: something glows */
    bool has_moving;       /* there is room for them: something moves, or did lately */
    kd_gpu_buffer heads, next, groups; /* "svo.chains": of the voxels that cover a leaf parent's cells */
    kd_gpu_buffer fresh;               /* static cells that are built anew: mask */
    kd_gpu_buffer fresh_heads; /* of the chains of static voxels that cover cells of their leaf parents */
    kd_gpu_buffer entries, entry_glows; /* of these chains; objects of entries, where anything glows */
    kd_gpu_buffer level_masks;          /* "svo.levels": nodes of all levels, of both layers joined */
    kd_gpu_buffer diff;                 /* of all levels, a bit a mask word that is not what it was */
    kd_gpu_buffer before;   /* while something changes: level_masks as they were in the frame before */
    kd_gpu_buffer work;     /* lists of the pass at hand: mask words, leaf parents, what is to be filtered */
    kd_gpu_buffer moved;    /* leaf parents with dynamic cells in the frame before */
    kd_gpu_buffer book;     /* "svo.book": kd_svo_places */
    kd_gpu_buffer counters; /* KD_COUNT_*, KD_ARGS_* */
    kd_gpu_buffer sums;     /* of the layer being added up */
    kd_gpu_buffer static_albedo, static_emission; /* "svo.cells": of static cells, beside their leaves */
    kd_gpu_buffer taken;         /* numbers of cells while nodes take theirs, eight a leaf parent */
    kd_gpu_buffer dynamic_cells; /* eight a leaf parent, in the order of the parents' mask bits; behind those
                                    of dynamic_room parents a word for each: which of the eight there are */
    kd_gpu_buffer moved_cells;   /* these words as they were in the frame before */
    uint32_t moved_room;         /* of these */
    kd_gpu_buffer index, nodes, leaves, data; /* "tree.nodes", "tree.leaves", "tree.data" */
    kd_gpu_texture atlas, depths; /* "tree.radiance": words of the dense levels, shaders/include/atlas.glsl */
    kd_gpu_texture atlas_view, depths_view; /* the same as they are sampled */
} kd_svo;
KD_COMPONENT_DECLARE(kd_svo);

/* Nodes that there is room for on the levels from `first` on, above level `end`, both counted from the dense
 * one: an entry's place in tables of all levels. */
static inline uint32_t kd_svo_nodes_before(const kd_svo *svo, uint32_t first, uint32_t end)
{
    uint32_t nodes = 0;
    for (uint32_t l = first; l < end; l++)
        nodes += svo->node_room[l];
    return nodes;
}

/* First entry of the filtered data of level l >= 1, counted from the dense one; dense cells have theirs in
 * textures. */
static inline uint32_t kd_svo_data_first(const kd_svo *svo, uint32_t l)
{
    return kd_svo_nodes_before(svo, 1, l);
}

/* Levels that cascade c has given up. */
static inline uint32_t kd_svo_given_up(uint32_t given_up, uint32_t c)
{
    return given_up >> (4 * c) & 15;
}

/* Words of a mask of leaf parents. */
static inline uint32_t kd_svo_parent_words(const kd_svo *svo)
{
    return svo->layer_words / 8;
}

/* Leaf parents in which something moves that there is room for; 0 when nothing does. */
static inline uint32_t kd_svo_moving_room(const kd_svo *svo)
{
    return svo->has_moving ? svo->dynamic_room : 0;
}

/* Have blocks slots for all eight leaves of a parent? */
static inline bool kd_svo_wide_blocks(const kd_svo *svo)
{
    return svo->leaf_level - KD_DENSE_LOG2 == 1;
}

/* Slot of leaf k of a block (shaders/include/leaf_block.glsl); KD_EMPTY: there is none. */
static inline uint32_t kd_svo_block_slot(const kd_svo *svo, uint32_t block, uint32_t k)
{
    uint32_t cells = block >> KD_BLOCK_BITS, slot = block & KD_BLOCK_FIRST;
    for (uint32_t i = 0; i < k; i++)
        slot += kd_svo_wide_blocks(svo) ? 1 : cells >> i & 1u;
    return cells >> k & 1u ? slot : KD_EMPTY;
}

/* Where the words in dynamic_cells begin that tell which of a parent's eight there are: bytes. */
static inline size_t kd_svo_moving_words(const kd_svo *svo)
{
    return (size_t)svo->dynamic_room * 8 * 16;
}

/** Bind the bits of dense cells in which leaves came or went. */
static inline void kd_svo_bind_changes(kd_gpu *gpu, const kd_svo *svo, uint32_t binding)
{
    kd_gpu_bind_storage_range(gpu, binding, svo->book, (size_t)svo->places.news.x * 4,
                              (size_t)svo->cascades * KD_DENSE_WORDS * 4);
}

static inline uint32_t kd_svo_leaf_parent_level(const kd_svo *svo)
{
    return svo->leaf_level - 1;
}

#endif
