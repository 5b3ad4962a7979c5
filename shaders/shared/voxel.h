#ifndef KD_SHADERS_VOXEL_H
#define KD_SHADERS_VOXEL_H

#include "shaders/shared/layout.h"

/* The voxel scene as CPU and GPU see it.
 *
 * Words of a cached voxel (model space):
 *   position  10:10:10 cell inside its chunk, 2 bits spare
 *   normal    3 x snorm8 | unorm8 emission (share of the material's emissive colour)
 *   albedo    3 x unorm8 sqrt-encoded | bit 24 double sided | what glows: area of the surface in it, 7 bits, KD_AREA_ONE a face
 *   binding   deforming voxels only, 3 words. Skinned: joints u16x2, u16x2 | weights unorm8x4.
 *             Attached (morphing): triangle | barycentric y, z as unorm16x2 | 0
 * Words of a page voxel (world space; dynamic layer alone: static voxels are brought to the world when their cells are built):
 *   cell      10:10:10 low cell of the 2x2x2 block that it covers, from the cascade's low corner; bit 31 set: nothing here
 *   fraction  3 x unorm8 of that block's far cells | 0
 *   normal    3 x snorm8 | emission as in the cache, 0 where the object has none
 *   albedo    as in the cache
 */
#define KD_PAGE_WORDS 4u
#define KD_SEGMENT_VOXELS 1024u
#define KD_AREA_ONE 48.0      /* a surface of one cell's face */
#define KD_PAGE_SEGMENTS 64u
#define KD_PAGE_VOXELS 65536u
#define KD_BINDING_WORDS 3u
#define KD_GROUP_VOXELS 32u   /* of a segment; static voxels are culled by groups: short ones, since caches run along x */
#define KD_SEGMENT_GROUPS 32u
#define KD_GROUP_LANES 2u     /* invocations that do a group in turns, so that what its voxels share is read once for sixteen */
#define KD_GROUPS_AT_ONCE 32u  /* groups that a work group of 64 does */
#define KD_GROUP_ROW 1024u    /* work groups along x of a dispatch over a list of them */
#define KD_NO_VOXEL 0x80000000u
#define KD_EMPTY 0xFFFFFFFFu
#define KD_MARKED 0xFFFFFFFEu /* a child that is needed and has no number yet: while a tree is built level by level */

/* Shares of a voxel below this (of 256) leave no mark: they would double the cells for less than a thirtieth of the light. */
#define KD_SPLAT_MIN_WEIGHT 8u

/* Added to positions in cells before voxelizing: a plane on a cell border then belongs to one cell, not to both. */
#define KD_VOXELIZE_NUDGE 0.0009765625

/* Dense levels: every cascade has 64^3 cells in textures; cascades of higher resolution go on below in sparse nodes. */
#define KD_DENSE_LOG2 6
#define KD_DENSE 64
#define KD_MAX_CASCADES 4
#define KD_DENSE_MIPS 5 /* 32, 16, 8, 4, 2 below the outermost cascade's 64 */

/* Optical depth of a fully covered voxel along its own edge, which lets nothing through: what is left of a ray
 * after a depth d is (exp(-d) - exp(-2)) / (1 - exp(-2)). Small, so that the parts of a wall add up almost as
 * areas do, and full depth is reached where the wall is and not half a cell before. */
#define KD_FULL_DEPTH 2.0

/* Words of an attribute sum, fixed point, one sum per occupied cell of a layer:
 *   0 weight (255 a voxel that covers the cell), 1-3 albedo (linear, 8 bit x weight), 4-6 normal (snorm8 x weight, signed),
 *   7-9 emission (KD_EMISSION_ONE is the brightest of the scene, x weight / 255), 10 weight of double-sided voxels, 11 weight of emissive ones, 12 their area x weight,
 *   13-15 axis of the normal (turned so that its largest part is positive) x weight, signed */
#define KD_SUM_WORDS 16u
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

/* Work of the transform of the dynamic layer: arguments, counts and lists of groups of voxels by kind (words), and a record
 * of what a segment's voxels share (texels of four words): origin and span of the chunk; first voxel, count, cascade and whether it glows, first
 * binding; object, then the last three of its info. */
#define KD_MOVING_GROUP 64u    /* voxels a work group brings to the world */
#define KD_MOVING_GROUPS 16u   /* of a segment */
#define KD_MOVING_KINDS 3u
#define KD_MOVING_RECORD 3u
#define KD_MOVING_GLOWS 0x80000000u
#define KD_MOVING_ARGS(kind) (3u * (kind))
#define KD_MOVING_COUNT(kind) (9u + (kind))
#define KD_MOVING_HEAD 12u
#define KD_MOVING_LIST(kind, slots) (KD_MOVING_HEAD + (kind) * (slots) * KD_MOVING_GROUPS)

/* Part of a cascade whose static cells are built anew, in cells from the cascade's low corner. */
struct kd_stale_box {
    ivec4 low;           /* w: cascade */
    ivec4 high;          /* first cell beyond; w: 1 when voxels may lie there, 0 when it is only emptied */
};
KD_LAYOUT_CHECK(kd_stale_box, 32)

/* Places (first words) in the buffer of what is stale. A patch is 256 leaf cells, eight words of a mask, one word of their
 * parents; stale cells that are built anew are numbered by the patches on the list. */
struct kd_stale_places {
    KD_UINT bits;        /* of dense cells ("bricks"), by wrapped code */
    KD_UINT slots;       /* patch to its number on the list; only of patches with stale bricks */
    KD_UINT patches;     /* the list */
    KD_UINT groups;      /* list of the groups of voxels that may lie in stale bricks; its arguments and count are the first words */
};
KD_LAYOUT_CHECK(kd_stale_places, 16)
#define KD_STALE_COUNT 3   /* word: groups listed */
#define KD_STALE_ENTRIES 4 /* word: entries of chains of their voxels (svo/link_static.comp) */
#define KD_STALE_HEAD 5

struct kd_tree_params {
    uvec4 info;          /* x: cascades, y: resolution, z: log2 resolution, w: sparse levels below the dense one */
    /* ---- 16 */
    vec4 cascade[KD_MAX_CASCADES]; /* xyz: low corner ws, w: span m */
    /* ---- 80 */
    ivec4 origin[KD_MAX_CASCADES]; /* xyz: low corner in cells from the world's origin */
    /* ---- 144 */
    uvec4 node_offset;   /* x: level 6, y: 7 …: first word of the level's child words in the node table */
    uvec4 data_offset;   /* x: level 7, y: 8 …: first entry of the level's filtered data */
    uvec4 capacity;      /* x: leaf parents, y: those with dynamic cells, z: levels that cascades have given up for want of room, 4 bits each */
    /* ---- 192 */
    vec4 light;          /* x: radiance of KD_EMISSION_ONE, y: factor on radiance while it is stored, z: 1 / y, w: 1 when `light.leak` is strict */
    /* ---- 208 */
    vec4 centre;         /* xyz: common centre of the cascades ws, w: 1 / half the edge of the finest */
    vec4 atlas;          /* xyz: 1 / size of the atlas of dense levels, w: 1 / slices of its depths */
    /* ---- 240 */
};
KD_LAYOUT_CHECK(kd_tree_params, 240)

/* Places (first words) in the book, one buffer with all that is known of nodes besides their content. Levels are counted
 * from the dense one. Node numbers are kept from frame to frame: a stack of free numbers a level gives and takes them. */
struct kd_svo_places {
    uvec4 masks;         /* of the levels: first word in the buffers of level masks */
    uvec4 codes;         /* number to code (cascade above Morton code of the wrapped cell); KD_EMPTY: free */
    uvec4 free;          /* stacks of free numbers */
    uvec4 changed;       /* bits of what is to be filtered; x: dense cells by code, y …: nodes by number */
    uvec4 others;        /* x: bits of dense cells that hold something, y: bits, z: lists of cells that a finer cascade fills */
    uvec4 above;         /* x: bits of cells above the outermost cascade that hold something, y: list of those to be filtered, z: list of those of the level above these */
    uvec4 size;          /* x: leaf parents that there is room for, y: levels, z: words of a layer's mask, w: cascades */
    uvec4 room;          /* nodes of the levels that there is room for */
    uvec4 child;         /* of the levels: first word of their nodes' child words in the node table; of the last: of words that lead to leaves */
    uvec4 blocks;        /* x: words of static blocks by number of the leaf parent, y: lists of free blocks, one a size 1 … 8, z: room of each, w: slots of static leaves */
    /* ---- 160 */
    uvec4 news;          /* x: bits of dense cells in which leaves came or went, y: words of a mask of leaf parents */
    /* ---- 176 */
};
KD_LAYOUT_CHECK(kd_svo_places, 176)
/* A block's word, shaders/include/leaf_block.glsl. */
#define KD_BLOCK_FIRST 0xFFFFFFu
#define KD_BLOCK_WAITS 0xFFFFFFu /* in place of the first: its cells have no slots yet */
#define KD_BLOCK_BITS 24
#define KD_FREE_BLOCKS 4096u /* of each size that are kept on a list, a cascade */
#define KD_DENSE_WORDS 8192u      /* bits of the dense cells of a cascade */
#define KD_UP_CELLS 32768u        /* dense cells of a cascade that the next finer one fills */

/* The atlas of dense levels: x and y repeat, so blocks of cascades need no border there; along z each block of 64 slices, one
 * a direction and cascade, has its last slice before it and its first behind it. Levels above the outermost cascade follow.
 * Radiance has six such parts, one a direction; depth two, with rays towards +x +y +z and towards -x -y -z in three channels. */
#define KD_ATLAS_BLOCK 66
#define KD_ATLAS_SLICES(cascades, parts) ((cascades) * (parts) * KD_ATLAS_BLOCK + (parts) * (KD_DENSE / 2))

/* Counters of the build (words of the counter buffer). Up to KD_COUNT_TRANSIENT they go from frame to frame. */
#define KD_COUNT_STATIC 0       /* occupied cells of the static layer */
#define KD_COUNT_DYNAMIC 1
#define KD_COUNT_FRESH 2        /* cells that took a number, in builds in which they do */
#define KD_COUNT_DIFF 3         /* nodes that go or come on the level at hand */
#define KD_COUNT_NEED 4         /* + level: nodes that the masks ask for, counted when members changed; numbers asked for */
#define KD_COUNT_NODES 8        /* + 4 * level + cascade: nodes in use */
#define KD_COUNT_FREE 24        /* + level: free numbers */
#define KD_COUNT_HIGH 28        /* one more than the highest number that a leaf parent ever had */
#define KD_COUNT_AWAY 29        /* 1 when nodes stayed away for want of numbers */
#define KD_COUNT_TOP 30         /* slots of static leaves that have been taken, but for what lies on lists of free blocks */
#define KD_COUNT_LIT 31         /* kd_svo.runs when light last changed a leaf */
#define KD_COUNT_TRANSIENT 32
#define KD_COUNT_TOUCHED 32     /* leaf parents in which the static layer was built anew, or the dynamic one is or was */
#define KD_COUNT_CHANGED 33     /* + level: length of the list of what is to be filtered */
#define KD_COUNT_UP 37          /* + cascade 1 …: cells that the finer cascade fills; at the count of cascades: those above changed */
#define KD_COUNT_PARTS 42       /* mask words on the list */
#define KD_COUNT_ABOVE 43       /* cells of the first level above the outermost cascade that are to be filtered */
#define KD_COUNT_ABOVE_NEXT 44  /* of the level above these */
#define KD_COUNT_PARENTS 46     /* leaf parents with dynamic cells */
#define KD_COUNT_LEFT 45        /* 1 when voxels found a locked node and wait for the next pass */
#define KD_COUNT_TRANSIENT_END 48
/* Indirect arguments in the same buffer, three words each: groups of 64. */
#define KD_ARGS_ALL 64          /* over all leaf parents */
#define KD_ARGS_TOUCHED 67      /* over the leaves of the touched ones */
#define KD_ARGS_DYNAMIC 70      /* over the leaf parents with dynamic cells */
#define KD_ARGS_LIST 73         /* over the list at hand */
#define KD_COUNT_CELLS 76       /* + cascade: static cells */
#define KD_COUNT_BLOCKS 79      /* + size 1 … 8: free blocks, those that found no room on their list too */
#define KD_COUNT_WANTED 87      /* + size: blocks that are wanted in this frame */
#define KD_COUNT_GOT 95         /* + size: that were asked for */
#define KD_COUNT_CENSUS 104     /* + 4 * levels above the leaf parents + cascade: nodes that the masks ask for there (svo/census.comp) */
#define KD_COUNT_CENSUS_MOVING 120 /* the same of those in which something moves */
#define KD_COUNT_CENSUS_CELLS 136 /* + cascade: static cells that stay or come anew */
#define KD_COUNT_WORDS 140

#include "shaders/shared/layout_end.h"

#endif
