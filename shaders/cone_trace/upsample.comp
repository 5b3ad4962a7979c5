// From every n-th pixel to all: the four traced pixels round each one, weighted by bilinear distance, by how well they lie
// on the same plane and by the angle between normals. Where none fits, the nearest in depth is taken.
layout(local_size_x = 8, local_size_y = 8) in;

#include "shaders/shared/gather.h"
#include "shaders/include/gbuffer.glsl"

layout(std140, binding = KD_BIND_PASS) uniform gather_block { kd_gather_params gather; };
layout(binding = KD_UNIT_GI_DIFFUSE) uniform sampler2D diffuse_in;
layout(binding = KD_UNIT_GI_SPECULAR) uniform sampler2D specular_in;
layout(binding = 0, rgba16f) writeonly uniform image2D diffuse_out;
layout(binding = 1, rgba16f) writeonly uniform image2D specular_out;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, ivec2(gather.size.xy))))
        return;
    float depth = gbuffer_load_depth(pixel);
    if (depth >= 1.0) {
        imageStore(diffuse_out, pixel, vec4(0.0, 0.0, 0.0, 1.0));
        imageStore(specular_out, pixel, vec4(0.0));
        return;
    }
    uvec4 packed_normal = texelFetch(gbuffer_normal, pixel, 0);
    vec3 normal = octahedral_decode(packed_normal.xy), face = octahedral_decode(packed_normal.zw);
    vec3 position = gbuffer_position(pixel, depth);
    float distance_scale = 1.0 / max(length(position - kd_view.position_ws.xyz), 1e-4);
    int n = int(gather.size.z);
    ivec2 low = pixel / n, last = (ivec2(gather.size.xy) - 1) / n;
    vec2 f = (vec2(pixel) - vec2(low * n)) / float(n);
    vec4 diffuse = vec4(0.0), specular = vec4(0.0);
    float sum = 0.0;
    for (int i = 0; i < 4; i++) {
        ivec2 o = ivec2(i & 1, i >> 1), at = min(low + o, last), traced = at * n;
        float other_depth = gbuffer_load_depth(traced);
        if (other_depth >= 1.0)
            continue;
        vec2 b = mix(1.0 - f, f, vec2(o)) + 1e-3;
        vec3 other_normal = octahedral_decode(texelFetch(gbuffer_normal, traced, 0).xy);
        float off_plane = abs(dot(gbuffer_position(traced, other_depth) - position, face)) * distance_scale;
        float w = b.x * b.y * exp(-off_plane * 200.0) * pow(max(dot(normal, other_normal), 0.0), 8.0) + b.x * b.y * 1e-5 * exp(-off_plane * 20.0);
        diffuse += w * texelFetch(diffuse_in, at, 0);
        specular += w * texelFetch(specular_in, at, 0);
        sum += w;
    }
    float inverse = sum > 0.0 ? 1.0 / sum : 0.0;
    imageStore(diffuse_out, pixel, sum > 0.0 ? diffuse * inverse : vec4(0.0, 0.0, 0.0, 1.0));
    imageStore(specular_out, pixel, specular * inverse);
}
