// Area of a triangle's part inside a cell, in faces of it: cut by the cell's six planes, one after the other
// (Sutherland and Hodgman 1974).

vec3 corners_in[9], corners_out[9];

int cut(int count, int axis, float limit, float side)
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        vec3 p = corners_in[i], q = corners_in[i + 1 < count ? i + 1 : 0];
        float dp = side * (p[axis] - limit), dq = side * (q[axis] - limit);
        if (dp >= 0.0)
            corners_out[kept++] = p;
        if ((dp >= 0.0) != (dq >= 0.0))
            corners_out[kept++] = mix(p, q, dp / (dp - dq));
    }
    for (int i = 0; i < kept; i++)
        corners_in[i] = corners_out[i];
    return kept;
}

float area_in_cell(uvec3 cell, uint triangle)
{
    for (uint k = 0u; k < 3u; k++)
        corners_in[k] = cell_position(vertex_of(triangle, k)) - vec3(cell);
    int count = 3;
    for (int axis = 0; axis < 3; axis++) {
        count = cut(count, axis, 0.0, 1.0);
        count = cut(count, axis, 1.0, -1.0);
    }
    vec3 twice = vec3(0.0);
    for (int i = 2; i < count; i++)
        twice += cross(corners_in[i - 1] - corners_in[0], corners_in[i] - corners_in[0]);
    return 0.5 * length(twice);
}
