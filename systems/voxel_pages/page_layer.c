/* Pages of one layer: made as they are needed, their slots handed out and taken back by the GPU. */
#include "systems/voxel_pages/page_layer.h"

#include <stdlib.h>

#include "runtime/core/log.h"

void *page_list_push(page_list *l, size_t size)
{
    if (l->count == l->capacity) {
        uint32_t capacity = l->capacity ? l->capacity * 2 : 64;
        void *grown = realloc(l->items, capacity * size);
        if (!grown)
            return NULL;
        l->items = grown;
        l->capacity = capacity;
    }
    return (char *)l->items + size * l->count++;
}

uint32_t page_layer_needs(const kd_voxel_pages *pages)
{
    return (pages->segment_count + KD_PAGE_SEGMENTS - 1) / KD_PAGE_SEGMENTS;
}

bool page_stream_ensure(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name)
{
    if (kd_gpu_buffer_size(gpu, *buffer) >= size)
        return true;
    kd_gpu_destroy_buffer(gpu, *buffer);
    *buffer = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = size + size / 2, .usage = KD_BUFFER_STREAM, .name = name});
    return buffer->id != 0;
}

enum {
    MOVING_PAGE_BYTES = KD_PAGE_VOXELS * KD_PAGE_WORDS * 4,
    BOUNDS_BYTES = KD_PAGE_SEGMENTS * KD_SEGMENT_GROUPS * 8
};

/* Pages of a layer that the driver binds at a time. */
static uint32_t most_pages(const kd_gpu *gpu, bool dynamic)
{
    return (uint32_t)(kd_gpu_get_info(gpu)->max_ssbo_bytes / (dynamic ? MOVING_PAGE_BYTES : BOUNDS_BYTES));
}

/* Errors TOO_LARGE when not all segments can have a page: there are as many then as there may be */
static kd_status make_pages(kd_gpu *gpu, kd_voxel_pages *pages, bool dynamic)
{
    uint32_t need = page_layer_needs(pages), before = pages->page_count, most = most_pages(gpu, dynamic);
    uint32_t count = need > before + before / 2 ? need : before + before / 2;
    kd_status enough = need > most ? KD_TOO_LARGE : KD_OK;
    count = count < most ? count : most;
    if (need <= before || count <= before)
        return enough;
    size_t stack = (KD_PAGE_SEGMENTS + 1) * 4, segments = KD_PAGE_SEGMENTS * sizeof(struct kd_voxel_segment);
    kd_status status =
        kd_gpu_ensure_buffer(gpu, &pages->segments, count * segments, before * segments, "voxels.segments");
    if (!status)
        status = kd_gpu_ensure_buffer(gpu, &pages->stacks, count * stack, before * stack, "voxels.stacks");
    if (!status && dynamic)
        status =
            kd_gpu_ensure_buffer(gpu, &pages->voxels, (size_t)count * MOVING_PAGE_BYTES, 0, "voxels.pages");
    else if (!status)
        status = kd_gpu_ensure_buffer(gpu, &pages->bounds, (size_t)count * BOUNDS_BYTES,
                                      (size_t)before * BOUNDS_BYTES, "voxels.bounds");
    if (status)
        return status;
    kd_gpu_fill_buffer(gpu, pages->segments, before * segments, (count - before) * segments, 0);
    uint32_t full[KD_PAGE_SEGMENTS + 1] = {KD_PAGE_SEGMENTS};
    for (uint32_t i = 0; i < KD_PAGE_SEGMENTS; i++)
        full[1 + i] = KD_PAGE_SEGMENTS - 1 - i;
    for (uint32_t p = before; p < count; p++)
        kd_gpu_write_buffer(gpu, pages->stacks, p * stack, full, stack);
    pages->page_count = count;
    return enough;
}

static void dispatch_list(kd_gpu *gpu, page_programs *programs, kd_gpu_program program,
                          const page_layer *layer, const kd_voxel_pages *pages, const page_list *items,
                          size_t size)
{
    if (!items->count ||
        !page_stream_ensure(gpu, &programs->requests, items->count * size, "voxels.requests"))
        return;
    kd_gpu_write_buffer(gpu, programs->requests, 0, items->items, items->count * size);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    uint32_t pass[4] = {items->count, pages->page_count, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, programs->requests);
    kd_gpu_bind_storage(gpu, 1, layer->slots);
    kd_gpu_bind_storage(gpu, 2, pages->segments);
    kd_gpu_bind_storage(gpu, 3, pages->stacks);
    kd_gpu_dispatch(gpu, program, (items->count + 63) / 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

/* Boxes of the groups of voxels in the segments that were just allocated. */
static void bound_groups(kd_gpu *gpu, page_programs *programs, const kd_voxel_scene *scene,
                         const page_layer *layer)
{
    uint32_t pass[4] = {layer->in.count, 0, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, programs->requests);
    kd_gpu_bind_storage(gpu, 1, layer->slots);
    kd_texel_view_bind(gpu, &programs->shape_view, 0, scene->cache_shape, KD_RG32UI);
    kd_gpu_bind_storage(gpu, 3, scene->pages[KD_LAYER_STATIC].bounds);
    kd_gpu_dispatch_linear(gpu, programs->bounds, (layer->in.count * KD_SEGMENT_GROUPS + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void say_short(const kd_gpu *gpu, page_layer *layer, const kd_voxel_pages *pages, bool dynamic,
                      kd_status status)
{
    uint32_t voxels = most_pages(gpu, dynamic) * KD_PAGE_VOXELS;
    if (layer->said_short)
        return;
    layer->said_short = true;
    if (status == KD_TOO_LARGE)
        kd_log(KD_LOG_WARNING,
               "voxel pages: the driver binds %u voxels that %s at a time, of %llu; indirect light lacks "
               "those that "
               "came last; raise voxels.span",
               voxels, dynamic ? "move" : "stand still", (unsigned long long)pages->voxel_count);
    else
        kd_log(KD_LOG_WARNING, "voxel pages: %s; indirect light lacks some objects; raise voxels.span",
               kd_status_text(status));
}

void page_layer_update(page_layer *layer, page_programs *programs, kd_gpu *gpu, kd_voxel_scene *scene,
                       kd_voxel_layer which)
{
    kd_voxel_pages *pages = &scene->pages[which];
    dispatch_list(gpu, programs, programs->free, layer, pages, &layer->out, 4);
    if (layer->in.count) {
        size_t have = layer->slots.id ? kd_gpu_buffer_size(gpu, layer->slots) : 0;
        kd_status made = make_pages(gpu, pages, which == KD_LAYER_DYNAMIC), status = KD_OK;
        if (have < (size_t)layer->id_count * 4)
            status =
                kd_gpu_ensure_buffer(gpu, &layer->slots, (size_t)layer->id_count * 8, have, "voxels.slots");
        if (made || status)
            say_short(gpu, layer, pages, which == KD_LAYER_DYNAMIC, made ? made : status);
        bool some = !status && pages->page_count > 0;
        if (some)
            dispatch_list(gpu, programs, programs->allocate, layer, pages, &layer->in,
                          sizeof(segment_request));
        if (some && which == KD_LAYER_STATIC)
            bound_groups(gpu, programs, scene, layer);
    }
    layer->in.count = layer->out.count = 0;
}

static void destroy_pages(kd_gpu *gpu, page_layer *layer, kd_voxel_pages *pages)
{
    kd_gpu_buffer *buffers[] = {&pages->segments, &pages->stacks, &pages->voxels, &pages->bounds,
                                &layer->slots};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        kd_gpu_destroy_buffer(gpu, *buffers[i]);
        *buffers[i] = (kd_gpu_buffer){0};
    }
}

void page_layer_clear(page_layer *layer, kd_gpu *gpu, kd_voxel_pages *pages)
{
    destroy_pages(gpu, layer, pages);
    pages->page_count = layer->id_count = layer->spare_frames = 0;
    layer->out.count = layer->free_ids.count = 0;
}

void page_layer_fini(page_layer *layer, kd_gpu *gpu, kd_voxel_pages *pages)
{
    destroy_pages(gpu, layer, pages);
    *pages = (kd_voxel_pages){0};
    free(layer->in.items);
    free(layer->out.items);
    free(layer->free_ids.items);
}

kd_status page_programs_init(page_programs *programs, kd_gpu *gpu)
{
    programs->allocate =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_pages/allocate.comp"});
    programs->free =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_pages/free.comp"});
    programs->bounds =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_pages/bounds.comp"});
    return programs->allocate.id && programs->free.id && programs->bounds.id ? KD_OK : KD_GPU;
}

void page_programs_fini(page_programs *programs, kd_gpu *gpu)
{
    kd_gpu_destroy_program(gpu, programs->allocate);
    kd_gpu_destroy_program(gpu, programs->free);
    kd_gpu_destroy_program(gpu, programs->bounds);
    kd_texel_view_fini(gpu, &programs->shape_view);
    kd_gpu_destroy_buffer(gpu, programs->requests);
}
