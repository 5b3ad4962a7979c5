#include "systems/voxel_pages/placement.h"

#include <math.h>
#include <string.h>

/* Where the finest cascade's centre goes on one axis, in whole steps: towards the focus, but without looking
 * past the scene's ends, which are held whole when it is there. */
static float centre_on_axis(float focus, float low, float high, float half, float snap)
{
    const float least = (high - half) / snap - 1e-3f, most = (low + half) / snap + 1e-3f; /* to hold an end */
    if (!(high > low) || high - low <= 2 * half)
        return floorf((high >= low ? 0.5f * (low + high) : focus) / snap + 0.5f) * snap;
    if (focus >= high - half)
        return ceilf(least) * snap;
    return (focus <= low + half ? floorf(most) : floorf(focus / snap + 0.5f)) * snap;
}

void placement_cells(const kd_voxel_scene *scene, kd_vec3 focus, kd_vec3 bounds_min, kd_vec3 bounds_max,
                     int32_t cells[KD_MAX_CASCADES][3])
{
    float half = 0.5f * (float)scene->resolution * scene->span[0];
    float snap = scene->span[scene->cascade_count - 1] * (float)(scene->resolution / KD_DENSE);
    const float *f = &focus.x, *low = &bounds_min.x, *high = &bounds_max.x;
    for (int k = 0; k < 3; k++) {
        float snapped = centre_on_axis(f[k], low[k], high[k], half, snap);
        for (uint32_t c = 0; c < scene->cascade_count; c++) /* whole, so that the lattice stays the same */
            cells[c][k] = (int32_t)(floorf(snapped / scene->span[c] + 0.5f) - (float)(scene->resolution / 2));
    }
}

/* Low corner of cascade c whose first cell is given. */
static kd_vec3 corner(const kd_voxel_scene *scene, int32_t cells[][3], uint32_t c)
{
    const float span = scene->span[c];
    return (kd_vec3){(float)cells[c][0] * span, (float)cells[c][1] * span, (float)cells[c][2] * span};
}

void placement_update(kd_voxel_scene *scene, kd_vec3 focus, kd_vec3 bounds_min, kd_vec3 bounds_max)
{
    memcpy(scene->previous_cells, scene->origin_cells, sizeof scene->previous_cells);
    placement_cells(scene, focus, bounds_min, bounds_max, scene->origin_cells);
    scene->moved = memcmp(scene->previous_cells, scene->origin_cells,
                          scene->cascade_count * sizeof *scene->origin_cells) != 0;
    for (uint32_t c = 0; c < scene->cascade_count; c++)
        scene->origin_ws[c] = corner(scene, scene->origin_cells, c);
}

static bool inside(kd_vec3 low, kd_vec3 high, kd_vec3 box_low, float edge, float margin)
{
    return low.x >= box_low.x + margin && low.y >= box_low.y + margin && low.z >= box_low.z + margin &&
           high.x <= box_low.x + edge - margin && high.y <= box_low.y + edge - margin &&
           high.z <= box_low.z + edge - margin;
}

static bool outside(kd_vec3 low, kd_vec3 high, kd_vec3 box_low, float edge)
{
    return high.x < box_low.x || high.y < box_low.y || high.z < box_low.z || low.x > box_low.x + edge ||
           low.y > box_low.y + edge || low.z > box_low.z + edge;
}

/* Whether a box takes part in cascade c while the cascades stand at `origins`. */
static bool takes_part(const kd_voxel_scene *scene, const kd_vec3 *origins, uint32_t c, kd_vec3 low,
                       kd_vec3 high)
{
    float resolution = (float)scene->resolution, margin = 2 * scene->span[c];
    kd_vec3 grown = {margin, margin, margin};
    if (outside(kd_vec3_sub(low, grown), kd_vec3_add(high, grown), origins[c], resolution * scene->span[c]))
        return false;
    return c == 0 || !inside(low, high, origins[c - 1], resolution * scene->span[c - 1], margin);
}

bool placement_includes(const kd_voxel_scene *scene, uint32_t c, kd_vec3 low, kd_vec3 high)
{
    return takes_part(scene, scene->origin_ws, c, low, high);
}

bool placement_would_include(const kd_voxel_scene *scene, int32_t cells[][3], uint32_t c, kd_vec3 low,
                             kd_vec3 high)
{
    kd_vec3 origins[KD_MAX_CASCADES];
    for (uint32_t i = c > 0 ? c - 1 : 0; i <= c; i++)
        origins[i] = corner(scene, cells, i);
    return takes_part(scene, origins, c, low, high);
}

bool placement_included(const kd_voxel_scene *scene, uint32_t c, kd_vec3 low, kd_vec3 high)
{
    int32_t before[KD_MAX_CASCADES][3];
    memcpy(before, scene->previous_cells, sizeof before);
    return scene->placed && placement_would_include(scene, before, c, low, high);
}
