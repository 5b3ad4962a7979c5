// Voxels as the views "caches" and "pages" draw them: boxes in the world. VOXELS says whose: caches posed at their objects,
// pages of the static layer (which are brought to the world here, as everywhere), or pages of the dynamic one.

#define CACHES 0
#define STATIC_PAGES 1
#define DYNAMIC_PAGES 2

// Files are included once, wherever that is: what the branches below share comes before them.
#include "shaders/shared/debug_view.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "shaders/include/splat.glsl"
#include "shaders/include/rigid.glsl"

layout(std140, binding = KD_BIND_PASS) uniform pass_block
{
    kd_debug_view_params params;
    kd_voxel_view_params voxels_of;
};
layout(std430, binding = 5) buffer pixels_block { uint pixels[]; }; // of each pixel: depth as bits, then number of the voxel

#if VOXELS == CACHES
#include "shaders/include/voxel_pose.glsl"
layout(std430, binding = 0) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 1) readonly buffer objects_block { kd_voxel_object_params objects[]; };
layout(std430, binding = 2) readonly buffer chunks_block { kd_voxel_chunk_params chunks[]; };
layout(binding = 4) uniform usamplerBuffer shape; // rg32ui
#elif VOXELS == STATIC_PAGES
#include "shaders/include/rigid_voxel_load.glsl"
#else
layout(std430, binding = 1) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 2) readonly buffer voxels_block { uint voxels[]; };
#endif

const uint NO_VOXEL = 0xFFFFFFFFu;

struct voxel_box {
    bool there;
    vec3 centre_ws;
    mat3 axes;      // half edges
    vec3 normal_ws;
    float coverage; // share of the voxel that covers cells of its cascade
};

#if VOXELS == CACHES
voxel_box box_load(kd_voxel_segment segment, uint slot, uint i)
{
    kd_voxel_chunk_params chunk = chunks[segment.chunk_cascade & 0xFFFFFFFu];
    uvec2 cached = texelFetch(shape, int(segment.first + i)).rg;
    vec3 p = rigid_model_position(chunk, cached.x), n = vec3(snorm8_unpack(cached.y)) / 127.0;
    uint binding_at = chunk.info.z + segment.first + i - chunk.info.x;
    posed v = voxel_pose(objects[segment.object], binding_at, p, n);
    return voxel_box(true, v.position_ws, v.axes * (0.5 * chunk.origin.w), v.normal_ws, 1.0);
}
#else
voxel_box box_of(uint c, splat s, uint normal)
{
    uint corners = splat_corners(s, c), weight = 0u;
    for (uint left = corners; left != 0u; left &= left - 1u)
        weight += splat_weight(s, uint(findLSB(left)));
    vec3 low = vec3(s.cell) + vec3(s.fraction) / 256.0;
    vec3 centre = tree.cascade[c].xyz + (low + 0.5) * tree.cascade[c].w;
    return voxel_box(corners != 0u, centre, mat3(0.5 * tree.cascade[c].w), vec3(snorm8_unpack(normal)) / 127.0,
                     float(weight) / 256.0);
}

voxel_box box_load(kd_voxel_segment segment, uint slot, uint i)
{
    uint c = segment.chunk_cascade >> 28;
    voxel_box none;
    none.there = false;
#if VOXELS == STATIC_PAGES
    rigid_voxel v = rigid_voxel_load(segment, i);
    if (!v.inside || c < params.view.z)
        return none;
    return box_of(c, v.place, rigid_voxel_load_normal(segment, i));
#else
    uint at = (slot * KD_SEGMENT_VOXELS + i) * KD_PAGE_WORDS;
    if (voxels[at] == KD_NO_VOXEL || c < params.view.z)
        return none;
    return box_of(c, splat_unpack(voxels[at], voxels[at + 1u]), voxels[at + 2u]);
#endif
}
#endif

// Box number n of this source; false where its slot is empty.
bool box_find(uint n, out kd_voxel_segment segment, out voxel_box box)
{
    uint slot = n / KD_SEGMENT_VOXELS, i = n % KD_SEGMENT_VOXELS;
    box.there = false;
    if (slot >= voxels_of.source.y)
        return false;
    segment = segments[slot];
    if (i < segment.count)
        box = box_load(segment, slot, i);
    return box.there;
}
