/* System voxel_pages: brings segments of objects into and out of the pages of their layer as cascades move,
 * objects come, go or move for the first time. The CPU decides who is in and makes pages enough; the GPU
 * hands out the slots. */
#include "systems/voxel_pages/voxel_pages.h"

#include <stdlib.h>
#include <string.h>

#include "components/frame.h"
#include "components/light.h"
#include "components/scene_store.h"
#include "components/sky.h"
#include "components/svo.h"
#include "components/transform.h"
#include "runtime/core/log.h"
#include "systems/voxel_pages/light_unit.h"
#include "systems/voxel_pages/object_params.h"
#include "systems/voxel_pages/objects.h"
#include "systems/voxel_pages/page_layer.h"
#include "systems/voxel_pages/placement.h"
#include "systems/voxel_pages/stale.h"

typedef struct pages_state {
    page_programs programs;
    stale_parts stale;
    page_layer layers[KD_LAYER_COUNT];
    page_list ids; /* ids of an object's segments: kd_voxel_object.first_segment points here */
    object_params params;
    kd_query *lights, *skies;
} pages_state;

static uint32_t take_id(page_layer *layer)
{
    page_list *free_ids = &layer->free_ids;
    return free_ids->count ? ((uint32_t *)free_ids->items)[--free_ids->count] : layer->id_count++;
}

static void include_chunk(pages_state *state, kd_voxel_scene *scene, uint32_t object, uint32_t c,
                          uint32_t chunk)
{
    const kd_voxel_chunk *ch = &scene->chunks[chunk];
    kd_voxel_object *o = &scene->objects[object];
    page_layer *layer = &state->layers[voxel_layer_of(scene, o)];
    kd_voxel_pages *pages = &scene->pages[voxel_layer_of(scene, o)];
    for (uint32_t at = 0; at < ch->count; at += KD_SEGMENT_VOXELS) {
        uint32_t count = ch->count - at < KD_SEGMENT_VOXELS ? ch->count - at : KD_SEGMENT_VOXELS;
        segment_request *r = page_list_push(&layer->in, sizeof *r);
        uint32_t *id = page_list_push(&state->ids, sizeof *id);
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
    scene->pages[voxel_layer_of(scene, o)].changed = true;
}

static void exclude(pages_state *state, kd_voxel_scene *scene, kd_voxel_object *o, uint32_t c)
{
    page_layer *layer = &state->layers[voxel_layer_of(scene, o)];
    kd_voxel_pages *pages = &scene->pages[voxel_layer_of(scene, o)];
    const uint32_t *ids = (const uint32_t *)state->ids.items + o->first_segment[c];
    for (uint32_t i = 0; i < o->segment_count[c]; i++) {
        uint32_t *out = page_list_push(&layer->out, sizeof *out),
                 *back = page_list_push(&layer->free_ids, sizeof *back);
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
        stale_note(&state->stale, scene, o, c, false);
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
            stale_note(&state->stale, scene, o, c, true);
    }
    o->repaged = 0;
}

/* Frames for which spare pages are kept. */
#define KEEP_FRAMES 64

/* When most pages have been spare for a while, all segments of the layer leave, its buffers go, and what
 * stands in the cascades comes in again, into pages enough for it. */
static void shrink_layer(kd_gpu *gpu, pages_state *state, kd_voxel_scene *scene, uint32_t l)
{
    page_layer *layer = &state->layers[l];
    kd_voxel_pages *pages = &scene->pages[l];
    bool spare = pages->page_count > 2 * page_layer_needs(pages);
    layer->spare_frames = spare ? layer->spare_frames + 1 : 0;
    if (layer->spare_frames < KEEP_FRAMES)
        return;
    for (uint32_t i = 0; i < scene->object_count; i++) {
        kd_voxel_object *o = &scene->objects[i];
        for (uint32_t c = 0; o->alive && voxel_layer_of(scene, o) == l && c < scene->cascade_count; c++)
            if (o->segment_count[c]) {
                exclude(state, scene, o, c);
                o->repaged |= 1u << c;
            }
    }
    page_layer_clear(layer, gpu, pages);
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
    state->ids = (page_list){fresh, at, live + 1};
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
    scene->brightest_emission = brightest_emission(store, kd_singleton(context->world, kd_draw_list));
    scene->stored_unit = stored_unit(context->world, state->lights, state->skies, scene->brightest_emission);
    if (before != scene->brightest_emission)
        stale_add_all(&state->stale, scene);
    object_params_upload(&state->params, context->gpu, store, scene, &state->stale);
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++)
        page_layer_update(&state->layers[l], &state->programs, context->gpu, scene, (kd_voxel_layer)l);
    compact_ids(state, scene);
    if (stale_upload(&state->stale, context->gpu, scene) != KD_OK)
        kd_log(KD_LOG_WARNING, "voxel pages: no memory for what is stale; indirect light stays as it is");
    scene->placed = true;
}

static bool stales_again(kd_system_context *context)
{
    return kd_frame_needs_voxels(context) && kd_singleton(context->world, kd_svo)->again;
}

/* The tree had not room for all: everything comes anew. */
static void run_again(kd_system_context *context)
{
    pages_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    stale_add_all(&state->stale, scene);
    if (stale_upload(&state->stale, context->gpu, scene) != KD_OK)
        kd_log(KD_LOG_WARNING, "voxel pages: no memory for what is stale; indirect light stays as it is");
}

static kd_status init(kd_system_context *context)
{
    pages_state *state = context->user;
    state->lights = kd_query_make(
        context->world, &(kd_query_desc){.terms = {KD_READ(kd_light)}, .name = "voxel_pages.lights"});
    state->skies = kd_query_make(context->world,
                                 &(kd_query_desc){.terms = {KD_READ(kd_sky), KD_READ(kd_world_transform)},
                                                  .name = "voxel_pages.skies"});
    if (!state->lights || !state->skies)
        return KD_NO_MEMORY;
    return page_programs_init(&state->programs, context->gpu);
}

static void fini(kd_system_context *context)
{
    pages_state *state = context->user;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_query_destroy(state->lights);
    kd_query_destroy(state->skies);
    page_programs_fini(&state->programs, context->gpu);
    kd_gpu_buffer stale[] = {scene->stale, scene->stale_boxes};
    for (size_t i = 0; i < sizeof stale / sizeof *stale; i++)
        kd_gpu_destroy_buffer(context->gpu, stale[i]);
    stale_fini(&state->stale);
    kd_gpu_destroy_buffer(context->gpu, scene->object_params);
    for (uint32_t l = 0; l < KD_LAYER_COUNT; l++)
        page_layer_fini(&state->layers[l], context->gpu, &scene->pages[l]);
    object_params_fini(&state->params);
    free(state->ids.items);
    free(state);
}

static kd_status add_again(kd_schedule *s, pages_state *state)
{
    return kd_schedule_add(s,
                           &(kd_system_desc){
                               .name = "voxel_pages_again",
                               .phase = KD_PHASE_VOXEL_AGAIN,
                               .where = KD_ON_GPU,
                               .components = {KD_CHANGES(kd_voxel_scene), KD_USES(kd_svo), KD_USES(kd_frame)},
                               .resources = {{"voxels.stale", KD_USE_COPY_WRITE}},
                               .run_if = stales_again,
                               .no_commands = true,
                               .run = run_again,
                               .user = state,
                           });
}

kd_status kd_voxel_pages_import(kd_schedule *s)
{
    pages_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    kd_status status = add_again(s, state);
    if (status)
        return status;
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "voxel_pages",
               .phase = KD_PHASE_VOXEL_IO,
               .where = KD_ON_GPU,
               .components = {KD_CHANGES(kd_voxel_scene), KD_USES(kd_scene_store), KD_USES(kd_frame),
                              KD_USES(kd_draw_list), KD_USES(kd_light), KD_USES(kd_sky),
                              KD_USES(kd_sky_images), KD_USES(kd_world_transform)},
               .resources = {{"voxels.pages", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE},
                             {"voxels.cache", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
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
