/* System voxel_pages: brings segments of objects into and out of the pages of their layer as cascades move,
 * objects come, go or move for the first time. The CPU decides who is in and makes pages enough; the GPU
 * hands out the slots. */
#include "systems/voxel_pages/voxel_pages.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "components/frame.h"
#include "components/light.h"
#include "components/scene_store.h"
#include "runtime/core/arena.h"
#include "runtime/core/log.h"
#include "systems/voxel_pages/objects.h"
#include "systems/voxel_pages/placement.h"
#include "systems/voxel_pages/stale.h"

typedef struct segment_request {
    struct kd_voxel_segment segment;
    uint32_t id, spare[3];
} segment_request;

/* A growing list that keeps its memory between frames. */
typedef struct list {
    void *items;
    uint32_t count, capacity;
} list;

typedef struct layer_pages {
    kd_gpu_buffer slots; /* slot of every segment id */
    uint32_t id_count;
    list in, out;          /* segment_request, uint32_t ids */
    list free_ids;         /* ids to use again */
    uint32_t spare_frames; /* in a row in which more than half of the pages were spare */
    bool said_short;       /* that not all of it has pages */
} layer_pages;

typedef struct pages_state {
    kd_gpu_program allocate, free, bounds;
    stale_parts stale;
    kd_gpu_buffer requests;
    layer_pages layers[KD_LAYER_COUNT];
    list ids; /* ids of an object's segments: kd_voxel_object.first_segment points here */
    struct kd_voxel_object_params *params;
    uint32_t params_capacity;
    kd_query *lights;
} pages_state;

static void *list_push(list *l, size_t size)
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

static kd_voxel_layer layer_of(const kd_voxel_scene *scene, const kd_voxel_object *o)
{
    return o->dynamic || scene->one_layer ? KD_LAYER_DYNAMIC : KD_LAYER_STATIC;
}

static uint32_t take_id(layer_pages *layer)
{
    list *free_ids = &layer->free_ids;
    return free_ids->count ? ((uint32_t *)free_ids->items)[--free_ids->count] : layer->id_count++;
}

static void include_chunk(pages_state *state, kd_voxel_scene *scene, uint32_t object, uint32_t c,
                          uint32_t chunk)
{
    const kd_voxel_chunk *ch = &scene->chunks[chunk];
    kd_voxel_object *o = &scene->objects[object];
    layer_pages *layer = &state->layers[layer_of(scene, o)];
    kd_voxel_pages *pages = &scene->pages[layer_of(scene, o)];
    for (uint32_t at = 0; at < ch->count; at += KD_SEGMENT_VOXELS) {
        uint32_t count = ch->count - at < KD_SEGMENT_VOXELS ? ch->count - at : KD_SEGMENT_VOXELS;
        segment_request *r = list_push(&layer->in, sizeof *r);
        uint32_t *id = list_push(&state->ids, sizeof *id);
        if (!r || !id)
            return;
        *id = take_id(layer);
        *r = (segment_request){.segment = {object, ch->first + at, count, chunk | c << 28}, .id = *id};
        o->segment_count[c]++;
        pages->segment_count++;
        pages->voxel_count += count;
    }
}

static void include(pages_state *state, kd_voxel_scene *scene, uint32_t object, uint32_t c)
{
    kd_voxel_object *o = &scene->objects[object];
    if (!o->caches[c])
        return;
    const kd_voxel_cache *cache = &scene->caches[o->caches[c] - 1];
    if (!cache->made || cache->voxel_count == 0)
        return;
    o->first_segment[c] = state->ids.count;
    o->voxels[c] = cache->voxel_count;
    for (uint32_t i = 0; i < cache->chunk_count; i++)
        include_chunk(state, scene, object, c, cache->first_chunk + i);
    scene->pages[layer_of(scene, o)].changed = true;
}

static void exclude(pages_state *state, kd_voxel_scene *scene, kd_voxel_object *o, uint32_t c)
{
    layer_pages *layer = &state->layers[layer_of(scene, o)];
    kd_voxel_pages *pages = &scene->pages[layer_of(scene, o)];
    const uint32_t *ids = (const uint32_t *)state->ids.items + o->first_segment[c];
    for (uint32_t i = 0; i < o->segment_count[c]; i++) {
        uint32_t *out = list_push(&layer->out, sizeof *out),
                 *back = list_push(&layer->free_ids, sizeof *back);
        if (out)
            *out = ids[i];
        if (back)
            *back = ids[i];
    }
    pages->segment_count -= o->segment_count[c];
    pages->voxel_count -= o->voxels[c];
    pages->changed = true;
    o->segment_count[c] = 0;
    o->voxels[c] = 0;
}

static bool stands_in(const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c)
{
    return (o->cascades >> c & 1u) && placement_includes(scene, c, o->bounds_min_ws, o->bounds_max_ws);
}

/* Static objects that leave cascade c while its region stays leave a stale place behind, and so do those that
 * come to where the region was before. What comes and goes by the cascades' move alone is in what that made
 * stale. */
static void note_stale(pages_state *state, const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c,
                       bool comes)
{
    if (layer_of(scene, o) == KD_LAYER_STATIC &&
        (comes ? placement_included(scene, c, o->placed_min_ws, o->placed_max_ws)
               : placement_includes(scene, c, o->placed_min_ws, o->placed_max_ws)))
        stale_add(&state->stale, scene, c, o->placed_min_ws, o->placed_max_ws);
}

static void update_object(pages_state *state, kd_voxel_scene *scene, uint32_t index)
{
    kd_voxel_object *o = &scene->objects[index];
    bool leave_all = !o->seen || o->becomes_dynamic || o->recache;
    for (uint32_t c = 0; c < scene->cascade_count; c++) {
        bool want = o->seen && o->caches[c] && stands_in(scene, o, c);
        bool is_in = o->segment_count[c] || (o->repaged >> c & 1u);
        if (!is_in || !(leave_all || !want))
            continue;
        if (o->segment_count[c])
            exclude(state, scene, o, c);
        note_stale(state, scene, o, c, false);
        o->repaged &= ~(1u << c);
    }
    if (o->becomes_dynamic)
        o->dynamic = true;
    o->becomes_dynamic = o->recache = false;
    for (uint32_t c = 0; c < scene->cascade_count; c++) {
        if (!o->seen || o->segment_count[c] || !stands_in(scene, o, c))
            continue;
        include(state, scene, index, c);
        o->placed_min_ws = o->bounds_min_ws;
        o->placed_max_ws = o->bounds_max_ws;
        if (o->segment_count[c] && !(o->repaged >> c & 1u))
            note_stale(state, scene, o, c, true);
    }
    o->repaged = 0;
}

/* Frames for which spare pages are kept. */
#define KEEP_FRAMES 64

static uint32_t pages_needed(const kd_voxel_pages *pages)
{
    return (pages->segment_count + KD_PAGE_SEGMENTS - 1) / KD_PAGE_SEGMENTS;
}

/* When most pages have been spare for a while, all segments of the layer leave, its buffers go, and what
 * stands in the cascades comes in again, into pages enough for it. */
static void shrink_layer(kd_gpu *gpu, pages_state *state, kd_voxel_scene *scene, uint32_t l)
{
    layer_pages *layer = &state->layers[l];
    kd_voxel_pages *pages = &scene->pages[l];
    bool spare = pages->page_count > 2 * pages_needed(pages);
    layer->spare_frames = spare ? layer->spare_frames + 1 : 0;
    if (layer->spare_frames < KEEP_FRAMES)
        return;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        kd_voxel_object *o = &scene->objects[i];
        for (uint32_t c = 0; o->alive && layer_of(scene, o) == l && c < scene->cascade_count; c++)
            if (o->segment_count[c]) {
                exclude(state, scene, o, c);
                o->repaged |= 1u << c;
            }
    }
    kd_gpu_buffer *buffers[] = {&pages->segments, &pages->stacks, &pages->voxels, &pages->bounds,
                                &layer->slots};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        kd_gpu_destroy_buffer(gpu, *buffers[i]);
        *buffers[i] = (kd_gpu_buffer){0};
    }
    pages->page_count = layer->id_count = layer->spare_frames = 0;
    layer->out.count = layer->free_ids.count = 0;
}

/* Ids lie in one list; when most of it is stale it is rewritten without the gaps. */
static void compact_ids(pages_state *state, kd_voxel_scene *scene)
{
    uint32_t live = scene->pages[0].segment_count + scene->pages[1].segment_count;
    if (state->ids.count < 4096 || state->ids.count < live * 3)
        return;
    uint32_t *fresh = malloc(((size_t)live + 1) * sizeof *fresh), at = 0;
    if (!fresh)
        return;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        kd_voxel_object *o = &scene->objects[i];
        for (uint32_t c = 0; o->alive && c < scene->cascade_count; c++) {
            memcpy(fresh + at, (uint32_t *)state->ids.items + o->first_segment[c],
                   o->segment_count[c] * sizeof *fresh);
            o->first_segment[c] = at;
            at += o->segment_count[c];
        }
    }
    free(state->ids.items);
    state->ids = (list){fresh, at, live + 1};
}

/* ---- GPU side ---- */

/* A buffer that the CPU writes, of at least `size` bytes; contents are not kept. */
static bool ensure_stream(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name)
{
    if (kd_gpu_buffer_size(gpu, *buffer) >= size)
        return true;
    kd_gpu_destroy_buffer(gpu, *buffer);
    *buffer = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = size + size / 2, .usage = KD_BUFFER_STREAM, .name = name});
    return buffer->id != 0;
}

enum { MOVING_PAGE_BYTES = KD_PAGE_VOXELS * KD_PAGE_WORDS * 4, BOUNDS_BYTES = KD_PAGE_SEGMENTS * KD_SEGMENT_GROUPS * 8 };

/* Pages of a layer that the driver binds at a time. */
static uint32_t most_pages(const kd_gpu *gpu, bool dynamic)
{
    return (uint32_t)(kd_gpu_get_info(gpu)->max_ssbo_bytes / (dynamic ? MOVING_PAGE_BYTES : BOUNDS_BYTES));
}

/* Errors TOO_LARGE when not all segments can have a page: there are as many then as there may be */
static kd_status make_pages(kd_gpu *gpu, kd_voxel_pages *pages, bool dynamic)
{
    uint32_t need = pages_needed(pages), before = pages->page_count, most = most_pages(gpu, dynamic);
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

static void dispatch_list(kd_gpu *gpu, pages_state *state, kd_gpu_program program, const layer_pages *layer,
                          const kd_voxel_pages *pages, const list *items, size_t size)
{
    if (!items->count || !ensure_stream(gpu, &state->requests, items->count * size, "voxels.requests"))
        return;
    kd_gpu_write_buffer(gpu, state->requests, 0, items->items, items->count * size);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    uint32_t pass[4] = {items->count, pages->page_count, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, state->requests);
    kd_gpu_bind_storage(gpu, 1, layer->slots);
    kd_gpu_bind_storage(gpu, 2, pages->segments);
    kd_gpu_bind_storage(gpu, 3, pages->stacks);
    kd_gpu_dispatch(gpu, program, (items->count + 63) / 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}

/* Boxes of the groups of voxels in the segments that were just allocated. */
static void bound_groups(kd_gpu *gpu, const pages_state *state, const kd_voxel_scene *scene,
                         const layer_pages *layer)
{
    uint32_t pass[4] = {layer->in.count, 0, 0, 0};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, state->requests);
    kd_gpu_bind_storage(gpu, 1, layer->slots);
    kd_gpu_bind_storage(gpu, 2, scene->cache_shape);
    kd_gpu_bind_storage(gpu, 3, scene->pages[KD_LAYER_STATIC].bounds);
    kd_gpu_dispatch_linear(gpu, state->bounds, (layer->in.count * KD_SEGMENT_GROUPS + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void say_short(const kd_gpu *gpu, layer_pages *layer, const kd_voxel_pages *pages, bool dynamic,
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

/* Segments for which there is no page stay without a slot, in the shaders' eyes too. */
static void update_layer(kd_gpu *gpu, pages_state *state, kd_voxel_scene *scene, uint32_t l)
{
    layer_pages *layer = &state->layers[l];
    kd_voxel_pages *pages = &scene->pages[l];
    dispatch_list(gpu, state, state->free, layer, pages, &layer->out, 4);
    if (layer->in.count) {
        size_t have = layer->slots.id ? kd_gpu_buffer_size(gpu, layer->slots) : 0;
        kd_status made = make_pages(gpu, pages, l == KD_LAYER_DYNAMIC), status = KD_OK;
        if (have < (size_t)layer->id_count * 4)
            status =
                kd_gpu_ensure_buffer(gpu, &layer->slots, (size_t)layer->id_count * 8, have, "voxels.slots");
        if (made || status)
            say_short(gpu, layer, pages, l == KD_LAYER_DYNAMIC, made ? made : status);
        bool some = !status && pages->page_count > 0;
        if (some)
            dispatch_list(gpu, state, state->allocate, layer, pages, &layer->in, sizeof(segment_request));
        if (some && l == KD_LAYER_STATIC)
            bound_groups(gpu, state, scene, layer);
    }
    layer->in.count = layer->out.count = 0;
}

static kd_vec3 emission_of(const kd_scene_store *store, const kd_voxel_object *o)
{
    return store->materials[o->material].desc.emissive;
}

/* Of all that is drawn, wherever it is: what comes near then changes nothing. */
static float brightest(const kd_scene_store *store, const kd_draw_list *drawn)
{
    float best = 0;
    for (uint32_t i = 0; i < drawn->batch_count; i++) {
        kd_vec3 e = store->materials[drawn->batches[i].material].desc.emissive;
        if (drawn->batches[i].voxels)
            best = fmaxf(best, fmaxf(e.x, fmaxf(e.y, e.z)));
    }
    return best;
}

/* Radiance that the tree stores as 1, a power of two: 1 in ordinary light, more under a sun in lux, so that
 * half floats hold what is lit. Point lights count at a quarter of a metre; what is nearer may saturate. */
static float stored_unit(kd_query *lights, float emission)
{
    const float near_m = 0.25f, comfortable = 1024;
    float best = emission;
    for (kd_iter it = kd_query_iter(lights); kd_iter_next(&it);) {
        const kd_light *light = KD_COLUMN(&it, kd_light, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            float color = fmaxf(light[i].color.x, fmaxf(light[i].color.y, light[i].color.z));
            float e = light[i].intensity * color / (light[i].type == KD_DIRECTIONAL ? 1.0f : near_m * near_m);
            best = fmaxf(best, e * (1 / 3.14159265f));
        }
    }
    return best > comfortable && isfinite(best) ? exp2f(ceilf(log2f(best / comfortable))) : 1.0f;
}

static void fill_params(const kd_scene_store *store, const kd_voxel_scene *scene, const kd_voxel_object *o,
                        struct kd_voxel_object_params *p)
{
    const float *m = o->model_ws.m;
    for (int r = 0; r < 3; r++)
        p->model_ws[r] = (kd_gl_vec4){m[r], m[4 + r], m[8 + r], m[12 + r]};
    /* rows of the cofactor matrix: the inverse transpose up to a factor, and defined for flat matrices too */
    kd_vec3 x = {m[0], m[1], m[2]}, y = {m[4], m[5], m[6]}, z = {m[8], m[9], m[10]};
    kd_vec3 cx = kd_vec3_cross(y, z), cy = kd_vec3_cross(z, x), cz = kd_vec3_cross(x, y);
    float sign = kd_vec3_dot(x, cx) < 0 ? -1.0f : 1.0f;
    p->normal_ws[0] = (kd_gl_vec4){sign * cx.x, sign * cy.x, sign * cz.x, 0};
    p->normal_ws[1] = (kd_gl_vec4){sign * cx.y, sign * cy.y, sign * cz.y, 0};
    p->normal_ws[2] = (kd_gl_vec4){sign * cx.z, sign * cy.z, sign * cz.z, 0};
    const kd_store_primitive *d =
        o->deformed ? &store->deformed_primitives[o->deformed - 1] : &store->primitives[o->primitive];
    p->info =
        (kd_gl_uvec4){o->kind, o->first_matrix, store->primitives[o->primitive].first_index, d->base_vertex};
    kd_vec3 e = emission_of(store, o);
    float scale = scene->brightest_emission > 0 ? 1 / scene->brightest_emission : 0;
    p->emission = (kd_gl_vec4){e.x * scale, e.y * scale, e.z * scale, 0};
}

/* The parameters from the first to the last that changed go up: 128 bytes an object. Where a static object's
 * emission changed its place is stale. */
static void upload_params(kd_gpu *gpu, pages_state *state, const kd_scene_store *store, kd_voxel_scene *scene)
{
    uint32_t n = scene->object_count;
    if (n > state->params_capacity) {
        struct kd_voxel_object_params *grown = realloc(state->params, (size_t)n * 2 * sizeof *grown);
        if (!grown)
            return;
        memset(grown, 0, (size_t)n * 2 * sizeof *grown);
        state->params = grown;
        state->params_capacity = n * 2;
    }
    size_t size = sizeof *state->params;
    uint32_t first = n, end = 0;
    bool made = n && kd_gpu_buffer_size(gpu, scene->object_params) < state->params_capacity * size;
    if (!n || !ensure_stream(gpu, &scene->object_params, state->params_capacity * size, "voxels.objects"))
        return;
    for (uint32_t i = 0; i < n; i++) {
        if (!scene->objects[i].alive)
            continue; /* its primitive is a link of the free list */
        struct kd_voxel_object_params before = state->params[i];
        fill_params(store, scene, &scene->objects[i], &state->params[i]);
        if (memcmp(&before, &state->params[i], size) == 0)
            continue;
        first = i < first ? i : first;
        end = i + 1;
        if (memcmp(&before.emission, &state->params[i].emission, sizeof before.emission) != 0)
            for (uint32_t c = 0; c < scene->cascade_count; c++)
                if (scene->objects[i].segment_count[c])
                    note_stale(state, scene, &scene->objects[i], c, false);
    }
    if (made)
        first = 0, end = n;
    if (first < end)
        kd_gpu_write_buffer(gpu, scene->object_params, first * size, state->params + first,
                            (end - first) * size);
}

static void run(kd_system_context *context)
{
    pages_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++)
        scene->pages[l].changed = false;
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++)
        shrink_layer(context->gpu, state, scene, l);
    if (stale_begin(&state->stale, scene) != KD_OK) {
        kd_log(KD_LOG_WARNING, "out of memory for the static voxels; indirect light stays as it is");
        return;
    }
    for (uint32_t i = 0; i < scene->object_count; i++) {
        if (!scene->objects[i].alive)
            continue;
        update_object(state, scene, i);
        if (!scene->objects[i].seen)
            objects_forget(scene->internal, scene, i);
    }
    float before = scene->brightest_emission;
    scene->brightest_emission = brightest(store, kd_singleton(context->world, kd_draw_list));
    scene->stored_unit = stored_unit(state->lights, scene->brightest_emission);
    if (before != scene->brightest_emission)
        stale_add_all(&state->stale, scene);
    upload_params(context->gpu, state, store, scene);
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++)
        update_layer(context->gpu, state, scene, l);
    compact_ids(state, scene);
    if (stale_upload(&state->stale, context->gpu, scene) != KD_OK)
        kd_log(KD_LOG_WARNING, "voxel pages: no memory for what is stale; indirect light stays as it is");
    scene->placed = true;
}

static kd_status init(kd_system_context *context)
{
    pages_state *state = context->user;
    state->lights = kd_query_make(
        context->world, &(kd_query_desc){.terms = {KD_READ(kd_light)}, .name = "voxel_pages.lights"});
    if (!state->lights)
        return KD_NO_MEMORY;
    state->allocate = kd_gpu_make_program(
        context->gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_pages/allocate.comp"});
    state->free =
        kd_gpu_make_program(context->gpu, &(kd_gpu_program_desc){.compute = "shaders/voxel_pages/free.comp"});
    state->bounds = kd_gpu_make_program(context->gpu,
                                        &(kd_gpu_program_desc){.compute = "shaders/voxel_pages/bounds.comp"});
    return state->allocate.id && state->free.id && state->bounds.id ? KD_OK : KD_GPU;
}

static void fini(kd_system_context *context)
{
    pages_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_query_destroy(state->lights);
    kd_gpu_destroy_program(context->gpu, state->allocate);
    kd_gpu_destroy_program(context->gpu, state->free);
    kd_gpu_destroy_program(context->gpu, state->bounds);
    kd_gpu_buffer stale[] = {scene->stale, scene->stale_boxes};
    for (size_t i = 0; i < sizeof stale / sizeof *stale; i++)
        kd_gpu_destroy_buffer(context->gpu, stale[i]);
    stale_fini(&state->stale);
    kd_gpu_destroy_buffer(context->gpu, state->requests);
    kd_gpu_destroy_buffer(context->gpu, scene->object_params);
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++) {
        layer_pages *layer = &state->layers[l];
        kd_gpu_destroy_buffer(context->gpu, layer->slots);
        kd_gpu_destroy_buffer(context->gpu, scene->pages[l].segments);
        kd_gpu_destroy_buffer(context->gpu, scene->pages[l].stacks);
        kd_gpu_destroy_buffer(context->gpu, scene->pages[l].voxels);
        kd_gpu_destroy_buffer(context->gpu, scene->pages[l].bounds);
        scene->pages[l] = (kd_voxel_pages){0};
        free(layer->in.items);
        free(layer->out.items);
        free(layer->free_ids.items);
    }
    free(state->ids.items);
    free(state->params);
    free(state);
}

kd_status kd_voxel_pages_import(kd_schedule *s)
{
    pages_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "voxel_pages",
               .phase = KD_PHASE_VOXEL_IO,
               .where = KD_ON_GPU,
               .components = {KD_CHANGES(kd_voxel_scene), KD_USES(kd_scene_store), KD_USES(kd_frame),
                              KD_USES(kd_draw_list), KD_USES(kd_light)},
               .resources = {{"voxels.pages", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE},
                             {"voxels.cache", KD_USE_STORAGE_READ},
                             {"voxels.stale", KD_USE_COPY_WRITE},
                             {"voxels.objects", KD_USE_COPY_WRITE}},
               .run_if = kd_frame_needs_voxels,
               .no_commands = true,
               .run = run,
               .init = init,
               .fini = fini,
               .user = state,
           });
}
