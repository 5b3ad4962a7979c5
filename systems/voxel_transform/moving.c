#include "systems/voxel_transform/moving.h"

#include "runtime/core/settings.h"

_Static_assert(KD_MOVING_GROUP *KD_MOVING_GROUPS == KD_SEGMENT_VOXELS, "groups fill a segment");

static kd_gpu_program program(kd_gpu *gpu, const char *path, const char *const *defines)
{
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = path, .defines = defines});
}

kd_status moving_init(kd_gpu *gpu, moving_voxels *m)
{
    static const char *const kinds[KD_MOVING_KINDS] = {
        [KD_VOXEL_RIGID] = NULL, [KD_VOXEL_SKINNED] = "KD_SKINNED 1", [KD_VOXEL_ATTACHED] = "KD_ATTACHED 1"};
    m->list = program(gpu, "shaders/voxel_transform/list.comp", NULL);
    m->list_args = program(gpu, "shaders/voxel_transform/list_args.comp", NULL);
    bool all = m->list.id && m->list_args.id;
    for (uint32_t k = 0; k < KD_MOVING_KINDS; k++)
        for (uint32_t marked = 0; marked < 2; marked++) {
            const char *defines[3] = {kinds[k]};
            defines[kinds[k] ? 1 : 0] = marked ? NULL : "KD_UNMARKED 1";
            m->programs[marked][k] = program(gpu, "shaders/voxel_transform/transform.comp", defines);
            all = all && m->programs[marked][k].id;
        }
    kd_status status = kd_pose_access_init(gpu, &m->pose);
    return all ? status : KD_GPU;
}

void moving_fini(kd_gpu *gpu, moving_voxels *m)
{
    kd_gpu_destroy_program(gpu, m->list);
    kd_gpu_destroy_program(gpu, m->list_args);
    for (uint32_t i = 0; i < 2 * KD_MOVING_KINDS; i++)
        kd_gpu_destroy_program(gpu, m->programs[i % 2][i / 2]);
    kd_texel_view_fini(gpu, &m->record_view);
    kd_texel_view_fini(gpu, &m->shape_view);
    kd_texel_view_fini(gpu, &m->object_view);
    kd_texel_view_fini(gpu, &m->color_view);
    kd_gpu_destroy_buffer(gpu, m->work);
    kd_gpu_destroy_buffer(gpu, m->records);
    kd_pose_access_fini(gpu, &m->pose);
}

/* What a crowd needed goes back when it has gone; nothing in the lists outlives a frame. */
static void let_go(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t wanted)
{
    if (!buffer->id || kd_gpu_buffer_size(gpu, *buffer) <= 4 * wanted)
        return;
    kd_gpu_destroy_buffer(gpu, *buffer);
    *buffer = (kd_gpu_buffer){0};
}

static kd_status reserve(kd_gpu *gpu, moving_voxels *m, uint32_t slots)
{
    size_t work = KD_MOVING_LIST(KD_MOVING_KINDS, (size_t)slots) * 4;
    size_t records = (size_t)slots * KD_MOVING_RECORD * 16;
    let_go(gpu, &m->work, work);
    let_go(gpu, &m->records, records);
    kd_status status = kd_gpu_ensure_buffer(gpu, &m->work, work, 0, "voxels.moving");
    return status ? status : kd_gpu_ensure_buffer(gpu, &m->records, records, 0, "voxels.moving");
}

static void list_groups(kd_gpu *gpu, const moving_voxels *m, const kd_voxel_scene *scene, uint32_t slots)
{
    uint32_t pass[4] = {slots, 0, 0, 0};
    kd_gpu_fill_buffer(gpu, m->work, 0, KD_MOVING_HEAD * 4, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, scene->pages[KD_LAYER_DYNAMIC].segments);
    kd_gpu_bind_storage(gpu, 1, scene->object_params);
    kd_gpu_bind_storage(gpu, 2, scene->chunk_params);
    kd_gpu_bind_storage(gpu, 3, m->records);
    kd_gpu_bind_storage(gpu, 4, m->work);
    kd_gpu_dispatch_linear(gpu, m->list, (slots + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_dispatch(gpu, m->list_args, 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT | KD_BARRIER_TEXTURE);
}

void moving_rest(kd_gpu *gpu, moving_voxels *m)
{
    let_go(gpu, &m->work, 0);
    let_go(gpu, &m->records, 0);
}

kd_status moving_transform(kd_system_context *context, moving_voxels *m, const kd_voxel_scene *scene,
                           const kd_svo *svo)
{
    kd_gpu *gpu = context->gpu;
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    bool marked = scene->build == KD_SVO_BUILD_ORDERFREE;
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS;
    kd_status status = reserve(gpu, m, slots);
    if (status)
        return status;
    list_groups(gpu, m, scene, slots);
    kd_gpu_bind_storage(gpu, 5, pages->voxels);
    kd_gpu_bind_storage(gpu, 6, svo->moving);
    kd_pose_access_bind(gpu, &m->pose, kd_singleton(context->world, kd_scene_store),
                        kd_singleton(context->world, kd_joint_palette), scene->cache_binding);
    kd_texel_view_bind(gpu, &m->record_view, KD_POSE_VIEWS, m->records, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &m->shape_view, KD_POSE_VIEWS + 1, scene->cache_shape, KD_RG32UI);
    kd_texel_view_bind(gpu, &m->object_view, KD_POSE_VIEWS + 2, scene->object_params, KD_RGBA32F);
    kd_texel_view_bind(gpu, &m->color_view, KD_POSE_VIEWS + 3, scene->cache_color, KD_R32UI);
    for (uint32_t k = 0; k < KD_MOVING_KINDS; k++) {
        uint32_t pass[4] = {slots, k, 0, 0};
        kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
        kd_gpu_dispatch_indirect(gpu, m->programs[marked][k], m->work, KD_MOVING_ARGS(k) * 4);
    }
    return KD_OK;
}
