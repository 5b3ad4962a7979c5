// Static voxels from the storage buffers that hold them.

#include "shaders/include/rigid_voxel.glsl"

layout(std430, binding = 1) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 2) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 3) readonly buffer chunks_block { kd_voxel_chunk_params chunks[]; };
layout(std430, binding = 4) readonly buffer shape_block { uvec2 shape[]; };

rigid_voxel rigid_voxel_load(kd_voxel_segment segment, uint i)
{
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    return rigid_voxel_of(segment.chunk_cascade >> 28, objects[segment.object], chunk.origin, shape[segment.first + i].x);
}

// 3 x snorm8
uint rigid_voxel_load_normal(kd_voxel_segment segment, uint i)
{
    return rigid_voxel_normal(objects[segment.object], shape[segment.first + i].y);
}
