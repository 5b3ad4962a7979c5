#ifndef KD_INCLUDE_MATERIAL_GLSL
#define KD_INCLUDE_MATERIAL_GLSL

/* The material of the batch being drawn, read at two texture coordinate sets. MATERIAL_MAPS, the KD_MAP_*
 * bits that are there, is known when compiling: software drivers run both sides of a branch, so a map that
 * is only switched off would be sampled all the same. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"

#ifndef MATERIAL_MAPS
#define MATERIAL_MAPS 0
#endif

layout(std140, binding = KD_BIND_MATERIAL) uniform kd_material_block { kd_material_params kd_material; };
layout(binding = KD_UNIT_BASE_COLOR) uniform sampler2D material_base_color_map;
layout(binding = KD_UNIT_METALLIC_ROUGHNESS) uniform sampler2D material_surface_map;
layout(binding = KD_UNIT_NORMAL) uniform sampler2D material_normal_map;
layout(binding = KD_UNIT_EMISSIVE) uniform sampler2D material_emissive_map;
layout(binding = KD_UNIT_OCCLUSION) uniform sampler2D material_occlusion_map;

/* Coordinates of map `index` (its bit's number): uv0 in xy, uv1 in zw. */
vec2 material_uv(uint index, vec4 uv)
{
    vec3 p = vec3((kd_material.maps.y >> index & 1u) != 0u ? uv.zw : uv.xy, 1.0);
    return vec2(dot(kd_material.uv_transform[index * 2u].xyz, p),
                dot(kd_material.uv_transform[index * 2u + 1u].xyz, p));
}

/* Where drivers filter no maps along long footprints (KD_TAPS): taps along the longer axis, each as wide as the shorter one. */
vec4 material_filtered(sampler2D map, vec2 uv)
{
#ifdef KD_TAPS
    vec2 size = vec2(textureSize(map, 0)), x = dFdx(uv), y = dFdy(uv);
    float x_texels = length(x * size), y_texels = length(y * size);
    bool along_x = x_texels > y_texels;
    vec2 along = along_x ? x : y, across = along_x ? y : x;
    float ratio = max(x_texels, y_texels) / max(min(x_texels, y_texels), 1e-6);
    int taps = x_texels + y_texels > 1.0 ? int(clamp(ceil(ratio), 1.0, float(KD_TAPS))) : 1;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < taps; i++)
        sum += textureGrad(map, uv + along * ((float(i) + 0.5) / float(taps) - 0.5), along / float(taps), across);
    return sum / float(taps);
#else
    return texture(map, uv);
#endif
}

/* Linear colour and opacity, vertex colour included. */
vec4 material_base_color(vec4 uv, vec4 vertex_color)
{
    vec4 c = kd_material.base_color * vertex_color;
#if (MATERIAL_MAPS & 1)
    c *= material_filtered(material_base_color_map, material_uv(0u, uv));
#endif
    return c;
}

/* x: metallic, y: roughness. */
vec2 material_surface(vec4 uv)
{
    vec2 s = kd_material.surface.xy;
#if (MATERIAL_MAPS & 2)
    s *= texture(material_surface_map, material_uv(1u, uv)).bg;
#endif
    return s;
}

/* In tangent space, not normalised. */
vec3 material_normal(vec4 uv)
{
#if (MATERIAL_MAPS & 4)
    vec3 n = texture(material_normal_map, material_uv(2u, uv)).xyz * (255.0 / 127.0) - 128.0 / 127.0;
    return vec3(n.xy * kd_material.surface.z, n.z);
#else
    return vec3(0.0, 0.0, 1.0);
#endif
}

vec3 material_emissive(vec4 uv)
{
    vec3 e = kd_material.emissive.rgb;
#if (MATERIAL_MAPS & 8)
    e *= texture(material_emissive_map, material_uv(3u, uv)).rgb;
#endif
    return e;
}

float material_occlusion(vec4 uv)
{
#if (MATERIAL_MAPS & 16)
    return texture(material_occlusion_map, material_uv(4u, uv)).r;
#else
    return 1.0;
#endif
}

#endif
