#include "systems/voxel_pages/stale.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "systems/voxel_pages/placement.h"

/* A box of dense cells, from the world's origin. */
typedef struct span_box {
    int32_t low[3], high[3];
} span_box;

static int32_t brick_cells(const kd_voxel_scene *scene)
{
    return (int32_t)(scene->resolution / KD_DENSE);
}

static span_box window(const kd_voxel_scene *scene, const int32_t origin[3])
{
    span_box b;
    for (int k = 0; k < 3; k++) {
        b.low[k] = origin[k] / brick_cells(scene); /* whole: cascades snap to dense cells */
        b.high[k] = b.low[k] + KD_DENSE;
    }
    return b;
}

/* The part of cascade c that the finer one covers, in dense cells of c. */
static span_box inner_window(const kd_voxel_scene *scene, int32_t origins[][3], uint32_t c)
{
    span_box b = window(scene, origins[c]);
    for (int k = 0; k < 3; k++) {
        b.low[k] += KD_DENSE / 4;
        b.high[k] -= KD_DENSE / 4;
    }
    return b;
}

static bool clip(span_box *b, const span_box *by)
{
    bool any = true;
    for (int k = 0; k < 3; k++) {
        b->low[k] = b->low[k] > by->low[k] ? b->low[k] : by->low[k];
        b->high[k] = b->high[k] < by->high[k] ? b->high[k] : by->high[k];
        any = any && b->low[k] < b->high[k];
    }
    return any;
}

/* `filled`: voxels may lie there; else it is only emptied. */
static void push(stale_parts *stale, const kd_voxel_scene *scene, uint32_t c, span_box b, bool filled)
{
    span_box all = window(scene, scene->origin_cells[c]);
    if (!clip(&b, &all))
        return;
    if (stale->count == stale->capacity) {
        uint32_t capacity = stale->capacity ? stale->capacity * 2 : 64;
        struct kd_stale_box *grown = realloc(stale->boxes, capacity * sizeof *grown);
        if (!grown) {
            stale_add_all(stale, scene);
            return;
        }
        stale->boxes = grown;
        stale->capacity = capacity;
    }
    int32_t n = brick_cells(scene);
    struct kd_stale_box *out = &stale->boxes[stale->count++];
    int32_t *low = &out->low.x, *high = &out->high.x;
    for (int k = 0; k < 3; k++) {
        low[k] = (b.low[k] - all.low[k]) * n;
        high[k] = (b.high[k] - all.low[k]) * n;
    }
    out->low.w = (int32_t)c;
    out->high.w = filled;
}

/* What of `a` is not in `b`: at most two slabs an axis. */
static void push_difference(stale_parts *stale, const kd_voxel_scene *scene, uint32_t c, span_box a,
                            const span_box *b, bool filled)
{
    span_box common = a;
    if (!clip(&common, b)) {
        push(stale, scene, c, a, filled);
        return;
    }
    for (int k = 0; k < 3; k++) {
        span_box slab = a;
        slab.high[k] = common.low[k];
        if (slab.low[k] < slab.high[k])
            push(stale, scene, c, slab, filled);
        slab = a;
        slab.low[k] = common.high[k];
        if (slab.low[k] < slab.high[k])
            push(stale, scene, c, slab, filled);
        a.low[k] = common.low[k];
        a.high[k] = common.high[k];
    }
}

/* Words of the masks of leaf parents, all cascades: 256 cells each. */
static uint32_t patch_words(const kd_voxel_scene *scene)
{
    return scene->cascade_count << (3 * scene->resolution_log2 - 8);
}

kd_status stale_begin(stale_parts *stale, const kd_voxel_scene *scene)
{
    int32_t now[KD_MAX_CASCADES][3], before[KD_MAX_CASCADES][3];
    memcpy(now, scene->origin_cells, sizeof now);
    memcpy(before, scene->previous_cells, sizeof before);
    stale->count = 0;
    stale->all = false;
    if (!stale->bits)
        stale->bits = calloc(KD_MAX_CASCADES, KD_DENSE_WORDS * sizeof *stale->bits);
    if (!stale->patches)
        stale->patches = calloc(patch_words(scene), sizeof *stale->patches);
    if (!stale->bits || !stale->patches)
        return KD_NO_MEMORY;
    if (!scene->placed)
        stale_add_all(stale, scene);
    for (uint32_t c = 0; c < scene->cascade_count && scene->placed; c++) {
        span_box outer = window(scene, before[c]);
        push_difference(stale, scene, c, window(scene, now[c]), &outer, true);
        if (c == 0)
            continue;
        span_box inner = inner_window(scene, now, c), was = inner_window(scene, before, c);
        push_difference(stale, scene, c, inner, &was, false);
        push_difference(stale, scene, c, was, &inner, true);
    }
    return KD_OK;
}

void stale_add(stale_parts *stale, const kd_voxel_scene *scene, uint32_t c, kd_vec3 low, kd_vec3 high)
{
    if (stale->all)
        return;
    float edge = scene->span[c] * (float)brick_cells(scene), reach = 2 * scene->span[c];
    span_box b, all = window(scene, scene->origin_cells[c]);
    for (int k = 0; k < 3; k++) {
        float from = floorf(((&low.x)[k] - reach) / edge), to = floorf(((&high.x)[k] + reach) / edge);
        b.low[k] = from > (float)all.low[k] ? (int32_t)from : all.low[k];
        b.high[k] = to < (float)all.high[k] ? (int32_t)to + 1 : all.high[k];
        if (b.low[k] >= b.high[k])
            return;
    }
    push(stale, scene, c, b, true);
}

kd_voxel_layer voxel_layer_of(const kd_voxel_scene *scene, const kd_voxel_object *o)
{
    return o->dynamic || scene->one_layer ? KD_LAYER_DYNAMIC : KD_LAYER_STATIC;
}

void stale_note(stale_parts *stale, const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c,
                bool comes)
{
    if (voxel_layer_of(scene, o) == KD_LAYER_STATIC &&
        (comes ? placement_included(scene, c, o->placed_min_ws, o->placed_max_ws)
               : placement_includes(scene, c, o->placed_min_ws, o->placed_max_ws)))
        stale_add(stale, scene, c, o->placed_min_ws, o->placed_max_ws);
}

void stale_add_all(stale_parts *stale, const kd_voxel_scene *scene)
{
    if (stale->all)
        return;
    stale->all = true;
    stale->count = 0;
    for (uint32_t c = 0; c < scene->cascade_count; c++)
        push(stale, scene, c, window(scene, scene->origin_cells[c]), true);
}

static uint32_t spread(uint32_t v)
{
    uint32_t out = 0;
    for (uint32_t i = 0; i < KD_DENSE_LOG2; i++)
        out |= (v >> i & 1u) << (3 * i);
    return out;
}

static void set_bits(stale_parts *stale, const kd_voxel_scene *scene, const struct kd_stale_box *box)
{
    uint32_t code[3][KD_DENSE];
    uint32_t c = (uint32_t)box->low.w, *bits = stale->bits + c * KD_DENSE_WORDS;
    int32_t n = brick_cells(scene), low[3], high[3];
    for (int k = 0; k < 3; k++) {
        int32_t corner = scene->origin_cells[c][k] / n;
        low[k] = (&box->low.x)[k] / n;
        high[k] = (&box->high.x)[k] / n;
        for (int32_t i = low[k]; i < high[k]; i++)
            code[k][i] = spread((uint32_t)(corner + i) & (KD_DENSE - 1)) << k;
    }
    for (int32_t z = low[2]; z < high[2]; z++)
        for (int32_t y = low[1]; y < high[1]; y++)
            for (int32_t x = low[0]; x < high[0]; x++) {
                uint32_t at = code[0][x] | code[1][y] | code[2][z];
                bits[at >> 5] |= 1u << (at & 31);
            }
}

/* A brick is a bit, a byte, two or sixteen words of leaf parents. */
static void list_patches(stale_parts *stale, const kd_voxel_scene *scene)
{
    uint32_t words = scene->cascade_count * KD_DENSE_WORDS, *out = stale->patches, n = 0;
    uint32_t levels = scene->resolution_log2 - KD_DENSE_LOG2,
             of_brick = levels > 2 ? 1u << (3 * levels - 8) : 0;
    for (uint32_t w = 0; w < words; w++) {
        uint32_t bits = stale->bits[w];
        if (levels == 1 && bits)
            out[n++] = w;
        for (uint32_t i = 0; levels == 2 && i < 8 && bits; i++)
            if (bits >> (4 * i) & 15)
                out[n++] = w * 8 + i;
        for (uint32_t i = 0; levels > 2 && i < 32 && bits; i++)
            for (uint32_t k = 0; k < of_brick && bits >> i & 1; k++)
                out[n++] = (w * 32 + i) * of_brick + k;
    }
    stale->patch_count = n;
}

kd_status stale_upload(stale_parts *stale, kd_gpu *gpu, kd_voxel_scene *scene)
{
    uint32_t bits = scene->cascade_count * KD_DENSE_WORDS, patches = patch_words(scene);
    struct kd_stale_places *p = &scene->stale_places;
    *p = (struct kd_stale_places){KD_STALE_HEAD, KD_STALE_HEAD + bits, KD_STALE_HEAD + bits + patches,
                                  KD_STALE_HEAD + bits + 2 * patches};
    kd_status status = kd_gpu_ensure_buffer(gpu, &scene->stale, (size_t)p->groups * 4, 0, "voxels.stale");
    size_t boxes = (stale->count ? stale->count : 1) * sizeof *stale->boxes;
    if (!status)
        status = kd_gpu_ensure_buffer(gpu, &scene->stale_boxes, boxes, 0, "voxels.stale_boxes");
    scene->static_changed = !status && stale->count > 0;
    if (status || !stale->count)
        return status;
    memset(stale->bits, 0, (size_t)bits * 4);
    for (uint32_t i = 0; i < stale->count; i++)
        set_bits(stale, scene, &stale->boxes[i]);
    list_patches(stale, scene);
    scene->stale_box_count = stale->count;
    scene->stale_patch_count = stale->patch_count;
    kd_gpu_write_buffer(gpu, scene->stale_boxes, 0, stale->boxes, stale->count * sizeof *stale->boxes);
    kd_gpu_write_buffer(gpu, scene->stale, (size_t)p->bits * 4, stale->bits, (size_t)bits * 4);
    kd_gpu_write_buffer(gpu, scene->stale, (size_t)p->patches * 4, stale->patches,
                        (size_t)stale->patch_count * 4);
    return KD_OK;
}

void stale_fini(stale_parts *stale)
{
    free(stale->boxes);
    free(stale->bits);
    free(stale->patches);
    *stale = (stale_parts){0};
}
