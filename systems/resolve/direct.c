/* System direct: light straight from the lights, through their shadow maps, per pixel. */

#include <stdlib.h>

#include "systems/resolve/internal.h"

static void ensure_texture(kd_gpu *gpu, resolve_state *s, const kd_frame *frame)
{
    if (s->direct_width == frame->width && s->direct_height == frame->height)
        return;
    kd_gpu_destroy_texture(gpu, s->direct_texture);
    s->direct_texture = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){
        .format = KD_RGBA16F, .width = frame->width, .height = frame->height, .filter = KD_NEAREST, .name = "direct"});
    s->direct_width = frame->width;
    s->direct_height = frame->height;
}

static kd_gpu_program find_program(kd_gpu *gpu, resolve_state *s, const kd_lighting *lighting)
{
    bool directional = lighting->directional_count > 0, local = lighting->light_count > lighting->directional_count;
    unsigned index = (directional ? 1u : 0u) | (local ? 2u : 0u);
    if (!s->tried[index]) {
        const char *defines[3] = {NULL};
        int count = 0;
        if (directional)
            defines[count++] = "DIRECTIONAL";
        if (local)
            defines[count] = "LOCAL";
        s->direct[index] = kd_gpu_make_program(
            gpu, &(kd_gpu_program_desc){.compute = "shaders/resolve/direct.comp", .defines = defines});
        s->tried[index] = true;
    }
    return s->direct[index];
}

void resolve_direct_run(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    resolve_state *s = context->user;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    ensure_texture(gpu, s, frame);
    resolve_bind_scene(context);
    kd_gpu_bind_image(gpu, 0, s->direct_texture, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_dispatch(gpu, find_program(gpu, s, kd_singleton(context->world, kd_lighting)),
                    resolve_groups(frame->width, RESOLVE_GROUP), resolve_groups(frame->height, RESOLVE_GROUP), 1);
}

void resolve_direct_fini(kd_system_context *context)
{
    resolve_state *s = context->user;
    for (int i = 0; i < 4; i++)
        kd_gpu_destroy_program(context->gpu, s->direct[i]);
    kd_gpu_destroy_texture(context->gpu, s->direct_texture);
    free(s);
}
