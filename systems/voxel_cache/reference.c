/* The voxelizer's question, answered exactly: which cells does a triangle touch? Tests compare the compute
 * pass with it. */
#include "systems/voxel_cache/reference.h"

#include <math.h>

/* Does the axis keep triangle and box apart? `half` is the box's half extent; the triangle is relative to its
 * centre. */
static bool separates(const double axis[3], double t[3][3], const double half[3])
{
    double low = INFINITY, high = -INFINITY, reach = 0;
    for (int v = 0; v < 3; v++) {
        double d = axis[0] * t[v][0] + axis[1] * t[v][1] + axis[2] * t[v][2];
        low = d < low ? d : low;
        high = d > high ? d : high;
    }
    for (int k = 0; k < 3; k++)
        reach += half[k] * fabs(axis[k]);
    return low > reach || high < -reach;
}

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

bool voxel_reference_touches(const double triangle[3][3], const double low[3], const double high[3])
{
    double t[3][3], half[3], edge[3][3], normal[3], axis[3];
    for (int k = 0; k < 3; k++) {
        half[k] = 0.5 * (high[k] - low[k]);
        for (int v = 0; v < 3; v++)
            t[v][k] = triangle[v][k] - 0.5 * (low[k] + high[k]);
    }
    for (int v = 0; v < 3; v++)
        for (int k = 0; k < 3; k++)
            edge[v][k] = t[(v + 1) % 3][k] - t[v][k];
    cross(edge[0], edge[1], normal);
    if (separates(normal, t, half))
        return false;
    for (int k = 0; k < 3; k++) {
        const double unit[3] = {k == 0, k == 1, k == 2};
        if (separates(unit, t, half))
            return false;
        for (int v = 0; v < 3; v++) {
            cross(unit, edge[v], axis);
            if (separates(axis, t, half))
                return false;
        }
    }
    return true;
}
