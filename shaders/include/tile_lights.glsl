#ifndef KD_INCLUDE_TILE_LIGHTS_GLSL
#define KD_INCLUDE_TILE_LIGHTS_GLSL

/* Walking over the local lights of a place, in their order: with TILED those that reach the tile `tile_here`, else
 * all. Loops end in `while (light_next(walk, i))`: drivers that run a vector of pixels go once more through a body
 * that is left in its middle. TILE_MARKS: for the pass that marks the lights of tiles and walks nowhere.
 *
 * The includer has lights.glsl's. */

#include "shaders/shared/resolve.h"

#ifdef TILED
#ifdef TILE_MARKS
#define TILE_LIGHTS_ACCESS writeonly
#else
#define TILE_LIGHTS_ACCESS readonly
#endif
layout(std430, binding = 0) TILE_LIGHTS_ACCESS buffer tile_lights_block {
    uint tile_lights[]; /* a bit a local light, tile_light_words() words a tile */
};

uvec2 tile_counts() { return (kd_view.size.xy + (KD_TILE_EDGE - 1u)) / KD_TILE_EDGE; }
uint tile_light_words() { return (light_count() - light_directional_count() + 31u) / 32u; }
#endif

#ifndef TILE_MARKS
struct light_walk {
    uint word, bits; /* not TILED: bits is the next light */
};

#ifdef TILED
uint tile_here;

bool light_next(inout light_walk walk, out uint i)
{
    uint words = tile_light_words();
    while (walk.bits == 0u && walk.word < words)
        walk.bits = tile_lights[tile_here * words + walk.word++];
    bool there = walk.bits != 0u;
    i = light_directional_count() + 32u * (max(walk.word, 1u) - 1u) + uint(max(findLSB(walk.bits), 0));
    walk.bits &= walk.bits - 1u;
    return there;
}
#else
bool light_next(inout light_walk walk, out uint i)
{
    i = walk.bits++;
    return i < light_count();
}
#endif

bool light_first(out light_walk walk, out uint i)
{
#ifdef TILED
    walk = light_walk(0u, 0u);
#else
    walk = light_walk(0u, light_directional_count());
#endif
    return light_next(walk, i);
}
#endif

#endif
