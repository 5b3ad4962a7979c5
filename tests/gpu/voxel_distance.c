/* How far voxels are from the surface they stand for, in percent of the diagonal of its box: mean distance
 * from the centres of voxels to the mesh, which the source gives for thin voxels and whose figures are the
 * limits, and from the vertices to the nearest centre. Source: Gaitatzes & Papaioannou 2012, "Progressive
 * Screen-Space Multichannel Surface Voxelization", table 6.2 */

#include "tests/voxel_cells_fixture.h"

/* Triangles by the cells that their boxes touch. */
typedef struct bins {
    uint32_t *starts, *triangles; /* [cells + 1], [starts[cells]] */
} bins;

static kd_vec3 to_cells(const cells *c, kd_vec3 p)
{
    kd_vec3 out;
    for (int k = 0; k < 3; k++)
        (&out.x)[k] = ((&p.x)[k] - (&c->cache->phase.x)[k]) / c->cache->span - (float)c->low[k];
    return out;
}

static kd_vec3 corner_of(const cells *c, uint32_t triangle, uint32_t corner)
{
    const kd_primitive_desc *p = c->cache->desc;
    return to_cells(c, p->positions[p->indices[3 * triangle + corner]]);
}

static void range_of(const cells *c, uint32_t triangle, uint32_t low[3], uint32_t high[3])
{
    kd_vec3 v[3] = {corner_of(c, triangle, 0), corner_of(c, triangle, 1), corner_of(c, triangle, 2)};
    for (int k = 0; k < 3; k++) {
        float a = fminf((&v[0].x)[k], fminf((&v[1].x)[k], (&v[2].x)[k]));
        float b = fmaxf((&v[0].x)[k], fmaxf((&v[1].x)[k], (&v[2].x)[k]));
        low[k] = (uint32_t)fmaxf(a, 0);
        high[k] = (uint32_t)fminf(b, (float)(c->size[k] - 1));
    }
}

static bins make_bins(const cells *c)
{
    size_t count = (size_t)c->size[0] * c->size[1] * c->size[2];
    uint32_t triangles = c->cache->desc->index_count / 3;
    bins b = {calloc(count + 2, 4), NULL};
    for (int pass = 0; pass < 2; pass++) { /* count, then place; starts are one cell ahead meanwhile */
        for (uint32_t t = 0; t < triangles; t++) {
            uint32_t low[3], high[3];
            range_of(c, t, low, high);
            for (uint32_t z = low[2]; z <= high[2]; z++)
                for (uint32_t y = low[1]; y <= high[1]; y++)
                    for (uint32_t x = low[0]; x <= high[0]; x++) {
                        size_t cell = ((size_t)z * c->size[1] + y) * c->size[0] + x;
                        if (pass)
                            b.triangles[b.starts[cell + 1]++] = t;
                        else
                            b.starts[cell + 2]++;
                    }
        }
        for (size_t i = 0; i < count && !pass; i++)
            b.starts[i + 2] += b.starts[i + 1];
        if (!pass)
            b.triangles = malloc(((size_t)b.starts[count + 1] + 1) * 4);
    }
    return b;
}

/* Source: Ericson 2004, "Real-Time Collision Detection", section 5.1.5 */
static float distance_to(kd_vec3 p, kd_vec3 a, kd_vec3 b, kd_vec3 c)
{
    kd_vec3 ab = kd_vec3_sub(b, a), ac = kd_vec3_sub(c, a), ap = kd_vec3_sub(p, a);
    float d1 = kd_vec3_dot(ab, ap), d2 = kd_vec3_dot(ac, ap);
    if (d1 <= 0 && d2 <= 0)
        return kd_vec3_length(ap);
    kd_vec3 bp = kd_vec3_sub(p, b), cp = kd_vec3_sub(p, c);
    float d3 = kd_vec3_dot(ab, bp), d4 = kd_vec3_dot(ac, bp), d5 = kd_vec3_dot(ab, cp),
          d6 = kd_vec3_dot(ac, cp);
    if (d3 >= 0 && d4 <= d3)
        return kd_vec3_length(bp);
    if (d6 >= 0 && d5 <= d6)
        return kd_vec3_length(cp);
    float vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0)
        return kd_vec3_length(kd_vec3_sub(ap, kd_vec3_scale(ab, d1 / (d1 - d3))));
    if (vb <= 0 && d2 >= 0 && d6 <= 0)
        return kd_vec3_length(kd_vec3_sub(ap, kd_vec3_scale(ac, d2 / (d2 - d6))));
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return kd_vec3_length(
            kd_vec3_sub(bp, kd_vec3_scale(kd_vec3_sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6)))));
    kd_vec3 n = kd_vec3_normalize(kd_vec3_cross(ab, ac), (kd_vec3){0, 0, 0});
    return fabsf(kd_vec3_dot(n, ap));
}

/* A voxel's own cell holds a part of the surface, so the nearest lies in it or next to it. */
static float voxel_to_mesh(const cells *c, const bins *b, size_t cell)
{
    int64_t x = (int64_t)(cell % c->size[0]), y = (int64_t)(cell / c->size[0] % c->size[1]),
            z = (int64_t)(cell / ((size_t)c->size[0] * c->size[1]));
    kd_vec3 centre = {(float)x + 0.5f, (float)y + 0.5f, (float)z + 0.5f};
    float best = INFINITY;
    for (int64_t n = 0; n < 27; n++) {
        int64_t i = x + n % 3 - 1, j = y + n / 3 % 3 - 1, k = z + n / 9 - 1;
        if (i < 0 || j < 0 || k < 0 || i >= c->size[0] || j >= c->size[1] || k >= c->size[2])
            continue;
        size_t at = ((size_t)k * c->size[1] + (size_t)j) * c->size[0] + (size_t)i;
        for (uint32_t t = b->starts[at]; t < b->starts[at + 1]; t++)
            best =
                fminf(best, distance_to(centre, corner_of(c, b->triangles[t], 0),
                                        corner_of(c, b->triangles[t], 1), corner_of(c, b->triangles[t], 2)));
    }
    return best;
}

/* A point's own cell or one nearby has a voxel; thin ones leave out what is thinner than a cell. */
static float point_to_voxels(const cells *c, kd_vec3 p)
{
    float best = INFINITY;
    for (int n = 0; n < 343; n++) {
        int64_t cell[3] = {(int64_t)floorf(p.x) + n % 7 - 3, (int64_t)floorf(p.y) + n / 7 % 7 - 3,
                           (int64_t)floorf(p.z) + n / 49 - 3};
        kd_vec3 centre = {(float)cell[0] + 0.5f, (float)cell[1] + 0.5f, (float)cell[2] + 0.5f};
        bool in = true;
        for (int k = 0; k < 3; k++)
            in = in && cell[k] >= 0 && cell[k] < c->size[k];
        if (in && c->wall[((size_t)cell[2] * c->size[1] + (size_t)cell[1]) * c->size[0] + (size_t)cell[0]])
            best = fminf(best, kd_vec3_length(kd_vec3_sub(centre, p)));
    }
    return best;
}

static double mean_of_voxels(const cells *c)
{
    bins b = make_bins(c);
    double sum = 0;
    for (size_t i = 0; i < (size_t)c->size[0] * c->size[1] * c->size[2]; i++)
        if (c->wall[i])
            sum += (double)voxel_to_mesh(c, &b, i);
    free(b.starts);
    free(b.triangles);
    return sum / c->total;
}

static double mean_of_points(const cells *c)
{
    const kd_primitive_desc *p = c->cache->desc;
    double sum = 0;
    for (uint32_t i = 0; i < p->vertex_count; i++)
        sum += (double)point_to_voxels(c, to_cells(c, p->positions[i]));
    return sum / p->vertex_count;
}

/* In percent of the diagonal of the mesh's box. */
static double distance_at(const char *path, uint32_t voxels, int32_t separating)
{
    kd_model *model = fixture_asset(path);
    kd_vec3 size = kd_vec3_sub(model->bounds_max, model->bounds_min);
    float span = fmaxf(size.x, fmaxf(size.y, size.z)) / (float)voxels;
    voxel_world v = voxel_open((voxel_options){.resolution = voxels > 128 ? 256 : 128, .span = span});
    v.frame->settings.voxels_separating = separating;
    voxel_spawn(&v, model, voxel_at(0, 0, 0));
    voxel_frame(&v);
    cells c = read_cells(&v, 0);
    const kd_primitive_desc *p = c.cache->desc;
    double diagonal =
        (double)kd_vec3_length(kd_vec3_sub(p->bounds_max, p->bounds_min)) / (double)c.cache->span;
    double to_mesh = mean_of_voxels(&c), to_voxels = mean_of_points(&c);
    printf("%-18s %3u  %2d-separating  %7u voxels  to the mesh %.3f %%  to the voxels %.3f %%  (%.2f, %.2f "
           "of an edge)\n",
           path, voxels, separating, c.total, 100 * to_mesh / diagonal, 100 * to_voxels / diagonal, to_mesh,
           to_voxels);
    free_cells(&c);
    voxel_close(&v);
    return 100 * to_mesh / diagonal;
}

static void voxels_lie_near_the_surface(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        double limits[3];
    } models[] = {{"bunny/bunny.glb", {0.33, 0.17, 0.11}}, {"dragon/dragon.glb", {0.36, 0.19, 0.13}}};
    for (size_t m = 0; m < 2; m++)
        for (uint32_t i = 0; i < 3; i++) {
            assert_true(distance_at(models[m].path, 64u << i, 6) <= models[m].limits[i]);
            distance_at(models[m].path, 64u << i, 26);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(voxels_lie_near_the_surface)};
    return VOXEL_GROUP(tests);
}
