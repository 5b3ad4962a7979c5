// The eight cells of a leaf parent from a chain of the voxels that cover them, added up in registers. Who includes this says what
// stands on a chain: chain_load and chain_emission.

#include "shaders/include/cell_pack.glsl"
#include "shaders/include/cell_shares.glsl"

// Something of each of the eight cells: those of the near half along z, then those of the far one.
struct eight { uvec4 near, far; };

const eight EIGHT_NONE = eight(uvec4(0u), uvec4(0u));

struct chained {
    uint next;     // entry, KD_EMPTY at the end
    uvec3 far;     // shares of the far cells of the voxel's block on the three axes, of 256
    bvec3 odd;     // axes on which the block's low cell is odd: the block reaches into two parents, with one cell in each
    uint corner;   // of the block that lies in this parent
    uint normal;   // 3 x snorm8 | emission
    uint color;
};

// What stands at an entry; anything beyond the end.
chained chain_load(uint entry);
// What the voxel at an entry emits; share: as it is cached
uvec3 chain_emission(uint entry, uint share);

void eight_add(inout eight sum, eight weight, uint v)
{
    sum.near += weight.near * v;
    sum.far += weight.far * v;
}

uint eight_of(eight e, uint k) { return k < 4u ? e.near[k] : e.far[k - 4u]; }

uint eight_all(eight e)
{
    uvec4 halves = e.near + e.far;
    return halves.x + halves.y + halves.z + halves.w;
}

// The eight are one cell, which stands at the first.
void eight_join(inout eight e) { e = eight(uvec4(eight_all(e), uvec3(0u)), uvec4(0u)); }

eight eight_marked(eight w)
{
    return eight(mix(uvec4(0u), w.near, greaterThanEqual(w.near, uvec4(KD_SPLAT_MIN_WEIGHT))),
                 mix(uvec4(0u), w.far, greaterThanEqual(w.far, uvec4(KD_SPLAT_MIN_WEIGHT))));
}

// Shares of a voxel in the eight cells, of 256.
eight chain_shares(chained v)
{
    uvec3 near = 256u - v.far;
    bvec3 beyond = notEqual(uvec3(v.corner, v.corner >> 1, v.corner >> 2) & 1u, uvec3(0u));
    uvec3 w0 = mix(near, mix(uvec3(0u), v.far, beyond), v.odd), w1 = mix(v.far, mix(near, uvec3(0u), beyond), v.odd);
    uvec4 sides = uvec4(w0.x, w1.x, w0.x, w1.x) * uvec4(w0.yy, w1.yy);
    return eight_marked(eight((sides * w0.z) >> 16, (sides * w1.z) >> 16));
}

struct eight_sums {
    eight weight, r, g, b, x, y, z, double_sided;
    uint share; // of emission: 0 when nothing can glow
};

// The voxels from `entry` on. What the next round needs is asked for before this one is worked on: it lies anywhere.
eight_sums chain_sums(uint entry)
{
    eight_sums s = eight_sums(EIGHT_NONE, EIGHT_NONE, EIGHT_NONE, EIGHT_NONE, EIGHT_NONE, EIGHT_NONE, EIGHT_NONE, EIGHT_NONE, 0u);
    chained v = chain_load(entry);
    while (entry != KD_EMPTY) {
        entry = v.next;
        chained following = chain_load(entry);
        eight w = chain_shares(v);
        uvec3 albedo = share_albedo(v.color), normal = uvec3(snorm8_unpack(v.normal));
        eight_add(s.weight, w, 1u);
        eight_add(s.r, w, albedo.r);
        eight_add(s.g, w, albedo.g);
        eight_add(s.b, w, albedo.b);
        eight_add(s.x, w, normal.x);
        eight_add(s.y, w, normal.y);
        eight_add(s.z, w, normal.z);
        eight_add(s.double_sided, w, share_double_sided(v.color));
        s.share |= v.normal >> 24;
        v = following;
    }
    return s;
}

// The same where a cascade has given levels up (cascade_given_up of tree_params.glsl). A loop, since software drivers run a branch
// that no lane takes.
void chain_join(inout eight_sums s, uint given_up)
{
    for (bool joined = given_up != 0u; joined; joined = false) {
        eight_join(s.weight);
        eight_join(s.r);
        eight_join(s.g);
        eight_join(s.b);
        eight_join(s.x);
        eight_join(s.y);
        eight_join(s.z);
        eight_join(s.double_sided);
    }
}

struct eight_axes { eight x, y, z; };

vec4 four_squares(uvec4 x, uvec4 y, uvec4 z)
{
    vec4 a = vec4(ivec4(x)), b = vec4(ivec4(y)), c = vec4(ivec4(z));
    return a * a + b * b + c * c;
}

// Is there a cell whose normals do not agree, or nearly so?
bool four_ask(uvec4 weight, uvec4 x, uvec4 y, uvec4 z)
{
    vec4 agreed = vec4(weight) * sqrt(1.1 * float(AGREED));
    return any(lessThan(four_squares(x, y, z), agreed * agreed));
}

// Sums of the axes of normals, which take a further walk along the chain, where any of the cells needs them.
eight_axes chain_axes(uint entry, eight_sums s, uint given_up)
{
    eight_axes axes = eight_axes(EIGHT_NONE, EIGHT_NONE, EIGHT_NONE);
    bool asks = four_ask(s.weight.near, s.x.near, s.y.near, s.z.near) || four_ask(s.weight.far, s.x.far, s.y.far, s.z.far);
    for (entry = asks ? entry : KD_EMPTY; entry != KD_EMPTY;) {
        chained v = chain_load(entry);
        eight w = chain_shares(v);
        uvec3 axis = uvec3(normal_axis(snorm8_unpack(v.normal)));
        eight_add(axes.x, w, axis.x);
        eight_add(axes.y, w, axis.y);
        eight_add(axes.z, w, axis.z);
        entry = v.next;
    }
    for (bool joined = asks && given_up != 0u; joined; joined = false) {
        eight_join(axes.x);
        eight_join(axes.y);
        eight_join(axes.z);
    }
    return axes;
}

// Emission and area of cell k, packed; few parents have anything that glows.
uvec2 chain_pack_emission(uint entry, uint k, uint given_up)
{
    uint weight = 0u, emissive = 0u, area = 0u;
    uvec3 emission = uvec3(0u);
    while (entry != KD_EMPTY) {
        chained v = chain_load(entry);
        eight shares = chain_shares(v);
        uint w = given_up == 0u ? eight_of(shares, k) : eight_all(shares);
        uvec3 e = chain_emission(entry, v.normal >> 24);
        uint glows = e == uvec3(0u) ? 0u : w;
        weight += w;
        emission += (e * glows + 128u) >> 8;
        emissive += glows;
        area += share_area(v.color) * glows;
        entry = v.next;
    }
    return cell_pack_emission(weight, emission, emissive, area, given_up);
}

// PUT(k, albedo and normal) for each cell that is occupied; needs `axes` and `given_up`.
#define EIGHT_PACKED(s, half, at)                                                                                               \
    cell_pack_surface(s.weight.half.at, uvec3(s.r.half.at, s.g.half.at, s.b.half.at),                                           \
                      ivec3(s.x.half.at, s.y.half.at, s.z.half.at), ivec3(axes.x.half.at, axes.y.half.at, axes.z.half.at),      \
                      s.double_sided.half.at, given_up)
#define EIGHT_ONE(PUT, s, k, half, at)                                                                                          \
    if (s.weight.half.at != 0u) {                                                                                               \
        PUT(k, EIGHT_PACKED(s, half, at))                                                                                       \
    }
#define EIGHT_EACH(PUT, s)                                                                                                      \
    EIGHT_ONE(PUT, s, 0u, near, x) EIGHT_ONE(PUT, s, 1u, near, y) EIGHT_ONE(PUT, s, 2u, near, z) EIGHT_ONE(PUT, s, 3u, near, w) \
    EIGHT_ONE(PUT, s, 4u, far, x) EIGHT_ONE(PUT, s, 5u, far, y) EIGHT_ONE(PUT, s, 6u, far, z) EIGHT_ONE(PUT, s, 7u, far, w)
