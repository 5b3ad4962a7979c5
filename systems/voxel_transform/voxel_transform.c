/* System voxel_transform: brings the voxels in the pages to the world and marks the cells that they cover.
 * The dynamic layer goes every frame, the static one only when its members changed or the cascades moved. */
#include "systems/voxel_transform/voxel_transform.h"

#include <stdlib.h>

#include "components/deform.h"
#include "components/frame.h"
#include "components/scene_store.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"

enum { GROUP = 128 };

typedef struct transform_state {
    kd_gpu_program program[KD_LAYER_COUNT];   /* the static layer is rigid */
    kd_gpu_texture joints, geometry, indices; /* texel buffer views */
    uint32_t viewed[3];                       /* the buffers they were made of */
    kd_gpu_buffer none;
    uint64_t bytes;
} transform_state;

static kd_gpu_buffer or_none(const transform_state *state, kd_gpu_buffer buffer)
{
    return buffer.id ? buffer : state->none;
}

/* Views follow their buffers when those grow. */
static kd_gpu_texture view_of(kd_gpu *gpu, const transform_state *state, kd_gpu_texture *view,
                              uint32_t *viewed, kd_gpu_buffer buffer, kd_texture_format format)
{
    buffer = or_none(state, buffer);
    if (*viewed != buffer.id) {
        kd_gpu_destroy_texture(gpu, *view);
        *view = kd_gpu_make_texel_buffer(gpu, buffer, format);
        *viewed = buffer.id;
    }
    return *view;
}

static void bind_deforming(kd_system_context *context, transform_state *state)
{
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    const kd_joint_palette *palette = kd_singleton(context->world, kd_joint_palette);
    kd_gpu *gpu = context->gpu;
    kd_gpu_bind_texture(
        gpu, 0, view_of(gpu, state, &state->joints, &state->viewed[0], palette->matrices, KD_RGBA32F));
    kd_gpu_bind_texture(gpu, 1,
                        view_of(gpu, state, &state->geometry, &state->viewed[1], store->geometry, KD_R32UI));
    kd_gpu_bind_texture(gpu, 2,
                        view_of(gpu, state, &state->indices, &state->viewed[2], store->indices, KD_R32UI));
}

static void transform_layer(kd_system_context *context, transform_state *state, const kd_voxel_scene *scene,
                            const kd_svo *svo, kd_voxel_layer layer)
{
    kd_gpu *gpu = context->gpu;
    const kd_voxel_pages *pages = &scene->pages[layer];
    size_t mask_bytes = (size_t)svo->layer_words * 4, first = layer * mask_bytes;
    kd_gpu_fill_buffer(gpu, svo->masks, first, mask_bytes, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    if (!pages->segment_count)
        return;
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS, pass[4] = {slots, 0, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, svo->uniform, 0, sizeof(struct kd_tree_params));
    kd_gpu_bind_storage(gpu, 0, pages->segments);
    kd_gpu_bind_storage(gpu, 1, scene->object_params);
    kd_gpu_bind_storage(gpu, 2, scene->chunk_params);
    kd_gpu_bind_storage(gpu, 3, scene->cache_shape);
    kd_gpu_bind_storage(gpu, 4, or_none(state, scene->cache_binding));
    kd_gpu_bind_storage(gpu, 5, pages->voxels);
    kd_gpu_bind_storage_range(gpu, 6, svo->masks, first, mask_bytes);
    if (layer == KD_LAYER_DYNAMIC)
        bind_deforming(context, state);
    kd_gpu_dispatch(gpu, state->program[layer], KD_SEGMENT_VOXELS / GROUP, slots, 1);
    state->bytes += pages->voxel_count * (8 + 12 + 4);
}

static void run(kd_system_context *context)
{
    transform_state *state = context->user;
    const kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    state->bytes = 0;
    if (scene->static_changed)
        transform_layer(context, state, scene, svo, KD_LAYER_STATIC);
    transform_layer(context, state, scene, svo, KD_LAYER_DYNAMIC);
}

static uint64_t bytes_moved(const kd_system_context *context)
{
    return ((const transform_state *)context->user)->bytes;
}

static kd_status init(kd_system_context *context)
{
    transform_state *state = context->user;
    const char *deforming[] = {"KD_DEFORMING 1", NULL};
    state->program[KD_LAYER_STATIC] = kd_gpu_make_program(
        context->gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_transform/transform.comp",
                                             .name = "transform_static"});
    state->program[KD_LAYER_DYNAMIC] = kd_gpu_make_program(
        context->gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_transform/transform.comp",
                                             .defines = deforming,
                                             .name = "transform_dynamic"});
    state->none =
        kd_gpu_make_buffer(context->gpu, &(kd_gpu_buffer_desc){.size = 64, .zeroed = true, .name = "none"});
    return state->program[0].id && state->program[1].id && state->none.id ? KD_OK : KD_GPU;
}

static void fini(kd_system_context *context)
{
    transform_state *state = context->user;
    kd_gpu_destroy_program(context->gpu, state->program[0]);
    kd_gpu_destroy_program(context->gpu, state->program[1]);
    kd_gpu_destroy_texture(context->gpu, state->joints);
    kd_gpu_destroy_texture(context->gpu, state->geometry);
    kd_gpu_destroy_texture(context->gpu, state->indices);
    kd_gpu_destroy_buffer(context->gpu, state->none);
    free(state);
}

kd_status kd_voxel_transform_import(kd_schedule *s)
{
    transform_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "voxel_transform",
                                  .phase = KD_PHASE_VOXEL_TRANSFORM,
                                  .where = KD_ON_GPU,
                                  .components = {KD_USES(kd_voxel_scene), KD_USES(kd_svo), KD_USES(kd_frame),
                                                 KD_USES(kd_scene_store), KD_USES(kd_joint_palette)},
                                  .resources = {{"voxels.pages", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE},
                                                {"voxels.objects", KD_USE_STORAGE_READ},
                                                {"voxels.chunks", KD_USE_STORAGE_READ},
                                                {"voxels.cache", KD_USE_STORAGE_READ},
                                                {"scene.vertices", KD_USE_SAMPLED},
                                                {"scene.indices", KD_USE_SAMPLED},
                                                {"scene.joints", KD_USE_SAMPLED},
                                                {"tree.uniform", KD_USE_UNIFORM},
                                                {"svo.masks", KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE}},
                                  .run_if = kd_frame_needs_voxels,
                                  .no_commands = true,
                                  .run = run,
                                  .bytes_moved = bytes_moved,
                                  .init = init,
                                  .fini = fini,
                                  .user = state,
                              });
}
