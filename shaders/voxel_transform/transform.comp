// Brings the cached voxels of the dynamic layer to the world: rigid by the object's matrix, skinned by the blend of the voxel's own
// weights, attached (morphing) by the surface point that it is tied to. Writes the page voxel and, unless KD_UNMARKED, marks the
// cells that it covers in the layer's mask.
//
// One row of work groups a segment; empty slots end at once.
// Source: Yalciner 2016, section 4.3 (transformation) and 4.7; the coverage splat is ours.
layout(local_size_x = 128) in;

#include "shaders/include/splat.glsl"
#include "shaders/include/morton.glsl"
#include "shaders/include/voxel_pose.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots
layout(std430, binding = 0) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 1) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 2) readonly buffer chunks_block { kd_voxel_chunk_params chunks[]; };
layout(std430, binding = 3) readonly buffer shape_block { uvec2 shape[]; };
layout(std430, binding = 5) writeonly buffer voxels_block { uint voxels[]; };
#ifndef KD_UNMARKED
layout(std430, binding = 6) buffer mask_block { uint mask[]; };

void mark(uint c, splat s)
{
    uint first = cascade_first_bit(c);
    for (uint corners = splat_corners(s, c); corners != 0u; corners &= corners - 1u) {
        uint bit = first + morton_encode(cell_wrap(c, splat_cell(s, uint(findLSB(corners)))));
        atomicOr(mask[bit >> 5], 1u << (bit & 31u));
    }
}
#endif

void main()
{
    uint slot = gl_WorkGroupID.y, i = gl_GlobalInvocationID.x;
    kd_voxel_segment segment = segments[slot];
    if (i >= segment.count)
        return;
    uint c = segment.chunk_cascade >> 28;
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    kd_voxel_object_params o = objects[segment.object];
    uvec2 cached = shape[segment.first + i];
    vec3 p = rigid_model_position(chunk, cached.x);
    vec3 n = vec3(snorm8_unpack(cached.y)) / 127.0;
    uint binding_at = chunk.info.z + segment.first + i - chunk.info.x;
    posed v = voxel_pose(o, binding_at, p, n);
    uint at = (slot * KD_SEGMENT_VOXELS + i) * 3u;
    precise vec3 position = v.position_ws / tree.cascade[c].w;
    if (!splat_inside(c, position)) {
        voxels[at] = KD_NO_VOXEL;
        return;
    }
    splat s = splat_at(c, position);
    voxels[at] = splat_pack_cell(s);
    voxels[at + 1u] = splat_pack_fraction(s);
    voxels[at + 2u] = rigid_pack_normal(v.normal_ws, length(n));
#ifndef KD_UNMARKED
    mark(c, s);
#endif
}
