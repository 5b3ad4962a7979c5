/* An invocation a tile: marks the local lights whose ranges meet what it shows. */

#define TILED
#define TILE_MARKS
#include "shaders/include/gbuffer.glsl"
#include "shaders/include/lights.glsl"
#include "shaders/include/tile_lights.glsl"

layout(local_size_x = 32) in;

struct box {
    vec3 low, high; /* [m], world space */
};

/* Of all surfaces in the tile; low above high: there are none. */
box tile_bounds(uvec2 tile)
{
    box b = box(vec3(1e30), vec3(-1e30));
    ivec2 corner = ivec2(tile * KD_TILE_EDGE), last = ivec2(kd_view.size.xy) - 1;
    for (int y = 0; y < int(KD_TILE_EDGE); y++)
        for (int x = 0; x < int(KD_TILE_EDGE); x++) {
            ivec2 pixel = min(corner + ivec2(x, y), last);
            float depth = gbuffer_load_depth(pixel);
            vec3 p = gbuffer_position(pixel, depth);
            b.low = depth < 1.0 ? min(b.low, p) : b.low;
            b.high = depth < 1.0 ? max(b.high, p) : b.high;
        }
    return b;
}

/* A little wider than it is: what shades the pixels may round their places otherwise. */
bool light_meets(uint i, box b)
{
    vec4 sphere = kd_lights.light[i].position_ws;
    vec3 away = max(max(b.low - sphere.xyz, sphere.xyz - b.high), vec3(0.0));
    float reach = sphere.w + 1e-5 * (sphere.w + max(largest(b.low), largest(b.high)));
    return b.low.x <= b.high.x && (!(sphere.w > 0.0) || !(dot(away, away) > reach * reach));
}

void main()
{
    uvec2 tiles = tile_counts();
    uint tile = gl_GlobalInvocationID.x;
    if (tile >= tiles.x * tiles.y)
        return;
    box b = tile_bounds(uvec2(tile % tiles.x, tile / tiles.x));
    uint words = tile_light_words(), first = light_directional_count();
    for (uint w = 0u; w < words; w++) {
        uint bits = 0u, count = min(light_count() - first - 32u * w, 32u);
        for (uint k = 0u; k < count; k++)
            bits |= light_meets(first + 32u * w + k, b) ? 1u << k : 0u;
        tile_lights[tile * words + w] = bits;
    }
}
