// Static voxels: from the cache to the grid. They are not kept in the pages; the passes that need them come here, and all get
// the same words, because nothing in the way is left to the compiler (precise).

#include "shaders/include/splat.glsl"

#include "shaders/include/rigid.glsl"

layout(std430, binding = 1) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 2) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 3) readonly buffer chunks_block { kd_voxel_chunk_params chunks[]; };
layout(std430, binding = 4) readonly buffer shape_block { uvec2 shape[]; };

struct rigid_voxel {
    bool inside;   // of its cascade, or at its border
    splat place;
    uint normal;   // 3 x snorm8
};

rigid_voxel rigid_voxel_load(kd_voxel_segment segment, uint i)
{
    uint c = segment.chunk_cascade >> 28;
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    kd_voxel_object_params o = objects[segment.object];
    uvec2 cached = shape[segment.first + i];
    precise vec3 position = rigid_position(o, rigid_model_position(chunk, cached.x)) / tree.cascade[c].w;
    vec3 n = vec3(snorm8_unpack(cached.y)) / 127.0;
    rigid_voxel v;
    v.inside = splat_inside(c, position);
    v.place = splat_at(c, v.inside ? position : vec3(0.0));
    v.normal = rigid_pack_normal(rigid_normal(o, n), length(n));
    return v;
}
