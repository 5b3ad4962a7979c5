#ifndef KD_INCLUDE_GBUFFER_GLSL
#define KD_INCLUDE_GBUFFER_GLSL

/* Reading the G-buffer; surface.glsl says how it is laid out. Resource "gbuffer", kd_gbuffer bound to
 * KD_UNIT_GBUFFER_*, kd_lighting.view to KD_BIND_VIEW. */

#include "shaders/include/view.glsl"
#include "shaders/include/surface.glsl"

layout(binding = KD_UNIT_GBUFFER_ALBEDO) uniform sampler2D gbuffer_albedo;
layout(binding = KD_UNIT_GBUFFER_NORMAL) uniform usampler2D gbuffer_normal;
layout(binding = KD_UNIT_GBUFFER_MATERIAL) uniform sampler2D gbuffer_material;
layout(binding = KD_UNIT_GBUFFER_EMISSIVE) uniform sampler2D gbuffer_emissive;
layout(binding = KD_UNIT_GBUFFER_DEPTH) uniform sampler2D gbuffer_depth;
#ifdef LAYERED
layout(binding = KD_UNIT_GBUFFER_LAYERS) uniform usampler2D gbuffer_layers;
#endif

/* 1 where nothing was drawn. */
float gbuffer_load_depth(ivec2 pixel) { return texelFetch(gbuffer_depth, pixel, 0).r; }

/* World position of the middle of a pixel. */
vec3 gbuffer_position(ivec2 pixel, float depth)
{
    return view_position((vec2(pixel) + 0.5) / vec2(kd_view.size.xy), depth);
}

surface gbuffer_load(ivec2 pixel)
{
    packed_surface o;
    o.albedo = texelFetch(gbuffer_albedo, pixel, 0);
    o.normal = texelFetch(gbuffer_normal, pixel, 0);
    o.material = texelFetch(gbuffer_material, pixel, 0);
    o.emissive = texelFetch(gbuffer_emissive, pixel, 0);
#ifdef LAYERED
    o.layers = texelFetch(gbuffer_layers, pixel, 0);
#endif
    surface s = surface_unpack(o);
    s.depth = gbuffer_load_depth(pixel);
    s.hit = s.depth < 1.0;
    s.position_ws = gbuffer_position(pixel, s.depth);
    return s;
}

#endif
