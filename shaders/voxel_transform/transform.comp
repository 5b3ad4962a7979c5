// Brings cached voxels of the dynamic layer to the world and writes them to the pages; marks the leaf parents whose cells they
// cover, unless KD_UNMARKED. One program a kind of object, over the groups that list.comp has listed: KD_SKINNED blends
// the joints by the voxel's own weights, KD_ATTACHED follows the surface point that it is tied to, neither: the object's matrix.
// What all voxels read comes through texel buffers, which software drivers gather several times faster than storage.
// Source: Yalciner 2016, section 4.3 (transformation) and 4.7; the coverage splat is ours.
layout(local_size_x = 64) in;

#include "shaders/include/splat_parents.glsl"
#include "shaders/include/voxel_pose.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: segment slots, y: kind
layout(binding = 4) uniform usamplerBuffer records;     // rgba32ui, KD_MOVING_RECORD a segment
layout(binding = 5) uniform usamplerBuffer shapes;      // rg32ui, the cache's
layout(binding = 6) uniform samplerBuffer object_rows;  // rgba32f, kd_voxel_object_params
layout(binding = 7) uniform usamplerBuffer colors;      // r32ui, the cache's
layout(std430, binding = 4) readonly buffer work_block { uint work[]; };
layout(std430, binding = 5) writeonly buffer voxels_block { uint voxels[]; };

const int OBJECT_ROWS = 8;

posed pose_of(uvec4 object, uint binding_at, vec3 p, vec3 n)
{
#ifdef KD_SKINNED
    return pose_skinned(object.y, binding_at, p, n);
#else
    kd_voxel_object_params o;
    int row = int(object.x) * OBJECT_ROWS;
    for (int k = 0; k < 3; k++) {
        o.model_ws[k] = texelFetch(object_rows, row + k);
        o.normal_ws[k] = texelFetch(object_rows, row + 3 + k);
    }
    o.info = object;
#ifdef KD_ATTACHED
    return pose_attached(o, binding_at);
#else
    return pose_rigid(o, p, n);
#endif
#endif
}

#ifndef KD_UNMARKED
layout(std430, binding = 6) buffer mask_block { uint mask[]; }; // of leaf parents

// A leaf parent is marked by a dozen voxels in the mean: all but the first find the bit there and need no atomic.
void mark(uint c, splat s)
{
    splat_codes codes = splat_parent_codes(s, c);
    for (uint corners = splat_parents(s, splat_corners(s, c)); corners != 0u; corners &= corners - 1u) {
        uint k = uint(findLSB(corners));
        uint bit = splat_parent_code(codes, k), flag = 1u << (bit & 31u);
        if ((mask[bit >> 5] & flag) == 0u)
            atomicOr(mask[bit >> 5], flag);
    }
}
#endif

void main()
{
    uint entry = gl_WorkGroupID.y * KD_GROUP_ROW + gl_WorkGroupID.x;
    bool listed = entry < work[KD_MOVING_COUNT(pass.y)];
    uint group = listed ? work[KD_MOVING_LIST(pass.y, pass.x) + entry] : 0u, slot = group / KD_MOVING_GROUPS;
    uint i = group % KD_MOVING_GROUPS * KD_MOVING_GROUP + gl_LocalInvocationIndex;
    int record = int(slot * KD_MOVING_RECORD);
    uvec4 segment = texelFetch(records, record + 1);
    if (!listed || i >= segment.y)
        return;
    vec4 origin = uintBitsToFloat(texelFetch(records, record));
    uvec2 cached = texelFetch(shapes, int(segment.x + i)).rg;
    kd_voxel_chunk_params chunk;
    chunk.origin = origin;
    uint c = segment.z & ~KD_MOVING_GLOWS;
    vec3 p = rigid_model_position(chunk, cached.x), n = vec3(snorm8_unpack(cached.y)) / 127.0;
    posed v = pose_of(texelFetch(records, record + 2), segment.w + i, p, n);
    uint at = (slot * KD_SEGMENT_VOXELS + i) * KD_PAGE_WORDS;
    precise vec3 position = v.position_ws / tree.cascade[c].w;
    if (!splat_inside(c, position)) {
        voxels[at] = KD_NO_VOXEL;
        return;
    }
    splat s = splat_at(c, position);
    voxels[at] = splat_pack_cell(s);
    voxels[at + 1u] = splat_pack_fraction(s);
    uint share = (segment.z & KD_MOVING_GLOWS) != 0u ? cached.y & 0xFF000000u : 0u;
    voxels[at + 2u] = rigid_pack_normal(v.normal_ws, length(n)) | share;
    voxels[at + 3u] = texelFetch(colors, int(segment.x + i)).r;
#ifndef KD_UNMARKED
    mark(c, s);
#endif
}
