// Chains static voxels to the leaf parents in stale bricks whose cells they cover, and marks these cells. A parent's place is that
// of its patch on the list of stale ones. An entry holds all that a parent needs of a voxel: the next entry | shares of the far
// cells, corner of the block (3 bits), odd axes (3 bits) | normal, emission | albedo. A voxel's first entry has its own place,
// others, which few static voxels have, are taken behind those of all that are listed. Where there is not room for that a round
// chains a range of patches, and takes all entries in turn.
layout(local_size_x = 64) in;

#include "shaders/include/rigid_texels.glsl"
#include "shaders/include/splat_parents.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; uvec4 marks; }; // x: first patch of this round, y: patches of it, z: room for entries, w: 1 when all of them are taken in turn; marks: x: first patch whose cells are marked, y: patches of these
layout(std140, binding = 1) uniform stale_places_block { kd_stale_places stale_at; };
layout(binding = 3) uniform usamplerBuffer shape_texels; // rg32ui
layout(binding = 4) uniform usamplerBuffer color_texels; // r32ui
layout(binding = 5) uniform usamplerBuffer stale_texels; // r32ui: the buffer below
layout(std430, binding = 0) buffer stale_block { uint stale[]; };
layout(std430, binding = 1) buffer fresh_block { uint fresh[]; };
layout(std430, binding = 2) buffer heads_block { uint heads[]; };
layout(std430, binding = 3) writeonly buffer entries_block { uvec4 entries[]; };
layout(std430, binding = 4) writeonly buffer glows_block { uint glows[]; }; // objects of entries, where anything glows

uint stale_word(uint at) { return texelFetch(stale_texels, int(at)).r; }

// Cells of the parent in which corner k of a block lies, of the marked `corners` of the block; odd: bits of the axes.
uint parent_cells(uint corners, uint odd, uint k)
{
    const uint near[3] = {0x55u, 0x33u, 0x0Fu};
    for (uint axis = 0u; axis < 3u; axis++) {
        bool is_odd = (odd >> axis & 1u) != 0u, far = (k >> axis & 1u) != 0u;
        uint low = corners & near[axis], high = corners & ~near[axis];
        // The block's near cell is the far one of its parent, and its far cell the near one of the next.
        uint crossed = far ? high >> (1u << axis) : low << (1u << axis);
        corners = is_odd ? crossed : low | high;
    }
    return corners;
}

void mark(uint place, uint cells)
{
    place -= marks.x << 5;
    if (place >= marks.y << 5)
        return;
    uint word = place >> 2, bits = cells << (8u * (place & 3u));
    if ((fresh[word] & bits) != bits)
        atomicOr(fresh[word], bits);
}

// c: cascade, voxel: in the cache, entry: its own
void link(uint c, uint object, kd_voxel_object_params rows, vec4 origin, uint voxel, uint entry)
{
    uvec2 cached = texelFetch(shape_texels, int(voxel)).rg;
    rigid_voxel v = rigid_voxel_of(c, rows, origin, cached.x);
    uint corners = v.inside ? splat_corners(v.place, c) : 0u;
    uint odd = (uint(v.place.cell.x) & 1u) | (uint(v.place.cell.y) & 1u) << 1 | (uint(v.place.cell.z) & 1u) << 2;
    splat_codes codes = splat_parent_codes(v.place, c);
    bool first = true;
    for (uint parents = splat_parents(v.place, corners); parents != 0u; parents &= parents - 1u) {
        uint k = uint(findLSB(parents)), code = splat_parent_code(codes, k), brick = code >> (3u * tree.info.w - 3u);
        if ((stale_word(stale_at.bits + (brick >> 5)) >> (brick & 31u) & 1u) == 0u)
            continue;
        uint place = stale_word(stale_at.slots + (code >> 5)) << 5 | (code & 31u);
        mark(place, cascade_given_up(c) == 0u ? parent_cells(corners, odd, k) : 1u);
        place -= pass.x << 5;
        if (place >= pass.y << 5)
            continue;
        if (!first || pass.w != 0u)
            entry = atomicAdd(stale[KD_STALE_ENTRIES], 1u);
        first = false;
        if (entry >= pass.z)
            continue;
        uint normal = rigid_voxel_normal(object_fetch_normals(object), cached.y) | (cached.y & 0xFF000000u);
        entries[entry] = uvec4(atomicExchange(heads[place], entry), splat_pack_fraction(v.place) | k << 24 | odd << 27,
                               normal, texelFetch(color_texels, int(voxel)).r);
        for (bool glow = tree.light.x > 0.0 && entry < uint(glows.length()); glow; glow = false)
            glows[entry] = object;
    }
}

void main()
{
    uint local = gl_LocalInvocationIndex, lane = local % KD_GROUP_LANES;
    uint listed = (gl_WorkGroupID.y * KD_GROUP_ROW + gl_WorkGroupID.x) * KD_GROUPS_AT_ONCE + local / KD_GROUP_LANES;
    if (listed >= stale_word(KD_STALE_COUNT))
        return;
    uint n = stale_word(stale_at.groups + listed), begin = n % KD_SEGMENT_GROUPS * KD_GROUP_VOXELS;
    kd_voxel_segment segment = segment_fetch(n / KD_SEGMENT_GROUPS);
    vec4 origin = chunk_fetch_origin(segment);
    kd_voxel_object_params rows = object_fetch(segment.object);
    uint end = min(begin + KD_GROUP_VOXELS, segment.count);
    for (uint i = begin + lane; i < end; i += KD_GROUP_LANES)
        link(segment.chunk_cascade >> 28, segment.object, rows, origin, segment.first + i, listed * KD_GROUP_VOXELS + i - begin);
}
