// Static voxels from the buffers that hold them.

#include "shaders/include/rigid_voxel.glsl"

layout(std430, binding = 1) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 2) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 3) readonly buffer chunks_block { kd_voxel_chunk_params chunks[]; };
layout(binding = 4) uniform usamplerBuffer shape; // rg32ui

rigid_voxel rigid_voxel_load(kd_voxel_segment segment, uint i)
{
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    return rigid_voxel_of(segment.chunk_cascade >> 28, objects[segment.object], chunk.origin, texelFetch(shape, int(segment.first + i)).r);
}

// 3 x snorm8
uint rigid_voxel_load_normal(kd_voxel_segment segment, uint i)
{
    return rigid_voxel_normal(objects[segment.object], texelFetch(shape, int(segment.first + i)).g);
}
