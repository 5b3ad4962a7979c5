/* Triangles are cut into columns along their dominant axis, so that every GPU invocation has about the same
 * to do however large a triangle is (compare Schwarz & Seidel 2010, section 4, who bin triangles by size). */
#include "systems/voxel_cache/columns.h"

#include <math.h>
#include <stdlib.h>

#include "systems/voxel_cache/creases.h"

static kd_vec3 cell_position(const kd_voxel_chunk *chunk, kd_vec3 p)
{
    const float nudge = (float)KD_VOXELIZE_NUDGE;
    return (kd_vec3){(p.x - chunk->origin.x) / chunk->span + nudge,
                     (p.y - chunk->origin.y) / chunk->span + nudge,
                     (p.z - chunk->origin.z) / chunk->span + nudge};
}

/* Cells [low, high) that [a, b] touches, one more on each side against rounding, inside the chunk. */
static void cell_range(float a, float b, uint32_t size, uint32_t *low, uint32_t *high)
{
    float from = floorf(a) - 1.0f, to = floorf(b) + 2.0f;
    *low = from > 0 ? (from < (float)size ? (uint32_t)from : size) : 0;
    *high = to > 0 ? (to < (float)size ? (uint32_t)to : size) : 0;
    if (*high < *low)
        *high = *low;
}

static uint32_t triangle_row(const kd_voxel_chunk *chunk, const kd_vec3 p[3], uint32_t row[4])
{
    float v[3][3];
    for (int i = 0; i < 3; i++) {
        kd_vec3 c = cell_position(chunk, p[i]);
        v[i][0] = c.x, v[i][1] = c.y, v[i][2] = c.z;
    }
    kd_vec3 n = kd_vec3_cross(kd_vec3_sub(p[1], p[0]), kd_vec3_sub(p[2], p[0]));
    float a[3] = {fabsf(n.x), fabsf(n.y), fabsf(n.z)};
    uint32_t axis = a[0] >= a[1] && a[0] >= a[2] ? 0 : a[1] >= a[2] ? 1 : 2;
    if (!(a[axis] > 0))
        return 0; /* no area */
    uint32_t low[3], high[3];
    for (int k = 0; k < 3; k++)
        cell_range(fminf(v[0][k], fminf(v[1][k], v[2][k])), fmaxf(v[0][k], fmaxf(v[1][k], v[2][k])),
                   chunk->size[k], &low[k], &high[k]);
    uint32_t u = (axis + 1) % 3, w = (axis + 2) % 3;
    if (low[axis] >= high[axis])
        return 0;
    row[1] = axis | low[u] << 2 | low[w] << 12;
    row[2] = high[u] - low[u];
    return row[2] * (high[w] - low[w]);
}

kd_status columns_list(const kd_primitive_desc *primitive, const kd_voxel_chunk *chunk, bool creases,
                       kd_columns *out)
{
    uint32_t triangles = primitive->index_count / 3, kept = 0;
    uint64_t total = 0;
    uint32_t(*rows)[4] = calloc((size_t)triangles + 1, sizeof *rows);
    if (!rows)
        return KD_NO_MEMORY;
    for (uint32_t t = 0; t < triangles; t++, kept++) {
        kd_vec3 p[3];
        for (int i = 0; i < 3; i++)
            p[i] = primitive->positions[primitive->indices[3 * t + (uint32_t)i]];
        rows[kept][0] = (uint32_t)total;
        total += triangle_row(chunk, p, rows[kept]);
        if (total > INT32_MAX) {
            free(rows);
            return KD_TOO_LARGE;
        }
    }
    rows[kept][0] = (uint32_t)total;
    *out = (kd_columns){.rows = rows, .triangles = triangles, .columns = (uint32_t)total};
    kd_status status = creases && total ? creases_mark(primitive, out) : KD_OK;
    if (status)
        free(rows);
    return status;
}

/* Cells along one axis of what [a, b] has in [low, high], with the margin of cell_range. */
static float cells_along(float a, float b, float low, float high, float span)
{
    float from = fmaxf(a, low), to = fminf(b, high);
    return from <= to ? (to - from) / span + 3.0f : 0;
}

float columns_estimate(const kd_primitive_desc *primitive, const kd_voxel_cache *cache)
{
    const kd_voxel_tile *tile = &cache->tile;
    float low[3] = {-INFINITY, -INFINITY, -INFINITY}, high[3] = {INFINITY, INFINITY, INFINITY}, total = 0;
    for (int k = 0; k < 3 && tile->tiled; k++) {
        low[k] = (float)(&tile->x)[k] * tile->edge;
        high[k] = low[k] + tile->edge;
    }
    for (uint32_t t = 0; t + 2 < primitive->index_count; t += 3) {
        const kd_vec3 *p[3];
        for (uint32_t i = 0; i < 3; i++)
            p[i] = &primitive->positions[primitive->indices[t + i]];
        kd_vec3 n = kd_vec3_cross(kd_vec3_sub(*p[1], *p[0]), kd_vec3_sub(*p[2], *p[0]));
        float size[3];
        for (int k = 0; k < 3; k++) {
            float a = (&p[0]->x)[k], b = (&p[1]->x)[k], c = (&p[2]->x)[k];
            size[k] = cells_along(fminf(a, fminf(b, c)), fmaxf(a, fmaxf(b, c)), low[k], high[k], cache->span);
        }
        float a[3] = {fabsf(n.x), fabsf(n.y), fabsf(n.z)};
        int axis = a[0] >= a[1] && a[0] >= a[2] ? 0 : a[1] >= a[2] ? 1 : 2;
        if (size[axis] > 0)
            total += size[(axis + 1) % 3] * size[(axis + 2) % 3];
    }
    return total;
}
