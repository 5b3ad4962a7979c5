/* System voxel_objects: once a frame, on the CPU, places the cascades, enters what the draw list shows near
 * them into the table of voxel objects, decides layer and cascades of each, and asks for the caches that are
 * missing.
 */
#include "systems/voxel_pages/voxel_pages.h"

#include <math.h>
#include <stdlib.h>

#include "components/camera.h"
#include "components/frame.h"
#include "components/transform.h"
#include "runtime/asset/voxel_file.h"
#include "runtime/core/log.h"
#include "systems/voxel_pages/ahead.h"
#include "systems/voxel_pages/objects.h"
#include "systems/voxel_pages/placement.h"
#include "systems/voxel_pages/tiles.h"

/* Part of the finest cascade's half extent by which its centre goes ahead of the camera: what lies behind the
 * viewer needs fewer fine voxels than what is in front. */
#define AHEAD 0.5f

/* Skin stretches where limbs bend, and the distances of its voxels with it: those of deforming meshes are cut
 * this much finer, so that they still meet. Crouching to jump opens a walker's hips without this, and no
 * longer from 1.25 on. */
#define STRETCH 1.25f

/* Joints that draw skin out by more than this against their mean stretch are mistakes of a file. Following
 * them would fill memory with voxels: a cache has its square as many. */
#define MOST_UNEVEN 3.0f

static uint32_t log2_of(uint32_t v)
{
    uint32_t l = 0;
    while ((1u << l) < v)
        l++;
    return l;
}

static void apply_settings(kd_voxel_scene *scene, const kd_settings *settings)
{
    if (scene->resolution)
        return; /* for good: buffers and caches follow from them */
    scene->cascade_count = (uint32_t)settings->voxels_cascades;
    scene->resolution = (uint32_t)settings->voxels_resolution;
    scene->resolution_log2 = log2_of(scene->resolution);
    scene->span_m = settings->voxels_span;
    scene->voxelize_flags = (settings->voxels_separating == 6 ? KD_VOXEL_LEVEL_THIN : 0) |
                            (settings->voxels_fill ? KD_VOXEL_LEVEL_FILLED : 0) |
                            (settings->voxels_binding == KD_BINDING_GEODESIC ? KD_VOXEL_LEVEL_GEODESIC : 0);
    scene->build = (uint32_t)settings->svo_build;
    scene->one_layer = settings->svo_layers == KD_SVO_LAYERS_ONE || scene->build != KD_SVO_BUILD_ORDERFREE;
    for (uint32_t c = 0; c < scene->cascade_count; c++)
        scene->span[c] = scene->span_m * (float)(1u << c);
}

/* Voxels of a cache stand one span apart: the map that brings them to the world must not draw them further
 * apart than that along any direction, sheared or not. */
static float largest_scale(const kd_mat4 *m)
{
    return kd_mat3_stretch((kd_vec3){m->m[0], m->m[1], m->m[2]}, (kd_vec3){m->m[4], m->m[5], m->m[6]},
                           (kd_vec3){m->m[8], m->m[9], m->m[10]});
}

/* The mean stretch of a matrix's rows, by the volume that it makes of one. */
static float mean_scale(const kd_vec4 *r)
{
    kd_vec3 a = {r[0].x, r[0].y, r[0].z}, b = {r[1].x, r[1].y, r[1].z}, c = {r[2].x, r[2].y, r[2].z};
    return cbrtf(fabsf(kd_vec3_dot(a, kd_vec3_cross(b, c))));
}

/* Skinned vertices go from model space to the world through joints: the one that stretches most counts. */
static float skin_scale(const kd_joint_palette *palette, const kd_skin_instance *skin, uint32_t joints)
{
    float best = 0, mean = 0;
    for (uint32_t j = 0; j < joints && skin->first_matrix + j < palette->count; j++) {
        const kd_vec4 *r = palette->rows[skin->first_matrix + j];
        best =
            fmaxf(best, kd_mat3_stretch((kd_vec3){r[0].x, r[0].y, r[0].z}, (kd_vec3){r[1].x, r[1].y, r[1].z},
                                        (kd_vec3){r[2].x, r[2].y, r[2].z}));
        mean = fmaxf(mean, mean_scale(r));
    }
    return fminf(best, MOST_UNEVEN * mean);
}

static voxel_sight sight_of(kd_world *w, const kd_scene_store *store, const kd_draw *draw,
                            const kd_mesh_instance *mi)
{
    const kd_store_mesh *mesh = &store->meshes[mi->mesh];
    const kd_store_deformed *deformed = draw->deformed ? &store->deformed[mi->deformed - 1] : NULL;
    uint32_t local = draw->primitive - (deformed ? deformed->first_primitive : mesh->first_primitive);
    const kd_skin_instance *skin = kd_find(w, draw->entity, kd_skin_instance);
    voxel_sight s = {.entity = draw->entity,
                     .draw_primitive = draw->primitive,
                     .primitive = mesh->first_primitive + local,
                     .deformed = deformed ? draw->primitive + 1 : 0,
                     .kind = !deformed                                         ? KD_VOXEL_RIGID
                             : skin && mesh->skinned && mesh->morph_count == 0 ? KD_VOXEL_SKINNED
                                                                               : KD_VOXEL_ATTACHED,
                     .desc = &mesh->desc->primitives[local],
                     .model_ws = KD_MAT4_IDENTITY,
                     .dynamic = draw->moved,
                     .bounds_min_ws = draw->bounds_min_ws,
                     .bounds_max_ws = draw->bounds_max_ws};
    s.material = mi->material ? mi->material - 1 : store->primitives[s.primitive].material;
    if (s.material >= store->material_count)
        s.material = 0;                      /* as the draw list has it */
    if (deformed && skin && mesh->skinned) { /* deformed into the world already, morphing or not */
        s.first_matrix = skin->first_matrix;
        s.scale = STRETCH *
                  skin_scale(kd_singleton(w, kd_joint_palette), skin, store->skins[skin->skin].joint_count);
        return s;
    }
    const kd_world_transform *world = kd_find(w, draw->entity, kd_world_transform);
    if (world)
        s.model_ws = world->matrix;
    s.scale = largest_scale(&s.model_ws) * (s.kind == KD_VOXEL_ATTACHED ? STRETCH : 1.0f);
    return s;
}

/* What a matrix flattens to a line has no surface left: it neither glows nor hides anything. */
static bool has_area(const voxel_sight *s)
{
    if (s->kind != KD_VOXEL_RIGID)
        return true;
    const float *m = s->model_ws.m;
    kd_vec3 size = kd_vec3_sub(s->desc->bounds_max, s->desc->bounds_min);
    kd_vec3 a = kd_vec3_scale((kd_vec3){m[0], m[1], m[2]}, size.x),
            b = kd_vec3_scale((kd_vec3){m[4], m[5], m[6]}, size.y),
            c = kd_vec3_scale((kd_vec3){m[8], m[9], m[10]}, size.z);
    float longest = fmaxf(kd_vec3_length(a), fmaxf(kd_vec3_length(b), kd_vec3_length(c)));
    float largest = fmaxf(kd_vec3_length(kd_vec3_cross(a, b)),
                          fmaxf(kd_vec3_length(kd_vec3_cross(b, c)), kd_vec3_length(kd_vec3_cross(c, a))));
    return largest > 1e-6f * longest * longest;
}

static bool usable(const voxel_sight *s)
{
    return has_area(s) && s->desc->index_count && isfinite(s->scale) && s->scale > 1e-6f &&
           isfinite(s->bounds_min_ws.x + s->bounds_max_ws.x);
}

/* Numbers of the draws that may stand in a cascade, now or in the frames that are looked ahead. */
static const uint32_t *find_near(voxel_objects *table, const kd_voxel_scene *scene, const kd_draw_list *list,
                                 bool all, uint32_t *count)
{
    *count = 0;
    if (table->near_capacity < list->draw_count) {
        uint32_t capacity = list->draw_count + list->draw_count / 2;
        uint32_t *grown = realloc(table->near, 2 * (size_t)capacity * sizeof *grown);
        if (!grown)
            return NULL;
        table->near = grown;
        table->near_capacity = capacity;
    }
    if (!list->tree || !list->draw_count)
        return table->near;
    uint32_t outer = scene->cascade_count - 1;
    float edge = (float)scene->resolution * scene->span[outer], margin = 2 * scene->span[outer];
    kd_vec3 low = scene->origin_ws[outer], way = ahead_way(table);
    kd_box near = {low, {low.x + edge, low.y + edge, low.z + edge}};
    for (int k = 0; k < 3; k++) {
        (&near.low.x)[k] += fminf((&way.x)[k], 0) - margin;
        (&near.high.x)[k] += fmaxf((&way.x)[k], 0) + margin;
    }
    if (all)
        near = kd_box_tree_all(list->tree);
    *count = kd_box_tree_in_box(list->tree, &near, table->near);
    return table->near;
}

static kd_status see_draw(kd_world *w, voxel_objects *table, kd_voxel_scene *scene, const kd_draw *draw)
{
    const kd_mesh_instance *mi = kd_find(w, draw->entity, kd_mesh_instance);
    if (!mi || mi->no_voxels)
        return KD_OK;
    voxel_sight s = sight_of(w, kd_singleton(w, kd_scene_store), draw, mi);
    s.cascades = scene->want_all ? (1u << scene->cascade_count) - 1 : tiles_whole(scene, &s);
    return usable(&s) ? objects_see(table, scene, &s) : KD_OK;
}

/* What is farther than all cascades has no part in this system, whatever the size of the scene; but what
 * deforms is followed everywhere, since the span of its voxels comes from what it was before. `all`: wherever
 * they are. */
static kd_status see_near(kd_world *w, voxel_objects *table, kd_voxel_scene *scene, bool all)
{
    const kd_draw_list *list = kd_singleton(w, kd_draw_list);
    for (uint32_t i = 0; i < scene->object_count; i++)
        scene->objects[i].seen = false;
    uint32_t count;
    const uint32_t *near = find_near(table, scene, list, all, &count);
    kd_status status = near || !list->draw_count ? KD_OK : KD_NO_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++)
        if (!list->draws[near[i]].deformed)
            status = see_draw(w, table, scene, &list->draws[near[i]]);
    for (uint32_t i = list->deforming_count; i-- > 0 && !status;)
        status = see_draw(w, table, scene, &list->draws[list->deforming[i]]);
    return status ? status : tiles_see(table, scene);
}

/* Caches of this cascade are looked at, wherever their objects stand; 0: of none in particular. */
static uint32_t shown_cascade(const kd_voxel_scene *scene, const kd_frame *frame)
{
    int32_t level = frame->settings.view_level, last = (int32_t)scene->cascade_count - 1;
    return frame->view != KD_VIEW_CACHES || level < 0 ? 0 : (uint32_t)(level < last ? level : last);
}

/* An object holds the caches of the cascades in which it stands, and no others but those that are shown. */
static void want_caches(voxel_objects *table, kd_voxel_scene *scene, uint32_t shown)
{
    for (uint32_t i = 0; i < scene->object_count; i++) {
        kd_voxel_object *o = &scene->objects[i];
        for (uint32_t c = 0; o->alive && o->seen && c < scene->cascade_count; c++) {
            bool stands =
                (c > 0 && c == shown) || placement_includes(scene, c, o->bounds_min_ws, o->bounds_max_ws);
            if (!scene->want_all && !((o->cascades >> c & 1u) && stands))
                o->caches[c] = 0;
            else if (caches_want(&table->caches, scene, o, c) != KD_OK)
                kd_log(KD_LOG_WARNING, "out of memory for voxel caches; indirect light lacks some");
        }
    }
}

/* What the cascades are kept inside of: all that stands still, so that nothing that moves can move them.
 * Scenes in which everything moves are bounded by what is drawn. */
static kd_box place_bounds(const kd_draw_list *list)
{
    const kd_box still = list->tree ? kd_box_tree_still(list->tree) : (kd_box){{1, 0, 0}, {0, 0, 0}};
    return still.low.x <= still.high.x ? still : (kd_box){list->bounds_min_ws, list->bounds_max_ws};
}

static void run(kd_system_context *context)
{
    voxel_objects *table = context->user;
    kd_world *w = context->world;
    kd_voxel_scene *scene = kd_singleton(w, kd_voxel_scene);
    const kd_frame *frame = kd_singleton(w, kd_frame);
    const kd_draw_list *list = kd_singleton(w, kd_draw_list);
    const kd_view *view = kd_singleton(w, kd_view);
    apply_settings(scene, &frame->settings);
    fixed_settings_follow(&table->settings, &frame->settings);
    float ahead = AHEAD * 0.5f * (float)scene->resolution * scene->span[0];
    kd_vec3 focus = kd_vec3_add(view->position_ws, kd_vec3_scale(view->forward_ws, ahead));
    kd_box bounds = place_bounds(list);
    placement_update(scene, focus, bounds.low, bounds.high);
    ahead_begin(table, scene, focus);
    if (see_near(w, table, scene, scene->want_all || frame->view == KD_VIEW_CACHES) != KD_OK)
        kd_log(KD_LOG_WARNING, "out of memory for voxel objects; indirect light lacks some");
    want_caches(table, scene, shown_cascade(scene, frame));
    if (ahead_want(table, scene, &bounds) != KD_OK)
        kd_log(KD_LOG_WARNING, "out of memory for voxel caches; some come late");
    caches_end_run(&table->caches, scene);
    scene->internal = table;
}

static void fini(kd_system_context *context)
{
    voxel_objects *table = context->user;
    objects_fini(table, kd_singleton(context->world, kd_voxel_scene));
    free(table);
}

kd_status kd_voxel_objects_import(kd_schedule *s)
{
    voxel_objects *table = calloc(1, sizeof *table);
    if (!table)
        return KD_NO_MEMORY;
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "voxel_objects",
                                  .phase = KD_PHASE_VOXEL_IO,
                                  .where = KD_ON_CPU,
                                  .components = {KD_CHANGES(kd_voxel_scene), KD_USES(kd_draw_list),
                                                 KD_USES(kd_scene_store), KD_USES(kd_view), KD_USES(kd_frame),
                                                 KD_USES(kd_mesh_instance), KD_USES(kd_skin_instance),
                                                 KD_USES(kd_world_transform), KD_USES(kd_joint_palette)},
                                  .run_if = kd_frame_needs_voxels,
                                  .no_commands = true,
                                  .run = run,
                                  .fini = fini,
                                  .user = table,
                              });
}
