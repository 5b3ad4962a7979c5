/* The picture mixed with the one before while the camera moves, `view.steady`. Three textures take turns: the
 * light that a frame sums up, what becomes of it, and what became of the frame before. While the camera
 * stands there is nothing but the first, as if nobody had asked. */

#include <string.h>

#include "components/film.h"
#include "systems/resolve/internal.h"

/* Of the picture before in the next one, and frames in which it goes back to nothing once the camera stands.
 */
static const float old_share = 0.8f;
enum { FADING = 16 };

static bool ensure_programs(kd_gpu *gpu, resolve_steady *s)
{
    static const char *const defines[2][2] = {{NULL}, {"LDR", NULL}};
    for (size_t i = 0; i < 2 && !s->tried; i++)
        s->mix[i] = kd_gpu_make_program(
            gpu, &(kd_gpu_program_desc){.compute = "shaders/resolve/steady.comp", .defines = defines[i]});
    s->tried = true;
    return s->mix[0].id != 0 && s->mix[1].id != 0;
}

static void destroy_textures(kd_gpu *gpu, resolve_steady *s)
{
    kd_gpu_destroy_texture(gpu, s->before);
    kd_gpu_destroy_texture(gpu, s->mixed);
    s->before = s->mixed = (kd_gpu_texture){0};
}

static bool fit(kd_gpu *gpu, resolve_steady *s, uint32_t width, uint32_t height)
{
    if (s->before.id != 0 && s->width == width && s->height == height)
        return true;
    destroy_textures(gpu, s);
    const kd_gpu_texture_desc desc = {.format = KD_RGBA16F,
                                      .width = width,
                                      .height = height,
                                      .filter = KD_NEAREST,
                                      .name = "picture before"};
    s->before = kd_gpu_make_texture(gpu, &desc);
    s->mixed = kd_gpu_make_texture(gpu, &desc);
    s->width = width;
    s->height = height;
    s->made = 0;
    return s->before.id != 0 && s->mixed.id != 0;
}

void resolve_steady_begin(resolve_steady *s, kd_picture *picture)
{
    if (s->sum.id != 0)
        picture->hdr = s->sum;
    s->sum = (kd_gpu_texture){0};
}

/* The frame that was seen last is this one or the one before: windows show a world that stands more than
 * once. */
static bool is_next(uint64_t frame, uint64_t last_plus_one)
{
    return last_plus_one != 0 && (frame == last_plus_one || frame + 1 == last_plus_one);
}

/* Note how long the camera has stood; another size of the picture is no move. Returns false when there is
 * nothing to mix. */
static bool follow_camera(kd_system_context *context, resolve_steady *s)
{
    const kd_view *view = kd_singleton(context->world, kd_view);
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_film *film = kd_singleton(context->world, kd_film);
    bool known =
        is_next(frame->index, s->followed) && s->view.width == view->width && s->view.height == view->height;
    bool moves = known && memcmp(&view->view_projection, &s->view.view_projection, sizeof(kd_mat4)) != 0;
    s->still_frames = moves ? 0 : known && s->still_frames < FADING ? s->still_frames + 1 : FADING;
    s->followed = frame->index + 1;
    return frame->settings.view_steady && frame->view == KD_VIEW_FINAL && film->supersample <= 1 &&
           film->sub_frames <= 1 && s->still_frames < FADING;
}

static void mix(kd_system_context *context, resolve_steady *s, kd_picture *picture, bool ldr)
{
    kd_gpu *gpu = context->gpu;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    bool known = is_next(frame->index, s->made);
    struct kd_steady_params params = {.mode = resolve_params(context).mode};
    params.share.x = known ? old_share * (1 - (float)s->still_frames / FADING) : 0;
    memcpy(params.before.m, s->view.view_projection.m, sizeof params.before.m);
    kd_gpu_barrier(gpu, KD_BARRIER_TEXTURE);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_texture(gpu, KD_UNIT_PICTURE, picture->hdr);
    kd_gpu_bind_texture(gpu, KD_UNIT_BEFORE_DIFFUSE, s->before);
    kd_gpu_bind_image(gpu, 0, s->mixed, 0, KD_IMAGE_WRITE, KD_RGBA16F);
    kd_gpu_bind_image(gpu, 1, picture->ldr, 0, KD_IMAGE_WRITE, KD_RGBA8);
    kd_gpu_dispatch(gpu, s->mix[ldr], resolve_groups(picture->width, RESOLVE_GROUP),
                    resolve_groups(picture->height, RESOLVE_GROUP), 1);
    /* the mixture is the picture, and what the next frame looks back at */
    kd_gpu_texture mixed = s->mixed;
    s->sum = picture->hdr;
    picture->hdr = mixed;
    s->mixed = s->before;
    s->before = mixed;
    s->made = frame->index + 1;
}

void resolve_steady_run(kd_system_context *context, resolve_steady *s, bool ldr)
{
    kd_picture *picture = kd_singleton(context->world, kd_picture);
    if (!follow_camera(context, s))
        destroy_textures(context->gpu, s);
    else if (ensure_programs(context->gpu, s) && fit(context->gpu, s, picture->width, picture->height))
        mix(context, s, picture, ldr);
    s->view = *kd_singleton(context->world, kd_view);
}

void resolve_steady_fini(kd_gpu *gpu, resolve_steady *s)
{
    for (size_t i = 0; i < 2; i++)
        kd_gpu_destroy_program(gpu, s->mix[i]);
    destroy_textures(gpu, s);
}
