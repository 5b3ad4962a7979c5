// Lists the groups of static voxels that may lie in a stale part of their cascade: their boxes against the stale boxes. One
// invocation a segment slot, which looks at the box of all its groups first.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/rigid_texels.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots, y: stale boxes
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(binding = 3) uniform usamplerBuffer bounds; // rg32ui: low and high corner of the groups of every slot
layout(binding = 4) uniform usamplerBuffer boxes;  // rgba32ui: kd_stale_box, as bits
layout(std430, binding = 0) buffer stale_block { uint stale[]; };

kd_voxel_object_params object;
vec4 chunk_origin;
uint cascade;

// Does a box of cells of the chunk meet a stale one?
bool meets(uvec3 low_cell, uvec3 high_cell)
{
    vec3 a = vec3(low_cell), b = vec3(high_cell) + 1.0;
    vec3 centre = rigid_position(object, chunk_origin.xyz + 0.5 * (a + b) * chunk_origin.w);
    vec3 half_size = 0.5 * (b - a) * chunk_origin.w;
    vec3 reach = vec3(dot(abs(object.model_ws[0].xyz), half_size), dot(abs(object.model_ws[1].xyz), half_size), dot(abs(object.model_ws[2].xyz), half_size));
    // A voxel reaches a cell further than its box, and rounding may take it a little beyond.
    vec3 low = (centre - reach - tree.cascade[cascade].xyz) / tree.cascade[cascade].w - 1.25;
    vec3 high = (centre + reach - tree.cascade[cascade].xyz) / tree.cascade[cascade].w + 1.25;
    bool any_box = false;
    for (uint i = 0u; i < pass.y; i++) {
        ivec4 from = ivec4(texelFetch(boxes, int(2u * i))), to = ivec4(texelFetch(boxes, int(2u * i + 1u)));
        any_box = any_box || (uint(from.w) == cascade && to.w != 0 && all(lessThan(low, vec3(to.xyz))) && all(greaterThan(high, vec3(from.xyz))));
    }
    return any_box;
}

void main()
{
    uint slot = linear_index(), first = slot * KD_SEGMENT_GROUPS;
    if (slot >= pass.x)
        return;
    kd_voxel_segment segment = segment_fetch(slot);
    uint groups = (segment.count + KD_GROUP_VOXELS - 1u) / KD_GROUP_VOXELS;
    if (groups == 0u)
        return;
    uvec3 low = uvec3(1023u), high = uvec3(0u);
    for (uint n = first; n < first + groups; n++) {
        uvec2 box = texelFetch(bounds, int(n)).rg;
        low = min(low, cell_unpack(box.x));
        high = max(high, cell_unpack(box.y));
    }
    cascade = segment.chunk_cascade >> 28;
    chunk_origin = chunk_fetch_origin(segment);
    object = object_fetch(segment.object);
    groups = meets(low, high) ? groups : 0u;
    for (uint n = first; n < first + groups; n++) {
        uvec2 box = texelFetch(bounds, int(n)).rg;
        if (meets(cell_unpack(box.x), cell_unpack(box.y)))
            stale[stale_at.groups + atomicAdd(stale[KD_STALE_COUNT], 1u)] = n;
    }
}
