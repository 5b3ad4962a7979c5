/* Tiles of the picture: those that show nothing cost a look at the sky, and where there are many local lights
 * each tile is lit by those that reach what it shows. The lists stay on the GPU; shaders/resolve/tiles.comp
 * makes them. */

#include "systems/resolve/internal.h"

enum {
    TILES_GROUP = 32,
    TILES_FEW_LIGHTS = 4 /* with ranges, for which marking them costs more than it spares */
};

/* Light is what costs; what other views show costs less than the lists. */
static bool shows_lamps(const kd_frame *frame)
{
    return frame->view == KD_VIEW_FINAL || frame->view == KD_VIEW_DIRECT || frame->view == KD_VIEW_LIGHT;
}

resolve_part resolve_tiles_choose(const kd_frame *frame, const kd_lighting *lighting)
{
    uint32_t local = lighting->light_count - lighting->directional_count;
    int32_t tiles = frame->settings.light_tiles;
    if (tiles == KD_TILES_OFF || !shows_lamps(frame) || lighting->light_count == 0)
        return RESOLVE_ALL;
    bool lit = tiles == KD_TILES_ON ? local > 0 : lighting->ranged_count > TILES_FEW_LIGHTS;
    return lit ? RESOLVE_SURFACES_LIT : RESOLVE_SURFACES;
}

static uint32_t tile_count(const kd_frame *frame)
{
    return resolve_groups(frame->width, KD_TILE_EDGE) * resolve_groups(frame->height, KD_TILE_EDGE);
}

static kd_gpu_program tiles_program(kd_gpu *gpu, resolve_state *s, bool lights)
{
    resolve_variant *variant = &s->tiles[lights];
    const char *defines[] = {lights ? "TILED" : NULL, NULL};
    if (!variant->tried)
        variant->program = kd_gpu_make_program(
            gpu, &(kd_gpu_program_desc){.compute = "shaders/resolve/tiles.comp", .defines = defines});
    variant->tried = true;
    return variant->program;
}

/* The lists' buffer has exactly their size: the second begins in its middle. */
static bool fit_buffers(kd_gpu *gpu, resolve_state *s, uint32_t tiles, uint32_t words)
{
    size_t size = sizeof(uint32_t) * KD_TILE_LISTS * (KD_TILE_HEAD + tiles);
    if (s->tile_lists.id == 0 || kd_gpu_buffer_size(gpu, s->tile_lists) != size) {
        kd_gpu_destroy_buffer(gpu, s->tile_lists);
        s->tile_lists = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = size, .name = "tiles"});
    }
    return s->tile_lists.id != 0 &&
           (words == 0 || kd_gpu_ensure_buffer(gpu, &s->tile_lights, sizeof(uint32_t) * tiles * words, 0,
                                               "lights of tiles") == KD_OK);
}

/* No groups along x and y, one along z; no item. */
static void clear_lists(kd_gpu *gpu, const resolve_state *s, uint32_t tiles)
{
    const size_t word = sizeof(uint32_t), head = KD_TILE_HEAD * word;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, s->tile_lists, 0, KD_TILE_LISTS * head, 0);
    for (size_t list = 0; list < KD_TILE_LISTS; list++)
        kd_gpu_fill_buffer(gpu, s->tile_lists, list * head + 2 * word, word, 1);
    kd_gpu_fill_buffer(gpu, s->tile_lists, KD_TILE_LISTS * head, KD_TILE_LISTS * tiles * word, KD_TILE_NONE);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

bool resolve_tiles_run(kd_system_context *context, resolve_state *s, bool lights)
{
    kd_gpu *gpu = context->gpu;
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    uint32_t tiles = tile_count(kd_singleton(context->world, kd_frame));
    uint32_t words = lights ? (lighting->light_count - lighting->directional_count + 31) / 32 : 0;
    if (!fit_buffers(gpu, s, tiles, words))
        return false;
    clear_lists(gpu, s, tiles);
    kd_gpu_bind_storage(gpu, 0, s->tile_lists);
    if (lights)
        kd_gpu_bind_storage(gpu, 1, s->tile_lights);
    kd_gpu_dispatch(gpu, tiles_program(gpu, s, lights), resolve_groups(tiles, TILES_GROUP), 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT);
    return true;
}

void resolve_tiles_dispatch(kd_gpu *gpu, const resolve_state *s, kd_gpu_program program, uint32_t list)
{
    kd_gpu_dispatch_indirect(gpu, program, s->tile_lists, list * KD_TILE_HEAD * sizeof(uint32_t));
}

void resolve_tiles_fini(kd_gpu *gpu, resolve_state *s)
{
    for (size_t i = 0; i < sizeof s->tiles / sizeof *s->tiles; i++)
        kd_gpu_destroy_program(gpu, s->tiles[i].program);
    kd_gpu_destroy_buffer(gpu, s->tile_lists);
    kd_gpu_destroy_buffer(gpu, s->tile_lights);
}
