/* The GPU side: uploads view and lights, and renders the shadow maps. A layer takes one draw call for all
 * that is opaque and one for each masked batch. Both faces of a triangle cast: a wall of one sheet must stop
 * the sun from behind too. */

#include "systems/shadow/shadow.h"

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

/* A depth array with one target a layer. There is always a layer, so that shaders can bind the texture. */
static void make_maps(kd_gpu *gpu, kd_gpu_texture *texture, kd_gpu_target *targets, uint32_t layers,
                      uint32_t edge, const char *name)
{
    *texture = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = KD_TEXTURE_2D_ARRAY,
                                                               .format = KD_DEPTH32F,
                                                               .width = edge,
                                                               .height = edge,
                                                               .depth = layers,
                                                               .filter = KD_SHADOW,
                                                               .name = name});
    for (uint32_t i = 0; i < layers; i++)
        targets[i] =
            kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.depth = *texture, .layer = i, .name = name});
}

static void destroy_maps(kd_gpu *gpu, kd_gpu_texture texture, kd_gpu_target *targets, uint32_t layers)
{
    for (uint32_t i = 0; i < layers; i++)
        kd_gpu_destroy_target(gpu, targets[i]);
    kd_gpu_destroy_texture(gpu, texture);
}

/* Layers are added when needed and stay: a light that comes and goes does not cost a new texture each time.
 */
static void ensure_maps(kd_gpu *gpu, kd_lighting *lighting, shadow_state *s)
{
    if (s->directional_layers > s->made_directional_layers ||
        s->directional_edge != s->made_directional_edge) {
        destroy_maps(gpu, lighting->shadow_directional, s->directional_targets, s->made_directional_layers);
        s->made_directional_layers = s->directional_layers > 0 ? s->directional_layers : 1;
        s->made_directional_edge = s->directional_edge;
        make_maps(gpu, &lighting->shadow_directional, s->directional_targets, s->made_directional_layers,
                  s->directional_edge, "shadow directional");
    }
    if (s->spot_layers > s->made_spot_layers || s->spot_edge != s->made_spot_edge) {
        destroy_maps(gpu, lighting->shadow_spot, s->spot_targets, s->made_spot_layers);
        s->made_spot_layers = s->spot_layers > 0 ? s->spot_layers : 1;
        s->made_spot_edge = s->spot_edge;
        make_maps(gpu, &lighting->shadow_spot, s->spot_targets, s->made_spot_layers, s->spot_edge,
                  "shadow spot");
    }
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
    destroy_maps(gpu, lighting->shadow_directional, s->directional_targets, s->made_directional_layers);
    destroy_maps(gpu, lighting->shadow_spot, s->spot_targets, s->made_spot_layers);
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

static void draw_layer(kd_gpu *gpu, const shadow_state *s, const shadow_layer *layer,
                       const kd_scene_store *store, const kd_gpu_geometry geometry[2])
{
    uint32_t edge = layer->directional ? s->directional_edge : s->spot_edge;
    kd_gpu_begin_raster(gpu,
                        &(kd_gpu_raster){.target = layer->directional ? s->directional_targets[layer->layer]
                                                                      : s->spot_targets[layer->layer],
                                         .width = edge,
                                         .height = edge,
                                         .depth_test = true,
                                         .depth_write = true,
                                         .cull = KD_CULL_NONE,
                                         .depth_clamp = layer->directional,
                                         .clear_depth = true});
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &layer->matrix, sizeof layer->matrix);
    const shadow_run *runs = s->runs.items;
    for (uint32_t i = layer->first_run; i < layer->first_run + layer->run_count; i++) {
        bool masked = runs[i].material != KD_NONE;
        kd_gpu_program program =
            masked ? bind_masked(gpu, s, &store->materials[runs[i].material]) : s->opaque;
        kd_gpu_draw_indirect(gpu, program, &geometry[masked], s->args_buffer,
                             runs[i].first * sizeof(kd_draw_indexed), runs[i].count);
    }
}

static void shadow_run_system(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    shadow_state *s = lighting->internal;
    ensure_maps(gpu, lighting, s);
    kd_gpu_geometry geometry[2] = {make_geometry(store, list, false), make_geometry(store, list, true)};
    if (s->arg_count > 0) {
        size_t bytes = s->arg_count * sizeof(kd_draw_indexed);
        kd_gpu_ensure_buffer(gpu, &s->args_buffer, bytes, 0, "shadow arguments");
        kd_gpu_write_buffer(gpu, s->args_buffer, 0, s->args.items, bytes);
        kd_gpu_bind_storage(gpu, 0, list->objects);
    }
    for (uint32_t i = 0; i < s->layer_count; i++)
        draw_layer(gpu, s, &s->layers[i], store, geometry);
}

static uint64_t shadow_bytes(const kd_system_context *context)
{
    const shadow_state *s = get_state(context->world);
    uint64_t directional = (uint64_t)s->directional_edge * s->directional_edge * s->directional_layers;
    return (directional + (uint64_t)s->spot_edge * s->spot_edge * s->spot_layers) * 4;
}

kd_status kd_shadow_import(kd_schedule *schedule)
{
    const kd_system_desc systems[] = {
        {.name = "lights",
         .phase = KD_PHASE_CULL,
         .where = KD_ON_CPU,
         .components = {KD_USES(kd_light), KD_USES(kd_world_transform), KD_USES(kd_mesh_instance),
                        KD_USES(kd_view), KD_USES(kd_frame), KD_USES(kd_draw_list), KD_USES(kd_scene_store),
                        KD_CHANGES(kd_lighting)},
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
                       {"shadow.maps", KD_USE_TARGET}},
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
