// Which of the cells that a triangle touches a thin voxelization takes, in cells of the chunk.

// Does the point lie under the triangle, in one projection? Points on an edge belong to both sides: `slack` of a cell
// outweighs the rounding by which two triangles could both miss it.
bool covers_2d(vec2 a, vec2 b, vec2 c, vec2 point, float normal)
{
    const float slack = 1e-4;
    float turn = normal < 0.0 ? -1.0 : 1.0;
    vec2 ab = b - a, bc = c - b, ca = a - c;
    return turn * (ab.x * (point.y - a.y) - ab.y * (point.x - a.x)) >= -slack * length(ab) &&
           turn * (bc.x * (point.y - b.y) - bc.y * (point.x - b.x)) >= -slack * length(bc) &&
           turn * (ca.x * (point.y - c.y) - ca.y * (point.x - c.x)) >= -slack * length(ca);
}

bool cuts_axis(vec3 centre, vec3 a, vec3 b, vec3 c, vec3 n)
{
    if (abs(n.z) < 1e-6 * (abs(n.x) + abs(n.y)) || !covers_2d(a.xy, b.xy, c.xy, centre.xy, n.z))
        return false;
    return abs(a.z - dot(n.xy, centre.xy - a.xy) / n.z - centre.z) <= 0.5;
}

// Thin (6-separating) voxelization: a cell counts when the triangle cuts one of the three unit segments through its centre.
// Source: Laine 2013, "A Topological Approach to Voxelization", section 4.
bool cuts_crosshair(vec3 centre, vec3 a, vec3 b, vec3 c)
{
    vec3 n = cross(b - a, c - a);
    return cuts_axis(centre, a, b, c, n) || cuts_axis(centre.yzx, a.yzx, b.yzx, c.yzx, n.yzx) ||
           cuts_axis(centre.zxy, a.zxy, b.zxy, c.zxy, n.zxy);
}

// Does the segment go through the cell? Source: Kay & Kajiya 1986, slabs
bool passes_cell(vec3 low, vec3 p, vec3 q)
{
    vec3 d = q - p, still = vec3(lessThan(abs(d), vec3(1e-12)));
    vec3 along = mix(d, vec3(1e-12), still);
    vec3 a = (low - p) / along, b = (low + 1.0 - p) / along;
    vec3 near = min(a, b), far = max(a, b);
    return max(max(near.x, near.y), max(near.z, 0.0)) <= min(min(far.x, far.y), min(far.z, 1.0));
}

// Where a surface bends sharply or ends, a thin voxelization leaves out cells beyond the last crosshairs, of which the corners
// of a box are made: the sides of the triangle on the list of creases bring them back.
bool holds_crease(vec3 low, uint creases, vec3 a, vec3 b, vec3 c)
{
    return ((creases & 1u) != 0u && passes_cell(low, a, b)) || ((creases & 2u) != 0u && passes_cell(low, b, c)) ||
           ((creases & 4u) != 0u && passes_cell(low, c, a));
}
