// Cells of the dynamic layer: one invocation a leaf parent adds up the voxels on its chain (link.comp), for its eight cells at
// once, and packs them. Leaves the heads of the chains empty, for the next frame.
layout(local_size_x = 64) in;

#include "shaders/include/linear.glsl"
#include "shaders/include/cell_pack.glsl"
#include "shaders/include/splat_parents.glsl"
#include "shaders/include/cell_shares.glsl"

layout(std140, binding = 0) uniform pass_block { uvec4 pass; }; // x: parents that there is room for
layout(binding = 0) uniform usamplerBuffer voxels; // rgba32ui
layout(binding = 1) uniform usamplerBuffer next;   // r32ui
layout(std430, binding = 0) buffer counters_block { uint counters[]; };
layout(std430, binding = 1) buffer heads_block { uint heads[]; }; // first entries
layout(std430, binding = 2) writeonly buffer cells_block { uvec4 cells[]; };
layout(std430, binding = 3) buffer masks_block { uint masks[]; }; // of the cells
layout(std430, binding = 4) readonly buffer segments_block { kd_voxel_segment segments[]; };
layout(std430, binding = 5) readonly buffer objects_block { kd_voxel_object_params objects[]; };

shared uint occupied; // cells of this group's parents

// Something of each of the eight cells: those of the near half along z, then those of the far one.
struct eight { uvec4 near, far; };

void add(inout eight sum, eight weight, uint v)
{
    sum.near += weight.near * v;
    sum.far += weight.far * v;
}

uint of(eight e, uint k) { return k < 4u ? e.near[k] : e.far[k - 4u]; }

eight marked(eight w)
{
    return eight(mix(uvec4(0u), w.near, greaterThanEqual(w.near, uvec4(KD_SPLAT_MIN_WEIGHT))),
                 mix(uvec4(0u), w.far, greaterThanEqual(w.far, uvec4(KD_SPLAT_MIN_WEIGHT))));
}

// Shares of a voxel in the eight cells, of 256. `corner` of its block lies in this parent; on axes on which the block's low cell
// is odd the block reaches into two parents, with one cell in each.
eight shares(uvec2 place, uint corner)
{
    uvec3 far = uvec3(place.y, place.y >> 8, place.y >> 16) & 255u, near = 256u - far;
    bvec3 odd = equal(uvec3(place.x, place.x >> 10, place.x >> 20) & 1u, uvec3(0u)); // stored one higher
    bvec3 beyond = notEqual(uvec3(corner, corner >> 1, corner >> 2) & 1u, uvec3(0u));
    uvec3 w0 = mix(near, mix(uvec3(0u), far, beyond), odd), w1 = mix(far, mix(near, uvec3(0u), beyond), odd);
    uvec4 sides = uvec4(w0.x, w1.x, w0.x, w1.x) * uvec4(w0.yy, w1.yy);
    return marked(eight((sides * w0.z) >> 16, (sides * w1.z) >> 16));
}

// Code of the parent for which an entry is on a chain.
uint parent_code(uint entry)
{
    uvec2 place = texelFetch(voxels, int(entry >> 3)).xy;
    uint c = segments[(entry >> 3) / KD_SEGMENT_VOXELS].chunk_cascade >> 28;
    return splat_parent_code(splat_parent_codes(splat_unpack(place.x, place.y), c), entry & 7u);
}

// What the eight cells send out; few parents have anything that glows.
void add_emission(uint first, uint n, uint bits)
{
    for (; bits != 0u; bits &= bits - 1u) {
        uint k = uint(findLSB(bits)), weight = 0u, emissive = 0u, area = 0u;
        uvec3 emission = uvec3(0u);
        for (uint entry = first; entry != KD_EMPTY; entry = texelFetch(next, int(entry)).r) {
            uvec4 v = texelFetch(voxels, int(entry >> 3));
            uint w = of(shares(v.xy, entry & 7u), k);
            uvec3 e = share_emission(v.z >> 24, objects[segments[(entry >> 3) / KD_SEGMENT_VOXELS].object].emission.rgb);
            uint glows = e == uvec3(0u) ? 0u : w;
            weight += w;
            emission += (e * glows + 128u) >> 8;
            emissive += glows;
            area += share_area(v.w) * glows;
        }
        cells[n * 8u + k].zw = cell_pack_emission(weight, emission, emissive, area);
    }
}

// Returns how many of the eight cells are occupied.
uint make_cells(uint n)
{
    const eight none = eight(uvec4(0u), uvec4(0u));
    uint first = heads[n], share = 0u;
    eight weight = none, r = none, g = none, b = none, x = none, y = none, z = none, double_sided = none;
    // What the next round needs is asked for before this one is worked on: it lies anywhere.
    uvec4 v = texelFetch(voxels, int(first >> 3));
    for (uint entry = first, following; entry != KD_EMPTY; entry = following) {
        following = texelFetch(next, int(entry)).r;
        eight w = shares(v.xy, entry & 7u);
        uvec3 albedo = share_albedo(v.w), normal = uvec3(snorm8_unpack(v.z));
        add(weight, w, 1u);
        add(r, w, albedo.r);
        add(g, w, albedo.g);
        add(b, w, albedo.b);
        add(x, w, normal.x);
        add(y, w, normal.y);
        add(z, w, normal.z);
        add(double_sided, w, share_double_sided(v.w));
        share |= v.z >> 24;
        v = texelFetch(voxels, int(following >> 3));
    }
    uint bits = 0u;
#define CELL(k, half, at)                                                                                                       \
    if (weight.half.at != 0u) {                                                                                                 \
        bits |= 1u << k;                                                                                                        \
        cells[n * 8u + k] = uvec4(cell_pack_surface(weight.half.at, uvec3(r.half.at, g.half.at, b.half.at),                     \
                                                    ivec3(x.half.at, y.half.at, z.half.at), double_sided.half.at),              \
                                  0u, 0u);                                                      \
    }
    CELL(0u, near, x) CELL(1u, near, y) CELL(2u, near, z) CELL(3u, near, w)
    CELL(4u, far, x) CELL(5u, far, y) CELL(6u, far, z) CELL(7u, far, w)
    heads[n] = KD_EMPTY;
    if (bits != 0u) {
        uint code = parent_code(first);
        atomicOr(masks[code >> 2], bits << (8u * (code & 3u)));
    }
    add_emission(first, n, share != 0u ? bits : 0u);
    return uint(bitCount(bits));
}

void main()
{
    uint n = linear_index(), local = gl_LocalInvocationIndex;
    if (local == 0u)
        occupied = 0u;
    barrier();
    if (n < min(counters[KD_COUNT_PARENTS], pass.x))
        atomicAdd(occupied, make_cells(n));
    barrier();
    if (local == 0u)
        atomicAdd(counters[KD_COUNT_DYNAMIC], occupied);
}
