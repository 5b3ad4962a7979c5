/* System tonemap: brings the picture to the screen when resolve could not: the exposure is measured from it,
 * or another system has drawn over it, or a frame is the mean of several. Nothing comes back to the CPU: the
 * exposure stays in a buffer. */

#include <math.h>

#include "components/film.h"
#include "systems/resolve/internal.h"

static kd_gpu_program make_program(kd_gpu *gpu, const char *path, const char *define)
{
    const char *defines[] = {define, NULL};
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = path, .defines = defines});
}

/* What is brought to the screen: the frame's mean where one is taken. */
static kd_gpu_texture source(const kd_picture *picture)
{
    return picture->mean.id != 0 ? picture->mean : picture->hdr;
}

kd_status resolve_tonemap_init(kd_system_context *context)
{
    resolve_state *s = context->user;
    s->tonemap = make_program(context->gpu, "shaders/resolve/tonemap.comp",
                              kd_singleton(context->world, kd_film)->deep ? "DEEP" : NULL);
    s->luminance = make_program(context->gpu, "shaders/resolve/luminance.comp", NULL);
    s->exposure = make_program(context->gpu, "shaders/resolve/exposure.comp", NULL);
    s->exposure_buffer = kd_gpu_make_buffer(
        context->gpu,
        &(kd_gpu_buffer_desc){.size = sizeof(float), .usage = KD_BUFFER_STREAM, .name = "exposure"});
    bool made =
        s->tonemap.id != 0 && s->luminance.id != 0 && s->exposure.id != 0 && s->exposure_buffer.id != 0;
    return made ? KD_OK : KD_GPU;
}

void resolve_tonemap_fini(kd_system_context *context)
{
    resolve_state *s = context->user;
    kd_gpu_destroy_program(context->gpu, s->tonemap);
    kd_gpu_destroy_program(context->gpu, s->luminance);
    kd_gpu_destroy_program(context->gpu, s->exposure);
    kd_gpu_destroy_buffer(context->gpu, s->exposure_buffer);
    kd_gpu_destroy_buffer(context->gpu, s->partials);
}

/* Measure this picture alone: what earlier frames showed must not matter. */
static void measure_exposure(kd_system_context *context, resolve_state *s, const kd_picture *picture,
                             const struct kd_resolve_params *params)
{
    kd_gpu *gpu = context->gpu;
    uint32_t x = resolve_groups(picture->shown_width, RESOLVE_LUMINANCE_GROUP);
    uint32_t y = resolve_groups(picture->shown_height, RESOLVE_LUMINANCE_GROUP);
    kd_gpu_ensure_buffer(gpu, &s->partials, (size_t)params->mode.w * 2 * sizeof(float), 0, "luminance sums");
    kd_gpu_bind_storage(gpu, 1, s->partials);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, kd_singleton(context->world, kd_lighting)->view, 0,
                               sizeof(struct kd_view_params));
    kd_gpu_dispatch(gpu, s->luminance, x, y, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_dispatch(gpu, s->exposure, 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void set_exposure(kd_gpu *gpu, resolve_state *s, const kd_frame *frame)
{
    float exposure = exp2f(frame->settings.view_exposure_ev);
    kd_gpu_write_buffer(gpu, s->exposure_buffer, 0, &exposure, sizeof exposure);
}

void resolve_tonemap_run(kd_system_context *context)
{
    kd_gpu *gpu = context->gpu;
    resolve_state *s = context->user;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_picture *picture = kd_singleton(context->world, kd_picture);
    struct kd_resolve_params params = resolve_params(context);
    if (params.mode.x == KD_SHOW_COST)
        params.mode.z = (uint32_t)frame->settings.view_cost_scale;
    params.mode.w = resolve_groups(picture->shown_width, RESOLVE_LUMINANCE_GROUP) *
                    resolve_groups(picture->shown_height, RESOLVE_LUMINANCE_GROUP);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_storage(gpu, 0, s->exposure_buffer);
    kd_gpu_bind_texture(gpu, 0, source(picture));
    if (resolve_measures(frame))
        measure_exposure(context, s, picture, &params);
    else
        set_exposure(gpu, s, frame);
    kd_gpu_bind_image(gpu, 1, picture->ldr, 0, KD_IMAGE_WRITE, KD_RGBA8);
    if (picture->deep.id != 0)
        kd_gpu_bind_image(gpu, 2, picture->deep, 0, KD_IMAGE_WRITE, KD_RGBA16UI);
    kd_gpu_dispatch(gpu, s->tonemap, resolve_groups(picture->shown_width, RESOLVE_GROUP),
                    resolve_groups(picture->shown_height, RESOLVE_GROUP), 1);
}
