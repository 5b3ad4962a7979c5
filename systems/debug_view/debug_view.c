/* What the views share. Each draws in place of the picture, in the phase before the tone map. */
#include "systems/debug_view/debug_view.h"

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "systems/debug_view/internal.h"

_Static_assert((unsigned)KD_CHANNEL_RADIANCE == KD_SHOW_RADIANCE &&
                   (unsigned)KD_CHANNEL_ALBEDO == KD_SHOW_VOXEL_ALBEDO &&
                   (unsigned)KD_CHANNEL_NORMAL == KD_SHOW_VOXEL_NORMAL &&
                   (unsigned)KD_CHANNEL_OPACITY == KD_SHOW_OPACITY &&
                   (unsigned)KD_CHANNEL_CASCADE == KD_SHOW_CASCADE,
               "shaders number the channels as kd_view_channel does");

struct kd_debug_view_params debug_view_params(const kd_frame *frame, const kd_svo *svo)
{
    int32_t level = frame->settings.view_level;
    return (struct kd_debug_view_params){
        .view = {frame->width, frame->height, level < 0 ? 0 : (uint32_t)level,
                 (uint32_t)kd_frame_channel(frame)},
        .tree = {0, kd_svo_moving_room(svo), svo->node_capacity,
                 kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2},
    };
}

void debug_view_begin(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    kd_gpu_clear_texture(gpu, picture->hdr, 0, NULL);
    kd_gpu_barrier(gpu, KD_BARRIER_IMAGE);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
    kd_gpu_bind_image(gpu, 0, picture->hdr, 0, KD_IMAGE_WRITE, KD_RGBA16F);
}

void debug_view_dispatch(kd_system_context *context, kd_gpu_program program)
{
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    kd_gpu_dispatch(context->gpu, program, (picture->width + 7) / 8, (picture->height + 7) / 8, 1);
}

kd_status kd_debug_view_import(kd_schedule *s)
{
    kd_status status = debug_view_add_voxels(s);
    if (!status)
        status = debug_view_add_tree(s);
    return status ? status : debug_view_add_cost(s);
}
