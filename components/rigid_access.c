#include "components/rigid_access.h"

void kd_rigid_access_bind(kd_gpu *gpu, kd_rigid_access *access, const kd_voxel_scene *scene)
{
    kd_texel_view_bind(gpu, &access->views[0], 0, scene->pages[KD_LAYER_STATIC].segments, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &access->views[1], 1, scene->chunk_params, KD_RGBA32F);
    kd_texel_view_bind(gpu, &access->views[2], 2, scene->object_params, KD_RGBA32F);
}

void kd_rigid_access_fini(kd_gpu *gpu, kd_rigid_access *access)
{
    for (uint32_t i = 0; i < KD_RIGID_VIEWS; i++)
        kd_texel_view_fini(gpu, &access->views[i]);
}
