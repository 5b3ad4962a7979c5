/* What a flying camera will need: the cascades are placed as in each of the next frames, and caches that are
 * missing there are asked for, with the number of frames that are left. System voxel_cache spreads the work
 * over these frames. A camera that stands costs nothing. */
#include "systems/voxel_pages/ahead.h"

#include <string.h>

#include "systems/voxel_pages/placement.h"
#include "systems/voxel_pages/tiles.h"

#define AHEAD_FRAMES 24

typedef struct looking {
    voxel_objects *table;
    kd_voxel_scene *scene;
    int32_t cells[KD_MAX_CASCADES][3]; /* where the cascades will stand */
    uint32_t frames;                   /* when */
} looking;

static kd_status want_object(looking *l, kd_voxel_object *o)
{
    kd_status status = KD_OK;
    for (uint32_t c = 0; c < l->scene->cascade_count && !status; c++) {
        uint32_t bit = 1u << c;
        if (!(o->cascades & bit) || o->caches[c] || o->ahead & bit ||
            !placement_would_include(l->scene, l->cells, c, o->bounds_min_ws, o->bounds_max_ws))
            continue;
        o->ahead |= bit;
        status = caches_want_ahead(&l->table->caches, l->scene, o, c, l->frames);
    }
    return status;
}

static kd_status want_tile(void *user, const voxel_sight *sight, uint32_t c)
{
    looking *l = user;
    const kd_voxel_object tile = {.entity = sight->entity,
                                  .primitive = sight->primitive,
                                  .material = sight->material,
                                  .desc = sight->desc,
                                  .kind = sight->kind,
                                  .dynamic = sight->dynamic,
                                  .model_ws = sight->model_ws,
                                  .cached_scale = sight->scale,
                                  .tile = sight->tile};
    return caches_want_ahead(&l->table->caches, l->scene, &tile, c, l->frames);
}

static kd_status want_frame(looking *l)
{
    kd_status status = KD_OK;
    for (uint32_t i = 0; i < l->scene->object_count && !status; i++) {
        kd_voxel_object *o = &l->scene->objects[i];
        if (!o->alive || !o->seen || o->tile.tiled)
            continue;
        status = want_object(l, o);
        if (!status)
            status = tiles_visit(l->scene, o, l->cells, want_tile, l);
    }
    return status;
}

void ahead_begin(voxel_objects *table, const kd_voxel_scene *scene, kd_vec3 focus)
{
    float reach = (float)scene->resolution * scene->span[scene->cascade_count - 1], length;
    table->step = table->focused ? kd_vec3_sub(focus, table->focus) : (kd_vec3){0, 0, 0};
    table->focus = focus;
    table->focused = true;
    length = kd_vec3_length(table->step);
    table->ahead_frames = length > 0 && !scene->want_all ? AHEAD_FRAMES : 0;
    /* no further than the outermost cascade reaches: who goes faster than that jumps */
    while (table->ahead_frames && length * (float)table->ahead_frames > reach)
        table->ahead_frames--;
}

kd_vec3 ahead_way(const voxel_objects *table)
{
    return kd_vec3_scale(table->step, (float)table->ahead_frames);
}

kd_status ahead_want(voxel_objects *table, kd_voxel_scene *scene, const kd_box *bounds)
{
    if (!table->ahead_frames)
        return KD_OK;
    for (uint32_t i = 0; i < scene->object_count; i++)
        scene->objects[i].ahead = 0;
    looking l = {.table = table, .scene = scene};
    int32_t before[KD_MAX_CASCADES][3];
    const size_t size = scene->cascade_count * sizeof *before;
    kd_status status = KD_OK;
    memcpy(before, scene->origin_cells, sizeof before);
    for (l.frames = 1; l.frames <= table->ahead_frames && !status; l.frames++) {
        kd_vec3 there = kd_vec3_add(table->focus, kd_vec3_scale(table->step, (float)l.frames));
        placement_cells(scene, there, bounds->low, bounds->high, l.cells);
        if (memcmp(l.cells, before, size) != 0)
            status = want_frame(&l);
        memcpy(before, l.cells, size);
    }
    return status;
}
