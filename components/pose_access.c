#include "components/pose_access.h"

kd_status kd_pose_access_init(kd_gpu *gpu, kd_pose_access *access)
{
    access->none = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 64, .zeroed = true, .name = "none"});
    return access->none.id ? KD_OK : KD_GPU;
}

kd_gpu_buffer kd_pose_access_or_none(const kd_pose_access *access, kd_gpu_buffer buffer)
{
    return buffer.id ? buffer : access->none;
}

static void bind_view(kd_gpu *gpu, kd_pose_access *access, uint32_t unit, kd_gpu_buffer buffer,
                      kd_texture_format format)
{
    buffer = kd_pose_access_or_none(access, buffer);
    if (access->viewed[unit] != buffer.id) {
        kd_gpu_destroy_texture(gpu, access->views[unit]);
        access->views[unit] = kd_gpu_make_texel_buffer(gpu, buffer, format);
        access->viewed[unit] = buffer.id;
    }
    kd_gpu_bind_texture(gpu, unit, access->views[unit]);
}

void kd_pose_access_bind(kd_gpu *gpu, kd_pose_access *access, const kd_scene_store *store,
                         const kd_joint_palette *palette)
{
    bind_view(gpu, access, 0, palette->matrices, KD_RGBA32F);
    bind_view(gpu, access, 1, store->geometry, KD_R32UI);
    bind_view(gpu, access, 2, store->indices, KD_R32UI);
}

void kd_pose_access_fini(kd_gpu *gpu, kd_pose_access *access)
{
    for (uint32_t i = 0; i < 3; i++)
        kd_gpu_destroy_texture(gpu, access->views[i]);
    kd_gpu_destroy_buffer(gpu, access->none);
}
