#ifndef KD_SHADERS_VOXEL_H
#define KD_SHADERS_VOXEL_H

#include "shaders/shared/layout.h"

/* The voxel scene as CPU and GPU see it.
 *
 * Words of a cached voxel (model space):
 *   position  10:10:10 cell inside its chunk, 2 bits spare
 *   normal    3 x snorm8 | unorm8 emission (share of the material's emissive colour)
 *   albedo    3 x unorm8 sqrt-encoded | bit 24 double sided
 *   binding   deforming voxels only, 3 words. Skinned: joints u16x2, u16x2 | weights unorm8x4.
 *             Attached (morphing): triangle | barycentric y, z as unorm16x2 | 0
 * Words of a page voxel (world space):
 *   cell      10:10:10 low cell of the 2x2x2 block that it covers, bit 31 set: nothing here
 *   fraction  3 x unorm8 of that block's far cells | 0
 *   normal    3 x snorm8 | 0
 */
#define KD_SEGMENT_VOXELS 1024u
#define KD_PAGE_SEGMENTS 64u
#define KD_PAGE_VOXELS 65536u
#define KD_BINDING_WORDS 3u
#define KD_NO_VOXEL 0x80000000u
#define KD_EMPTY 0xFFFFFFFFu

/* Added to positions in cells before voxelizing: a plane on a cell border then belongs to one cell, not to both. */
#define KD_VOXELIZE_NUDGE 0.0009765625

/* Dense levels: every cascade has 64^3 cells in textures; cascades of higher resolution go on below in sparse nodes. */
#define KD_DENSE_LOG2 6
#define KD_DENSE 64
#define KD_MAX_CASCADES 4
#define KD_DENSE_MIPS 5 /* 32, 16, 8, 4, 2 below the outermost cascade's 64 */

/* Optical depth of a fully covered voxel along its own edge: exp(-6) = 0.25 % gets through. */
#define KD_FULL_DEPTH 6.0

/* Words of an attribute sum, fixed point, one sum per occupied cell of a layer:
 *   0 weight (255 a voxel that covers the cell), 1-3 albedo (linear, 8 bit x weight), 4-6 normal (snorm8 x weight, signed),
 *   7-9 emission (KD_EMISSION_ONE is the brightest of the scene, x weight / 255), 10 weight of double-sided voxels, 11 weight of emissive ones */
#define KD_SUM_WORDS 12u
#define KD_EMISSION_ONE 4095.0

/* One primitive of one entity in the voxel scene. */
struct kd_voxel_object_params {
    vec4 model_ws[3];    /* rows */
    vec4 normal_ws[3];   /* rows of the inverse transpose */
    /* ---- 96 */
    uvec4 info;          /* x: KD_VOXEL_*, y: first joint matrix, z: first index, w: base vertex (deformed) */
    /* ---- 112 */
    vec4 emission;       /* rgb: radiance relative to the scene's brightest, 0 … 1 */
    /* ---- 128 */
};
KD_LAYOUT_CHECK(kd_voxel_object_params, 128)
#define KD_VOXEL_RIGID 0u
#define KD_VOXEL_SKINNED 1u
#define KD_VOXEL_ATTACHED 2u

/* Part of a primitive's voxels at one span: at most 1024 cells an axis, so that a cell fits 10:10:10. */
struct kd_voxel_chunk_params {
    vec4 origin;         /* xyz: model-space low corner, w: span in model space */
    uvec4 info;          /* x: first voxel, y: voxels, z: first binding (in voxels) or KD_EMPTY, w: 0 */
};
KD_LAYOUT_CHECK(kd_voxel_chunk_params, 32)

/* A segment: at most 1024 consecutive voxels of one chunk of one object, for one cascade. */
struct kd_voxel_segment {
    KD_UINT object;
    KD_UINT first;       /* in the cache */
    KD_UINT count;       /* 0: the slot is free */
    KD_UINT chunk_cascade; /* chunk | cascade << 28 */
};

struct kd_tree_params {
    uvec4 info;          /* x: cascades, y: resolution, z: log2 resolution, w: sparse levels below the dense one */
    /* ---- 16 */
    vec4 cascade[KD_MAX_CASCADES]; /* xyz: low corner ws, w: span m */
    /* ---- 80 */
    uvec4 node_offset;   /* x: level 6, y: 7 …: first word of the level's child words in the node table */
    uvec4 data_offset;   /* x: level 7, y: 8 …: first entry of the level's filtered data */
    uvec4 capacity;      /* x: leaf parents, y: interior nodes a level, z: dynamic sums, w: static leaves */
    /* ---- 128 */
    vec4 light;          /* x: radiance of KD_EMISSION_ONE, y: factor on radiance while it is stored, z: 1 / y */
    /* ---- 144 */
    vec4 centre;         /* xyz: common centre of the cascades ws, w: 1 / half the edge of the finest */
    vec4 atlas;          /* xyz: 1 / size of the atlas of dense levels */
    /* ---- 176 */
};
KD_LAYOUT_CHECK(kd_tree_params, 176)

/* Counters of the build (words of the counter buffer). */
#define KD_COUNT_STATIC 0       /* occupied cells of the static layer */
#define KD_COUNT_DYNAMIC 1
#define KD_COUNT_LEVEL 2        /* + level - 6: occupied nodes of that level (6 … 9), all cascades */
#define KD_COUNT_WORDS 64
/* Indirect arguments in the same buffer, three words each. */
#define KD_ARGS_LEVEL 16        /* + 3 * (level - 6): groups of 64 over the nodes of a level */
#define KD_ARGS_LEAVES 28       /* groups of 64 over the leaf slots */
#define KD_ARGS_STATIC 31       /* groups of 64 over the static cells */
#define KD_ARGS_DYNAMIC 34
#define KD_ARGS_PREVIOUS 37     /* groups of 64 over the dense nodes of the frame before, and their count */
#define KD_COUNT_PREVIOUS 40
#define KD_COUNT_BEFORE 41      /* + 4 * (level - 6) + cascade: nodes of that level in finer cascades */

#include "shaders/shared/layout_end.h"

#endif
