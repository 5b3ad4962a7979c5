// Conservative (26-separating) voxelization of triangles without the rasteriser: one invocation walks one column of cells,
// along the triangle's dominant axis, under the triangle's bounding rectangle. Overlap tests after Schwarz & Seidel 2010,
// section 3.1: plane against box, then the three projections of the triangle against the box's.
// The including pass defines `void fragment(uint triangle, uvec3 cell, vec3 barycentric)`.

#include "shaders/shared/voxel.h"
#include "shaders/shared/scene.h"

layout(std140, binding = 0) uniform pass_block {
    vec4 chunk_origin; // xyz: low corner in model space, w: span in model space
    uvec4 chunk_size;  // xyz: cells, w: columns of all triangles
    uvec4 source;      // x: first index, y: base vertex, z: triangles, w: first skin vertex or KD_EMPTY
    uvec4 dest;        // x: first voxel, y: first binding, z: KD_VOXEL_*, w: bit 0 double sided, bit 1 has skin
} pass;

layout(std430, binding = 0) readonly buffer geometry_block { uint geometry[]; };
layout(std430, binding = 1) readonly buffer attributes_block { uint attributes[]; };
layout(std430, binding = 2) readonly buffer indices_block { uint indices[]; };
// Per triangle: first column | axis 2, low u 10, low v 10 | columns along u 16 | 0. One row more holds the total.
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

// Does the unit square at `low` touch the triangle, in one projection? `turn` is the sign of its winding there.
bool overlaps_2d(vec2 a, vec2 b, vec2 c, vec2 low, float turn)
{
    vec2 p[3] = vec2[3](a, b, c);
    for (int i = 0; i < 3; i++) {
        vec2 e = p[(i + 1) % 3] - p[i];
        vec2 n = vec2(-e.y, e.x) * turn;
        float d = -dot(n, p[i]) + max(0.0, n.x) + max(0.0, n.y);
        if (dot(n, low) + d < 0.0)
            return false;
    }
    return true;
}

void visit_column(uint column)
{
    uint triangle = find_triangle(column);
    uvec4 row = columns[triangle];
    uint axis = row.y & 3u, along = column - row.x;
    uint u = ((row.y >> 2) & 1023u) + along % row.z, v = ((row.y >> 12) & 1023u) + along / row.z;
    uint iu = (axis + 1u) % 3u, iv = (axis + 2u) % 3u;

    vec3 a = cell_position(vertex_of(triangle, 0u));
    vec3 b = cell_position(vertex_of(triangle, 1u));
    vec3 c = cell_position(vertex_of(triangle, 2u));
    vec3 n = cross(b - a, c - a);
    vec2 low = vec2(float(u), float(v));
    if (!overlaps_2d(vec2(a[iu], a[iv]), vec2(b[iu], b[iv]), vec2(c[iu], c[iv]), low, n[axis] < 0.0 ? -1.0 : 1.0))
        return;

    // Heights of the triangle's plane over this square, kept within the triangle's own.
    vec2 slope = -vec2(n[iu], n[iv]) / n[axis];
    float centre = a[axis] + dot(slope, low + 0.5 - vec2(a[iu], a[iv]));
    float reach = 0.5 * (abs(slope.x) + abs(slope.y));
    float from = max(centre - reach, min(a[axis], min(b[axis], c[axis])));
    float to = min(centre + reach, max(a[axis], max(b[axis], c[axis])));
    int first = max(int(floor(from)), 0), last = min(int(floor(to)), int(pass.chunk_size[axis]) - 1);
    for (int w = first; w <= last; w++) {
        float h = float(w);
        if (!overlaps_2d(vec2(a[iv], a[axis]), vec2(b[iv], b[axis]), vec2(c[iv], c[axis]), vec2(low.y, h), n[iu] < 0.0 ? -1.0 : 1.0) ||
            !overlaps_2d(vec2(a[axis], a[iu]), vec2(b[axis], b[iu]), vec2(c[axis], c[iu]), vec2(h, low.x), n[iv] < 0.0 ? -1.0 : 1.0))
            continue;
        uvec3 cell;
        cell[axis] = uint(w);
        cell[iu] = u;
        cell[iv] = v;
        fragment(triangle, cell, nearest_barycentric(vec3(cell) + 0.5, a, b, c));
    }
}

uint cell_bit(uvec3 cell)
{
    return cell.x + pass.chunk_size.x * (cell.y + pass.chunk_size.y * cell.z);
}
