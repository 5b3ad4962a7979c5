// Conservative (26-separating) or thin voxelization of triangles without the rasteriser: one invocation walks one column of cells,
// along the triangle's dominant axis, under the triangle's bounding rectangle. Overlap tests after Schwarz & Seidel 2010,
// section 3.1: bounds against box, plane against box, then the three projections of the triangle against the box's.
// The including pass defines `void fragment(uint triangle, uvec3 cell, vec3 barycentric)` and, for thin voxelization, which of
// the cells that triangle (a, b, c) touches it keeps: `bool keeps_cell(uvec3 cell, uint creases, vec3 a, vec3 b, vec3 c)`.

#include "shaders/shared/voxel.h"
#include "shaders/shared/scene.h"

layout(std140, binding = 0) uniform pass_block {
    vec4 chunk_origin; // xyz: low corner in model space, w: span in model space
    uvec4 chunk_size;  // xyz: cells, w: columns of all triangles
    uvec4 source;      // x: first index, y: base vertex, z: triangles, w: first skin vertex or KD_EMPTY
    uvec4 dest;        // x: first voxel, y: first binding, z: KD_VOXEL_*, w: bit 0 double sided, bit 1 thin, bit 2 lone cells
} pass;

layout(std430, binding = 0) readonly buffer geometry_block { uint geometry[]; };
layout(std430, binding = 1) readonly buffer attributes_block { uint attributes[]; };
layout(std430, binding = 2) readonly buffer indices_block { uint indices[]; };
// Per triangle: first column | axis 2, low u 10, low v 10 | columns along u 16 | creases. One row more holds the total.
layout(std430, binding = 3) readonly buffer columns_block { uvec4 columns[]; };

#include "shaders/include/triangle_point.glsl"

uint vertex_of(uint triangle, uint corner)
{
    return pass.source.y + indices[pass.source.x + triangle * 3u + corner];
}

vec3 position_of(uint vertex)
{
    uint at = vertex * uint(KD_GEOMETRY_WORDS);
    return uintBitsToFloat(uvec3(geometry[at], geometry[at + 1u], geometry[at + 2u]));
}

// Position in cells of the chunk. The nudge decides planes that lie on a cell border: they belong to one side, not to
// both. The CPU, which lists the columns, adds the same.
vec3 cell_position(uint vertex)
{
    return (position_of(vertex) - pass.chunk_origin.xyz) / pass.chunk_origin.w + KD_VOXELIZE_NUDGE;
}

uint find_triangle(uint column)
{
    uint low = 0u, high = pass.source.z;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (columns[middle].x <= column)
            low = middle;
        else
            high = middle;
    }
    return low;
}

// Is this row of cells within the triangle's bounds? Edges alone would let cells beyond a sharp corner pass.
bool in_bounds(float a, float b, float c, float low)
{
    return floor(min(a, min(b, c))) <= low && low <= floor(max(a, max(b, c)));
}

// Does the unit square at `low` touch the triangle, in one projection? `turn` is the sign of its winding there.
bool beside_edge(vec2 p, vec2 q, vec2 low, float turn)
{
    vec2 n = vec2(p.y - q.y, q.x - p.x) * turn;
    return dot(n, low - p) + max(0.0, n.x) + max(0.0, n.y) < 0.0;
}

bool overlaps_2d(vec2 a, vec2 b, vec2 c, vec2 low, float normal)
{
    float turn = normal < 0.0 ? -1.0 : 1.0;
    return !beside_edge(a, b, low, turn) && !beside_edge(b, c, low, turn) && !beside_edge(c, a, low, turn);
}

// Coordinates (u, v, along the dominant axis) of a vector, and back.
vec3 to_column(vec3 v, uint axis) { return axis == 0u ? v.yzx : axis == 1u ? v.zxy : v; }
vec3 from_column(vec3 v, uint axis) { return axis == 0u ? v.zxy : axis == 1u ? v.yzx : v; }

void visit_column(uint column)
{
    uint triangle = find_triangle(column);
    uvec4 row = columns[triangle];
    uint axis = row.y & 3u, along = column - row.x;
    vec2 low = vec2(((row.y >> 2) & 1023u) + along % row.z, ((row.y >> 12) & 1023u) + along / row.z);

    vec3 p = cell_position(vertex_of(triangle, 0u)), q = cell_position(vertex_of(triangle, 1u));
    vec3 r = cell_position(vertex_of(triangle, 2u));
    vec3 a = to_column(p, axis), b = to_column(q, axis), c = to_column(r, axis);
    vec3 n = cross(b - a, c - a);
    if (!in_bounds(a.x, b.x, c.x, low.x) || !in_bounds(a.y, b.y, c.y, low.y))
        return;
    if (!overlaps_2d(a.xy, b.xy, c.xy, low, n.z))
        return;

    // Heights of the triangle's plane over this square, kept within the triangle's own.
    vec2 slope = -n.xy / n.z;
    float centre = a.z + dot(slope, low + 0.5 - a.xy);
    float reach = 0.5 * (abs(slope.x) + abs(slope.y));
    float from = max(centre - reach, min(a.z, min(b.z, c.z)));
    float to = min(centre + reach, max(a.z, max(b.z, c.z)));
    float top = to_column(vec3(pass.chunk_size.xyz), axis).z - 1.0;
    for (float h = max(floor(from), 0.0); h <= min(floor(to), top); h++) {
        if (!overlaps_2d(a.yz, b.yz, c.yz, vec2(low.y, h), n.x) || !overlaps_2d(a.zx, b.zx, c.zx, vec2(h, low.x), n.y))
            continue;
        vec3 cell = from_column(vec3(low, h), axis);
        if ((pass.dest.w & 2u) != 0u && !keeps_cell(uvec3(cell), row.w, p, q, r))
            continue;
        fragment(triangle, uvec3(cell), nearest_barycentric(cell + 0.5, p, q, r));
    }
}
