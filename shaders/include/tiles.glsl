#ifndef KD_INCLUDE_TILES_GLSL
#define KD_INCLUDE_TILES_GLSL

/* The picture in squares of KD_TILE_EDGE pixels: a list of those that show surfaces and one of those that show none,
 * each the arguments of an indirect dispatch of a group a tile. Items come in any order. */

#include "shaders/shared/resolve.h"
#include "shaders/include/view.glsl"

#ifndef TILES_ACCESS
#define TILES_ACCESS readonly
#endif
layout(std430, binding = 0) TILES_ACCESS buffer tiles_block {
    uint tile_heads[KD_TILE_LISTS * KD_TILE_HEAD];
    uint tile_items[]; /* column, row << 16; for each list as many as there are tiles, KD_TILE_NONE beyond its end */
};

uvec2 tile_counts() { return (kd_view.size.xy + (KD_TILE_EDGE - 1u)) / KD_TILE_EDGE; }
uint tile_number(uvec2 at) { return at.y * tile_counts().x + at.x; }
uint tile_place(uint list, uint i) { return list * (uint(tile_items.length()) / KD_TILE_LISTS) + i; }
uint tile_pack(uvec2 at) { return at.x | at.y << 16; }
uvec2 tile_unpack(uint item) { return uvec2(item & 0xFFFFu, item >> 16); }

#endif
