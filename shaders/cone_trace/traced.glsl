// What the passes after the tracer share: traced pixels beside each other, and how far they belong together.

#include "shaders/shared/gather.h"
#include "shaders/include/gbuffer.glsl"

layout(std140, binding = KD_BIND_PASS) uniform gather_block { kd_gather_params gather; };
layout(binding = KD_UNIT_GI_DIFFUSE) uniform sampler2D diffuse_in;
layout(binding = KD_UNIT_GI_SPECULAR) uniform sampler2D specular_in;
layout(binding = 0, rgba16f) writeonly uniform image2D diffuse_out;
layout(binding = 1, rgba16f) writeonly uniform image2D specular_out;

struct place {
    vec3 position_ws;
    vec3 normal_ws;
    vec3 face_ws;
    float nearness; // 1 / distance to the camera
};

place place_load(ivec2 pixel, float depth)
{
    uvec4 normals = texelFetch(gbuffer_normal, pixel, 0);
    place p = place(gbuffer_position(pixel, depth), octahedral_decode(normals.xy), octahedral_decode(normals.zw), 1.0);
    p.nearness = 1.0 / max(length(p.position_ws - kd_view.position_ws.xyz), 1e-4);
    return p;
}

// Weight of another pixel's light here: it must lie on the same plane and face the same way. A trace of weight is left to
// everything near, for pixels that have no better neighbour.
float belonging(place p, ivec2 other, float other_depth)
{
    vec3 normal = octahedral_decode(texelFetch(gbuffer_normal, other, 0).xy);
    float off_plane = abs(dot(gbuffer_position(other, other_depth) - p.position_ws, p.face_ws)) * p.nearness;
    return exp(-off_plane * 200.0) * pow(max(dot(p.normal_ws, normal), 0.0), 8.0) + 1e-5 * exp(-off_plane * 20.0);
}

void store(ivec2 at, vec4 diffuse, vec4 specular, float sum)
{
    float inverse = sum > 0.0 ? 1.0 / sum : 0.0;
    imageStore(diffuse_out, at, sum > 0.0 ? diffuse * inverse : vec4(0.0, 0.0, 0.0, 1.0));
    imageStore(specular_out, at, specular * inverse);
}
