// What the passes after the tracer share: traced pixels beside each other, and how far they belong together.

#include "shaders/shared/gather.h"
#include "shaders/include/gbuffer.glsl"

layout(std140, binding = KD_BIND_PASS) uniform gather_block { kd_gather_params gather; };
layout(binding = KD_UNIT_GI_DIFFUSE) uniform sampler2D diffuse_in;
layout(binding = KD_UNIT_GI_SPECULAR) uniform sampler2D specular_in;
layout(binding = KD_UNIT_GI_GUIDE) uniform sampler2D guide_in; // guide.comp
layout(binding = 0, rgba16f) writeonly uniform image2D diffuse_out;
layout(binding = 1, rgba16f) writeonly uniform image2D specular_out;

// A visible point with its tangent plane, prepared so that the distance of another pixel's point from the plane costs a few
// operations: points of a pixel at viewing depth z are affine in the pixel and in z.
struct place {
    vec3 normal_ws;
    vec3 slope;       // times (ndc, 1): plane distance that grows with z (perspective) or stands alone (orthographic)
    vec2 line;        // plane distance: line.x + line.y z besides
    float nearness;   // 1 / distance to the camera
};

vec3 ndc_of(ivec2 pixel) { return vec3((vec2(pixel) + 0.5) / vec2(kd_view.size.xy) * 2.0 - 1.0, 1.0); }

place place_load(ivec2 pixel, float depth)
{
    uvec4 normals = texelFetch(gbuffer_normal, pixel, 0);
    vec3 face = octahedral_decode(normals.zw), eye = kd_view.position_ws.xyz, forward = kd_view.forward_ws.xyz;
    mat4 m = kd_view.inverse_view_projection;
    vec4 middle = m[2] + m[3];
    place p;
    p.normal_ws = octahedral_decode(normals.xy);
    float z = view_depth(depth);
    if (view_is_orthographic()) {
        p.slope = vec3(dot(face, m[0].xyz), dot(face, m[1].xyz), dot(face, middle.xyz)) / middle.w;
        float far = dot(middle.xyz / middle.w - eye, forward);
        p.line = vec2(-dot(face, forward) * far, dot(face, forward));
        p.line.x -= dot(p.slope, ndc_of(pixel)) + p.line.x + p.line.y * z;
        p.nearness = 1.0 / max(abs(z), 1e-4);
        return p;
    }
    vec3 x = m[0].xyz - eye * m[0].w, y = m[1].xyz - eye * m[1].w, ray = middle.xyz - eye * middle.w;
    p.slope = vec3(dot(face, x), dot(face, y), dot(face, ray)) / dot(ray, forward);
    p.line = vec2(-dot(p.slope, ndc_of(pixel)) * z, 0.0);
    vec3 seen = ray + x * ndc_of(pixel).x + y * ndc_of(pixel).y;
    p.nearness = 1.0 / max(length(seen) / dot(ray, forward) * z, 1e-4);
    return p;
}

float place_distance(place p, ivec2 other, float z)
{
    float s = dot(p.slope, ndc_of(other));
    return (view_is_orthographic() ? s : s * z) + p.line.x + p.line.y * z;
}

// Weight of another traced pixel's light here, given its guide: it must lie on the same plane and face the same way. A trace
// of weight is left to everything near, for pixels that have no better neighbour.
float belonging(place p, ivec2 other, vec4 guide)
{
    float off_plane = place_distance(p, other, guide.w) * p.nearness * 100.0;
    float near = 1.0 / (1.0 + off_plane * off_plane), facing = max(dot(p.normal_ws, guide.xyz), 0.0);
    facing *= facing;
    facing *= facing;
    return near * (near * facing * facing + 1e-5);
}

bool guide_is_background(vec4 guide) { return guide.w <= 0.0; }

void store(ivec2 at, vec4 diffuse, vec4 specular, float sum)
{
    float inverse = sum > 0.0 ? 1.0 / sum : 0.0;
    imageStore(diffuse_out, at, sum > 0.0 ? diffuse * inverse : vec4(0.0, 0.0, 0.0, 1.0));
    imageStore(specular_out, at, specular * inverse);
}
