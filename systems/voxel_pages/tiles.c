/* A ground plane of a kilometre has 2.5 thousand million voxels of 2 cm, and a cascade of 128 cells needs
 * sixteen thousand of them. So what is many times as large as a cascade is voxelized tile by tile, half a
 * cascade wide each, when a cascade comes near; every tile is a voxel object of its own. */
#include "systems/voxel_pages/tiles.h"

#include <math.h>

#include "systems/voxel_pages/placement.h"

/* A primitive is cut in a cascade when it is longer than this many edges of it. */
#define WHOLE_EDGES 4

/* More tiles of one primitive in one cascade mean a degenerate matrix; the nearest to the low corner are
 * taken. */
#define MOST_TILES 512

static float longest(kd_vec3 v)
{
    return fmaxf(v.x, fmaxf(v.y, v.z));
}

uint32_t tiles_whole(const kd_voxel_scene *scene, const voxel_sight *s)
{
    uint32_t all = (1u << scene->cascade_count) - 1, whole = 0;
    if (s->kind != KD_VOXEL_RIGID)
        return all;
    float size = longest(kd_vec3_sub(s->desc->bounds_max, s->desc->bounds_min)) * s->scale;
    for (uint32_t c = 0; c < scene->cascade_count; c++)
        if (size <= WHOLE_EDGES * (float)scene->resolution * scene->span[c])
            whole |= 1u << c;
    return whole;
}

/* Axis-aligned bounds of a transformed box. */
static void transform_box(const kd_mat4 *m, kd_vec3 low, kd_vec3 high, kd_vec3 *out_low, kd_vec3 *out_high)
{
    kd_vec3 a = {INFINITY, INFINITY, INFINITY}, b = {-INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 8; i++) {
        kd_vec3 p = kd_mat4_point(
            m, (kd_vec3){i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z});
        a = (kd_vec3){fminf(a.x, p.x), fminf(a.y, p.y), fminf(a.z, p.z)};
        b = (kd_vec3){fmaxf(b.x, p.x), fmaxf(b.y, p.y), fmaxf(b.z, p.z)};
    }
    *out_low = a;
    *out_high = b;
}

/* Tiles [first, last] on each axis that hold both the primitive and the cascade's grid. */
typedef struct tile_range {
    int32_t first[3], last[3];
} tile_range;

static bool range_of(const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c,
                     const int32_t cells[3], float edge, tile_range *out)
{
    float span = scene->span[c], grid = (float)scene->resolution * span, margin = 2 * span;
    kd_vec3 low = {(float)cells[0] * span - margin, (float)cells[1] * span - margin,
                   (float)cells[2] * span - margin};
    kd_vec3 high = kd_vec3_add(low, (kd_vec3){grid + 2 * margin, grid + 2 * margin, grid + 2 * margin});
    kd_mat4 inverse = kd_mat4_inverse(&o->model_ws);
    transform_box(&inverse, low, high, &low, &high);
    const float *l = &low.x, *h = &high.x, *a = &o->desc->bounds_min.x, *b = &o->desc->bounds_max.x;
    for (int k = 0; k < 3; k++) {
        float from = fmaxf(l[k], a[k]), to = fminf(h[k], b[k]);
        if (!(from <= to) || fabsf(from) > 1e9f * edge || fabsf(to) > 1e9f * edge)
            return false;
        out->first[k] = (int32_t)floorf(from / edge);
        out->last[k] = (int32_t)floorf(to / edge);
    }
    return true;
}

/* A tile of an object, as it is seen. */
static voxel_sight sight_of_tile(const kd_voxel_object *o, uint32_t c, kd_voxel_tile tile)
{
    kd_vec3 low = {(float)tile.x * tile.edge, (float)tile.y * tile.edge, (float)tile.z * tile.edge};
    kd_vec3 high = kd_vec3_add(low, (kd_vec3){tile.edge, tile.edge, tile.edge});
    const kd_vec3 *a = &o->desc->bounds_min, *b = &o->desc->bounds_max;
    low = (kd_vec3){fmaxf(low.x, a->x), fmaxf(low.y, a->y), fmaxf(low.z, a->z)};
    high = (kd_vec3){fminf(high.x, b->x), fminf(high.y, b->y), fminf(high.z, b->z)};
    voxel_sight s = {.entity = o->entity,
                     .draw_primitive = o->draw_primitive,
                     .primitive = o->primitive,
                     .kind = o->kind,
                     .material = o->material,
                     .desc = o->desc,
                     .model_ws = o->model_ws,
                     .scale = o->cached_scale,
                     .tile = tile,
                     .cascades = 1u << c,
                     .dynamic = o->dynamic || o->becomes_dynamic};
    transform_box(&o->model_ws, low, high, &s.bounds_min_ws, &s.bounds_max_ws);
    return s;
}

static kd_status visit_cascade(const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c,
                               int32_t cells[KD_MAX_CASCADES][3], tile_fn *fn, void *user)
{
    float edge = 0.5f * (float)scene->resolution * scene->span[c] / o->cached_scale;
    tile_range r;
    if (!range_of(scene, o, c, cells[c], edge, &r))
        return KD_OK;
    kd_status status = KD_OK;
    uint32_t count = 0;
    for (int32_t z = r.first[2]; z <= r.last[2] && !status; z++)
        for (int32_t y = r.first[1]; y <= r.last[1] && !status; y++)
            for (int32_t x = r.first[0]; x <= r.last[0] && !status && count < MOST_TILES; x++, count++) {
                voxel_sight s = sight_of_tile(o, c, (kd_voxel_tile){true, x, y, z, edge});
                if (placement_would_include(scene, cells, c, s.bounds_min_ws, s.bounds_max_ws))
                    status = fn(user, &s, c);
            }
    return status;
}

kd_status tiles_visit(const kd_voxel_scene *scene, const kd_voxel_object *o,
                      int32_t cells[KD_MAX_CASCADES][3], tile_fn *fn, void *user)
{
    kd_status status = KD_OK;
    for (uint32_t c = 0; c < scene->cascade_count && !status; c++)
        if (!o->tile.tiled && !(o->cascades >> c & 1u))
            status = visit_cascade(scene, o, c, cells, fn, user);
    return status;
}

typedef struct seeing {
    voxel_objects *table;
    kd_voxel_scene *scene;
} seeing;

static kd_status see_tile(void *user, const voxel_sight *tile, uint32_t c)
{
    const seeing *s = user;
    (void)c;
    return objects_see(s->table, s->scene, tile);
}

kd_status tiles_see(voxel_objects *table, kd_voxel_scene *scene)
{
    uint32_t all = (1u << scene->cascade_count) - 1, count = scene->object_count;
    seeing s = {table, scene};
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        kd_voxel_object o = scene->objects[i]; /* a copy: entering tiles may move the table */
        if (o.alive && o.seen && !o.tile.tiled && o.cascades != all)
            status = tiles_visit(scene, &o, scene->origin_cells, see_tile, &s);
    }
    return status;
}
