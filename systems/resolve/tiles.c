/* Local lights by tile of the picture: each tile is lit by those that reach what it shows. The marks stay on
 * the GPU; shaders/resolve/tiles.comp makes them. */

#include "systems/resolve/internal.h"

enum {
    TILES_GROUP = 32,
    TILES_FEW_LIGHTS = 4 /* with ranges, for which marking them costs more than it spares */
};

static bool shows_lamps(const kd_frame *frame)
{
    return frame->view == KD_VIEW_FINAL || frame->view == KD_VIEW_DIRECT || frame->view == KD_VIEW_LIGHT;
}

/* Lights without a range are in every tile. */
static bool pays(const kd_frame *frame, const kd_lighting *lighting)
{
    if (frame->settings.light_tiles == KD_TILES_OFF || !shows_lamps(frame))
        return false;
    if (frame->settings.light_tiles == KD_TILES_ON)
        return lighting->light_count > lighting->directional_count;
    return lighting->ranged_count > TILES_FEW_LIGHTS;
}

static uint32_t tile_count(const kd_frame *frame)
{
    return resolve_groups(frame->width, KD_TILE_EDGE) * resolve_groups(frame->height, KD_TILE_EDGE);
}

static kd_gpu_program tiles_program(kd_gpu *gpu, resolve_state *s)
{
    if (!s->tiles.tried)
        s->tiles.program =
            kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/resolve/tiles.comp"});
    s->tiles.tried = true;
    return s->tiles.program;
}

bool resolve_tiles_run(kd_system_context *context, resolve_state *s)
{
    kd_gpu *gpu = context->gpu;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    uint32_t tiles = tile_count(frame);
    uint32_t words = (lighting->light_count - lighting->directional_count + 31) / 32;
    if (!pays(frame, lighting) || kd_gpu_ensure_buffer(gpu, &s->tile_lights, sizeof(uint32_t) * tiles * words,
                                                       0, "lights of tiles") != KD_OK)
        return false;
    kd_gpu_bind_storage(gpu, 0, s->tile_lights);
    kd_gpu_dispatch(gpu, tiles_program(gpu, s), resolve_groups(tiles, TILES_GROUP), 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    return true;
}

void resolve_tiles_fini(kd_gpu *gpu, resolve_state *s)
{
    kd_gpu_destroy_program(gpu, s->tiles.program);
    kd_gpu_destroy_buffer(gpu, s->tile_lights);
}
