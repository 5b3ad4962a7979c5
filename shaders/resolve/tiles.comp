/* An invocation a tile: lists the tile by whether it shows anything, and with TILED marks the local lights whose
 * ranges meet what it shows. */

#define TILES_ACCESS
#define TILE_LIGHTS_ACCESS writeonly
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/lights.glsl"
#include "shaders/include/tiles.glsl"
#include "shaders/include/tile_lights.glsl"

layout(local_size_x = 32) in;

struct box {
    vec3 low, high; /* [m], world space */
};

/* Grows `b` to all surfaces in the tile. Returns false when there are none. */
bool tile_bounds(uvec2 tile, inout box b)
{
    ivec2 corner = ivec2(tile * KD_TILE_EDGE), last = ivec2(kd_view.size.xy) - 1;
    float nearest = 1.0;
    for (int y = 0; y < int(KD_TILE_EDGE); y++)
        for (int x = 0; x < int(KD_TILE_EDGE); x++) {
            ivec2 pixel = min(corner + ivec2(x, y), last);
            float depth = gbuffer_load_depth(pixel);
            nearest = min(nearest, depth);
#ifdef TILED
            vec3 p = gbuffer_position(pixel, depth);
            b.low = depth < 1.0 ? min(b.low, p) : b.low;
            b.high = depth < 1.0 ? max(b.high, p) : b.high;
#endif
        }
    return nearest < 1.0;
}

void tile_add(uint list, uvec2 tile)
{
    uint head = list * KD_TILE_HEAD, i = atomicAdd(tile_heads[head + 3u], 1u);
    if (i < KD_TILE_ROW)
        atomicAdd(tile_heads[head], 1u);
    if (i % KD_TILE_ROW == 0u)
        atomicAdd(tile_heads[head + 1u], 1u);
    tile_items[tile_place(list, i)] = tile_pack(tile);
}

#ifdef TILED
/* A little wider than it is: what shades the pixels may round their places otherwise. */
bool light_meets(uint i, box b)
{
    vec4 sphere = kd_lights.light[i].position_ws;
    vec3 away = max(max(b.low - sphere.xyz, sphere.xyz - b.high), vec3(0.0));
    float reach = sphere.w + 1e-5 * (sphere.w + max(largest(b.low), largest(b.high)));
    return !(sphere.w > 0.0) || !(dot(away, away) > reach * reach);
}

void tile_mark_lights(uint tile, box b)
{
    uint words = tile_light_words(), first = light_directional_count();
    for (uint w = 0u; w < words; w++) {
        uint bits = 0u, count = min(light_count() - first - 32u * w, 32u);
        for (uint k = 0u; k < count; k++)
            bits |= light_meets(first + 32u * w + k, b) ? 1u << k : 0u;
        tile_lights[tile * words + w] = bits;
    }
}
#endif

void main()
{
    uvec2 tiles = tile_counts();
    uint number = gl_GlobalInvocationID.x;
    if (number >= tiles.x * tiles.y)
        return;
    uvec2 tile = uvec2(number % tiles.x, number / tiles.x);
    box b = box(vec3(1e30), vec3(-1e30));
    bool hit = tile_bounds(tile, b);
    tile_add(hit ? KD_TILE_SURFACES : KD_TILE_EMPTY, tile);
#ifdef TILED
    tile_mark_lights(number, b);
#endif
}
