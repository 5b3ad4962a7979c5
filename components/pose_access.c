#include "components/pose_access.h"

void kd_texel_view_bind(kd_gpu *gpu, kd_texel_view *view, uint32_t unit, kd_gpu_buffer buffer,
                        kd_texture_format format)
{
    if (view->viewed != buffer.id) {
        kd_gpu_destroy_texture(gpu, view->texture);
        view->texture = kd_gpu_make_texel_buffer(gpu, buffer, format);
        view->viewed = buffer.id;
    }
    kd_gpu_bind_texture(gpu, unit, view->texture);
}

void kd_texel_view_fini(kd_gpu *gpu, kd_texel_view *view)
{
    kd_gpu_destroy_texture(gpu, view->texture);
    *view = (kd_texel_view){0};
}

kd_status kd_pose_access_init(kd_gpu *gpu, kd_pose_access *access)
{
    access->none = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 64, .zeroed = true, .name = "none"});
    return access->none.id ? KD_OK : KD_GPU;
}

kd_gpu_buffer kd_pose_access_or_none(const kd_pose_access *access, kd_gpu_buffer buffer)
{
    return buffer.id ? buffer : access->none;
}

void kd_pose_access_bind(kd_gpu *gpu, kd_pose_access *access, const kd_scene_store *store,
                         const kd_joint_palette *palette, kd_gpu_buffer binding)
{
    const kd_gpu_buffer buffers[KD_POSE_VIEWS] = {palette->matrices, store->geometry, store->indices,
                                                  binding};
    for (uint32_t i = 0; i < KD_POSE_VIEWS; i++)
        kd_texel_view_bind(gpu, &access->views[i], i, kd_pose_access_or_none(access, buffers[i]),
                           i == 0 ? KD_RGBA32F : KD_R32UI);
}

void kd_pose_access_fini(kd_gpu *gpu, kd_pose_access *access)
{
    for (uint32_t i = 0; i < KD_POSE_VIEWS; i++)
        kd_texel_view_fini(gpu, &access->views[i]);
    kd_gpu_destroy_buffer(gpu, access->none);
}
