// The rows of objects and the origins of chunks that bring static voxels to the world, through texel buffers, which software drivers
// gather several times faster than storage. Units 0 to 2.

#include "shaders/include/rigid_voxel.glsl"

layout(binding = 0) uniform usamplerBuffer segment_texels; // rgba32ui: object, first voxel, count, chunk and cascade
layout(binding = 1) uniform samplerBuffer chunk_texels;    // rgba32f, two a chunk
layout(binding = 2) uniform samplerBuffer object_texels;   // rgba32f, eight an object

kd_voxel_segment segment_fetch(uint slot)
{
    uvec4 s = texelFetch(segment_texels, int(slot));
    return kd_voxel_segment(s.x, s.y, s.z, s.w);
}

vec4 chunk_fetch_origin(kd_voxel_segment s) { return texelFetch(chunk_texels, int(s.chunk_cascade & 0xFFFFFFFu) * 2); }

// The matrix of positions alone, and that of normals.
kd_voxel_object_params object_fetch(uint object)
{
    kd_voxel_object_params o;
    for (int k = 0; k < 3; k++)
        o.model_ws[k] = texelFetch(object_texels, int(object) * 8 + k);
    return o;
}

kd_voxel_object_params object_fetch_normals(uint object)
{
    kd_voxel_object_params o;
    for (int k = 0; k < 3; k++)
        o.normal_ws[k] = texelFetch(object_texels, int(object) * 8 + 3 + k);
    return o;
}
