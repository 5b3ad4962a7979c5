// Finds the groups of static voxels that may lie in a stale part of their cascade: one invocation a group, its box against
// the stale boxes.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/rigid_voxel.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots, y: stale boxes
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(std430, binding = 0) buffer stale_block { uint stale[]; };
layout(std430, binding = 5) readonly buffer bounds_block { uvec2 bounds[]; };
layout(std430, binding = 6) readonly buffer boxes_block { kd_stale_box boxes[]; };

void main()
{
    uint n = linear_index(), slot = n / KD_SEGMENT_GROUPS, begin = n % KD_SEGMENT_GROUPS * KD_GROUP_VOXELS;
    if (slot >= pass.x)
        return;
    kd_voxel_segment segment = segments[slot];
    if (begin >= segment.count)
        return;
    uint c = segment.chunk_cascade >> 28;
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    kd_voxel_object_params o = objects[segment.object];
    vec3 a = vec3(cell_unpack(bounds[n].x)), b = vec3(cell_unpack(bounds[n].y)) + 1.0;
    vec3 centre = rigid_position(o, chunk.origin.xyz + 0.5 * (a + b) * chunk.origin.w);
    vec3 half_size = 0.5 * (b - a) * chunk.origin.w;
    vec3 reach = vec3(dot(abs(o.model_ws[0].xyz), half_size), dot(abs(o.model_ws[1].xyz), half_size), dot(abs(o.model_ws[2].xyz), half_size));
    // A voxel reaches a cell further than its box, and rounding may take it a little beyond.
    vec3 low = (centre - reach - tree.cascade[c].xyz) / tree.cascade[c].w - 1.25;
    vec3 high = (centre + reach - tree.cascade[c].xyz) / tree.cascade[c].w + 1.25;
    bool meets = false;
    for (uint i = 0u; i < pass.y; i++)
        meets = meets || (uint(boxes[i].low.w) == c && boxes[i].high.w != 0 && all(lessThan(low, vec3(boxes[i].high.xyz))) && all(greaterThan(high, vec3(boxes[i].low.xyz))));
    if (meets)
        stale[stale_at.groups + atomicAdd(stale[KD_STALE_COUNT], 1u)] = n;
}
