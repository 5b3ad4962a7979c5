/* The GPU side: uploads view and lights, and renders the shadow maps that have changed. A layer takes one
 * draw call for all that is opaque and one for each masked batch. Both faces of a triangle cast: a wall of
 * one sheet must stop the sun from behind too. */

#include "systems/shadow/shadow.h"

#include <string.h>

#include "runtime/core/log.h"
#include "systems/shadow/internal.h"

static shadow_state *get_state(kd_world *w)
{
    return kd_singleton(w, kd_lighting)->internal;
}

/* ---- lights_upload ---- */

static kd_status upload_init(kd_system_context *context)
{
    kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    lighting->view =
        kd_gpu_make_buffer(context->gpu, &(kd_gpu_buffer_desc){sizeof(struct kd_view_params),
                                                               .usage = KD_BUFFER_STREAM, .name = "view"});
    lighting->lights =
        kd_gpu_make_buffer(context->gpu, &(kd_gpu_buffer_desc){sizeof(struct kd_lights_params),
                                                               .usage = KD_BUFFER_STREAM, .name = "lights"});
    return lighting->view.id != 0 && lighting->lights.id != 0 ? KD_OK : KD_GPU;
}

static void upload_fini(kd_system_context *context)
{
    kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    kd_gpu_destroy_buffer(context->gpu, lighting->view);
    kd_gpu_destroy_buffer(context->gpu, lighting->lights);
}

static void upload_run(kd_system_context *context)
{
    kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    const shadow_state *s = lighting->internal;
    kd_gpu_write_buffer(context->gpu, lighting->view, 0, &s->view, sizeof s->view);
    kd_gpu_write_buffer(context->gpu, lighting->lights, 0, &s->lights, sizeof s->lights);
}

/* ---- shadow ---- */

static kd_gpu_program make_program(kd_gpu *gpu, const char *fragment, const char *const *defines)
{
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.vertex = "shaders/shadow/shadow.vert",
                                                           .fragment = fragment,
                                                           .defines = defines});
}

/* Layers are added when needed and stay: a light that comes and goes does not cost a new texture each time.
 */
static void ensure_maps(kd_gpu *gpu, kd_lighting *lighting, shadow_state *s)
{
    if (shadow_maps_ensure(gpu, &s->maps[true], s->directional_layers, s->directional_edge,
                           "shadow directional"))
        shadow_forget(s, true);
    if (shadow_maps_ensure(gpu, &s->maps[false], s->spot_layers, s->spot_edge, "shadow spot"))
        shadow_forget(s, false);
    lighting->shadow_directional = s->maps[true].texture;
    lighting->shadow_spot = s->maps[false].texture;
}

/* The second maps follow the first in size. */
static void ensure_resting(kd_gpu *gpu, shadow_state *s, bool directional)
{
    const shadow_maps *maps = &s->maps[directional];
    if (!shadow_maps_ensure(gpu, &s->resting[directional], maps->layers, maps->edge, "shadow resting"))
        return;
    uint32_t first = directional ? 0 : SHADOW_DIRECTIONAL_MATRICES;
    for (uint32_t i = 0; i < maps->layers; i++)
        s->kept[first + i].resting_valid = false;
}

static kd_status shadow_init(kd_system_context *context)
{
    static const char *const plain[] = {"MASKED", "MATERIAL_MAPS 0", NULL}, *const mapped[] = {
                                                                                "MASKED", "MATERIAL_MAPS 1",
                                                                                NULL};
    kd_gpu *gpu = context->gpu;
    shadow_state *s = get_state(context->world);
    s->opaque = make_program(gpu, NULL, NULL);
    s->masked[0] = make_program(gpu, "shaders/shadow/masked.frag", plain);
    s->masked[1] = make_program(gpu, "shaders/shadow/masked.frag", mapped);
    return s->opaque.id != 0 && s->masked[0].id != 0 && s->masked[1].id != 0 ? KD_OK : KD_GPU;
}

static void shadow_fini(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    shadow_state *s = lighting->internal;
    if (s == NULL)
        return;
    for (int i = 0; i < 2; i++) {
        shadow_maps_destroy(gpu, &s->maps[i]);
        shadow_maps_destroy(gpu, &s->resting[i]);
    }
    lighting->shadow_directional = lighting->shadow_spot = (kd_gpu_texture){0};
    kd_gpu_destroy_program(gpu, s->opaque);
    kd_gpu_destroy_program(gpu, s->masked[0]);
    kd_gpu_destroy_program(gpu, s->masked[1]);
    kd_gpu_destroy_buffer(gpu, s->args_buffer);
}

/* The streams a pass reads: positions and objects, and for masks what the alpha test needs. */
static kd_gpu_geometry make_geometry(const kd_scene_store *store, const kd_draw_list *list, bool masked)
{
    enum { GEOMETRY_STRIDE = KD_GEOMETRY_WORDS * 4, ATTRIBUTE_STRIDE = KD_ATTRIBUTE_WORDS * 4 };
    kd_gpu_geometry g = {
        .attributes = {{store->geometry, KD_LOC_POSITION, KD_ATTR_F32X3, 0, GEOMETRY_STRIDE, false},
                       {list->object_ids, KD_LOC_OBJECT, KD_ATTR_U32X1, 0, 4, true}},
        .indices = store->indices,
    };
    if (masked) {
        g.attributes[2] =
            (kd_gpu_attribute){store->attributes, KD_LOC_UV0, KD_ATTR_F32X2, 0, ATTRIBUTE_STRIDE, false};
        g.attributes[3] =
            (kd_gpu_attribute){store->attributes, KD_LOC_UV1, KD_ATTR_F32X2, 8, ATTRIBUTE_STRIDE, false};
        g.attributes[4] = (kd_gpu_attribute){store->attributes, KD_LOC_COLOR, KD_ATTR_UNORM8X4, 16,
                                             ATTRIBUTE_STRIDE,  false};
    }
    return g;
}

static kd_gpu_program bind_masked(kd_gpu *gpu, const shadow_state *s, const kd_store_material *material)
{
    struct kd_material_params params = kd_material_params_make(material);
    kd_gpu_bind_uniform(gpu, KD_BIND_MATERIAL, &params, sizeof params);
    bool mapped = (params.maps.x & KD_MAP_BASE_COLOR) != 0;
    if (mapped)
        kd_gpu_bind_texture(gpu, KD_UNIT_BASE_COLOR, material->maps[0]);
    return s->masked[mapped];
}

/* What the passes of a frame share. */
typedef struct shadow_pass {
    kd_gpu *gpu;
    shadow_state *s;
    const kd_scene_store *store;
    kd_gpu_geometry geometry[2]; /* opaque, masked */
} shadow_pass;

static void draw_runs(const shadow_pass *pass, const shadow_layer *layer, const shadow_maps *maps, bool clear,
                      uint32_t first_run, uint32_t run_count)
{
    kd_gpu *gpu = pass->gpu;
    shadow_state *s = pass->s;
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = maps->targets[layer->layer],
                                              .width = maps->edge,
                                              .height = maps->edge,
                                              .depth_test = true,
                                              .depth_write = true,
                                              .cull = KD_CULL_NONE,
                                              .depth_clamp = layer->directional,
                                              .clear_depth = clear});
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &layer->matrix, sizeof layer->matrix);
    const shadow_run *runs = s->runs.items;
    for (uint32_t i = first_run; i < first_run + run_count; i++) {
        bool masked = runs[i].material != KD_NONE;
        kd_gpu_program program =
            masked ? bind_masked(gpu, s, &pass->store->materials[runs[i].material]) : s->opaque;
        kd_gpu_draw_indirect(gpu, program, &pass->geometry[masked], s->args_buffer,
                             runs[i].first * sizeof(kd_draw_indexed), runs[i].count);
        s->drawn_casters += runs[i].count;
    }
    s->drawn_layers++;
    s->bytes_moved += (uint64_t)maps->edge * maps->edge * 4;
}

static void draw_all(const shadow_pass *pass, const shadow_layer *layer)
{
    draw_runs(pass, layer, &pass->s->maps[layer->directional], true, layer->first_run,
              layer->resting_runs + layer->moving_runs);
    shadow_kept_of(pass->s, layer)->resting_valid = false;
}

static void draw_moving(const shadow_pass *pass, const shadow_layer *layer)
{
    shadow_state *s = pass->s;
    const shadow_maps *maps = &s->maps[layer->directional], *resting = &s->resting[layer->directional];
    shadow_kept *kept = shadow_kept_of(s, layer);
    ensure_resting(pass->gpu, s, layer->directional);
    if (!kept->resting_valid)
        draw_runs(pass, layer, resting, true, layer->first_run, layer->resting_runs);
    kept->resting_valid = true;
    kd_gpu_copy_texture(pass->gpu, resting->texture, layer->layer, maps->texture, layer->layer, 0);
    s->copied_layers++;
    s->bytes_moved += (uint64_t)maps->edge * maps->edge * 8;
    if (layer->moving_runs > 0)
        draw_runs(pass, layer, maps, false, layer->first_run + layer->resting_runs, layer->moving_runs);
}

static void upload_args(const shadow_pass *pass, const kd_draw_list *list)
{
    shadow_state *s = pass->s;
    size_t bytes = s->arg_count * sizeof(kd_draw_indexed);
    if (bytes == 0)
        return;
    kd_gpu_ensure_buffer(pass->gpu, &s->args_buffer, bytes, 0, "shadow arguments");
    kd_gpu_write_buffer(pass->gpu, s->args_buffer, 0, s->args.items, bytes);
    kd_gpu_bind_storage(pass->gpu, 0, list->objects);
    s->bytes_moved += bytes;
}

/* Was light another in the frame before? `drawn`: maps were */
static bool note_lights(shadow_state *s, bool drawn)
{
    struct kd_view_params view = s->view;
    view.size.z = 0;
    bool differs = drawn || memcmp(&view, &s->view_before, sizeof view) != 0 ||
                   memcmp(&s->lights, &s->lights_before, sizeof s->lights) != 0;
    s->view_before = view;
    s->lights_before = s->lights;
    return differs;
}

static void shadow_run_system(kd_system_context *context)
{
    kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    shadow_state *s = lighting->internal;
    shadow_pass pass = {.gpu = context->gpu, .s = s, .store = kd_singleton(context->world, kd_scene_store)};
    bool ready = false;
    ensure_maps(context->gpu, lighting, s);
    s->drawn_casters = s->drawn_layers = s->copied_layers = 0;
    s->bytes_moved = 0;
    for (uint32_t i = 0; i < s->layer_count; i++) {
        shadow_work work = shadow_compare(s, &s->layers[i]);
        if (work == SHADOW_KEEP)
            continue;
        if (!ready) {
            pass.geometry[0] = make_geometry(pass.store, list, false);
            pass.geometry[1] = make_geometry(pass.store, list, true);
            upload_args(&pass, list);
            ready = true;
        }
        if (work == SHADOW_DRAW_MOVING)
            draw_moving(&pass, &s->layers[i]);
        else
            draw_all(&pass, &s->layers[i]);
        shadow_remember(s, &s->layers[i]);
    }
    lighting->version += note_lights(s, ready);
}

static uint64_t shadow_bytes(const kd_system_context *context)
{
    return get_state(context->world)->bytes_moved;
}

kd_status kd_shadow_import(kd_schedule *schedule)
{
    const kd_system_desc systems[] = {
        {.name = "lights",
         .phase = KD_PHASE_CULL,
         .where = KD_ON_CPU,
         .components = {KD_USES(kd_light), KD_USES(kd_world_transform), KD_USES(kd_mesh_instance),
                        KD_USES(kd_view), KD_USES(kd_frame), KD_USES(kd_draw_list), KD_USES(kd_scene_store),
                        KD_USES(kd_sky), KD_USES(kd_sky_images), KD_USES(kd_joint_palette),
                        KD_USES(kd_skin_instance), KD_USES(kd_morph_weights), KD_CHANGES(kd_lighting)},
         .init = shadow_lights_init,
         .fini = shadow_lights_fini,
         .run = shadow_lights_run},
        {.name = "lights_upload",
         .phase = KD_PHASE_SHADOW,
         .where = KD_ON_GPU,
         .components = {KD_USES(kd_lighting)},
         .resources = {{"lights.uniform", KD_USE_COPY_WRITE}},
         .init = upload_init,
         .fini = upload_fini,
         .run = upload_run},
        {.name = "shadow",
         .phase = KD_PHASE_SHADOW,
         .where = KD_ON_GPU,
         .components = {KD_USES(kd_draw_list), KD_USES(kd_scene_store), KD_CHANGES(kd_lighting)},
         .resources = {{"scene.vertices", KD_USE_VERTEX},
                       {"scene.indices", KD_USE_INDEX},
                       {"scene.objects", KD_USE_STORAGE_READ | KD_USE_VERTEX},
                       {"shadow.maps", KD_USE_TARGET | KD_USE_COPY_READ | KD_USE_COPY_WRITE}},
         .init = shadow_init,
         .fini = shadow_fini,
         .run = shadow_run_system,
         .bytes_moved = shadow_bytes},
    };
    for (size_t i = 0; i < sizeof systems / sizeof *systems; i++) {
        kd_status status = kd_schedule_add(schedule, &systems[i]);
        if (status != KD_OK)
            return status;
    }
    return KD_OK;
}
