/* Buffers of the octree and their sizes. */
#include <string.h>

#include "systems/svo/internal.h"

static kd_status make_buffer(kd_gpu *gpu, kd_gpu_buffer *out, size_t size, const char *name)
{
    *out = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = size, .zeroed = true, .name = name});
    return out->id ? KD_OK : KD_GPU;
}

/* Places of what does not depend on the number of nodes. */
static void place_cells(kd_svo *svo)
{
    struct kd_svo_places *p = &svo->places;
    uint32_t n = svo->cascades, bits = n * KD_DENSE_WORDS;
    p->size = (kd_gl_uvec4){0, svo_levels(svo), svo->layer_words, n};
    p->masks = (kd_gl_uvec4){svo->mask_first[0], svo->mask_first[1], svo->mask_first[2], svo->mask_first[3]};
    p->changed.x = 0;
    p->others.x = bits;
    p->others.y = 2 * bits;
    p->news = (kd_gl_uvec4){3 * bits, kd_svo_parent_words(svo), 0, 0};
    p->others.z = 4 * bits;
    p->above.x = p->others.z + n * KD_UP_CELLS;
    p->above.y = p->above.x + KD_UP_CELLS / 32;
    p->above.z = p->above.y + KD_UP_CELLS;
    p->blocks.z = n * KD_FREE_BLOCKS;
}

size_t svo_fixed_book_bytes(const kd_svo *svo)
{
    return 4 * ((size_t)svo->places.above.z + KD_UP_CELLS / 8 + 8ul * svo->places.blocks.z);
}

uint32_t svo_place_nodes(const kd_svo *svo, struct kd_svo_places *p, const uint32_t *room)
{
    uint32_t at = (uint32_t)(svo_fixed_book_bytes(svo) / 4), levels = svo_levels(svo);
    uint32_t *codes = &p->codes.x, *stack = &p->free.x, *changed = &p->changed.x;
    uint32_t *child = &p->child.x, words = 0;
    memcpy(&p->room, room, levels * sizeof *room);
    p->size.x = room[levels - 1];
    p->blocks.y = at - 8 * p->blocks.z;
    p->blocks.x = at;
    at += p->size.x;
    for (uint32_t l = 0; l < levels; words += 8 * room[l], at += 2 * room[l], l++) {
        child[l] = words;
        codes[l] = at;
        stack[l] = at + room[l];
    }
    for (uint32_t l = 1; l < levels; at += room[l] / 32, l++)
        changed[l] = at;
    return at;
}

static kd_status make_buffers(kd_gpu *gpu, kd_svo *svo, uint32_t level_words)
{
    size_t n = svo->cascades, layer = (size_t)svo->layer_words * 4, top = layer / 8;
    const struct {
        kd_gpu_buffer *buffer;
        size_t size;
        const char *name;
    } rows[] = {
        {&svo->uniform, sizeof(struct kd_tree_params), "tree.uniform"},
        {&svo->masks, top, "svo.masks"},
        {&svo->moving, 4, "svo.moving"},
        {&svo->level_masks, (size_t)level_words * 4, "svo.level_masks"},
        {&svo->diff, (size_t)level_words / 8, "svo.diff"},
        {&svo->moved, 4, "svo.moving"},
        {&svo->counters, KD_COUNT_WORDS * 4, "svo.counters"},
        {&svo->index, n * KD_DENSE * KD_DENSE * KD_DENSE * 4, "tree.index"},
    };
    kd_status status = KD_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && !status; i++)
        status = make_buffer(gpu, rows[i].buffer, rows[i].size, rows[i].name);
    return status;
}

/* Words as the filter writes them, and a view of these as colours, which are filtered when sampled. */
static kd_status make_dense(kd_gpu *gpu, uint32_t slices, const char *name, kd_gpu_texture *words,
                            kd_gpu_texture *view)
{
    kd_gpu_texture_desc desc = {.kind = KD_TEXTURE_3D,
                                .format = KD_R32UI,
                                .width = KD_DENSE,
                                .height = KD_DENSE,
                                .depth = slices,
                                .wrap_s = KD_REPEAT,
                                .wrap_t = KD_REPEAT,
                                .name = name};
    *words = kd_gpu_make_texture(gpu, &desc);
    if (!words->id)
        return KD_GPU;
    kd_gpu_clear_texture(gpu, *words, 0, NULL);
    desc.format = KD_RGB9E5;
    *view = kd_gpu_make_texture_view(gpu, *words, &desc);
    return view->id ? KD_OK : KD_GPU;
}

kd_status svo_make(kd_gpu *gpu, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t n = scene->cascade_count, level = KD_DENSE_LOG2, first = 0;
    svo->cascades = n;
    svo->leaf_level = scene->resolution_log2;
    svo->layer_words = n << (3 * svo->leaf_level - 5);
    for (; level < svo->leaf_level; level++) {
        svo->mask_first[level - KD_DENSE_LOG2] = first;
        svo->mask_words[level - KD_DENSE_LOG2] = n << (3 * level - 5);
        first += n << (3 * level - 5);
    }
    place_cells(svo);
    kd_status status = make_dense(gpu, KD_ATLAS_SLICES(n, 6), "tree.radiance", &svo->atlas, &svo->atlas_view);
    if (!status)
        status = make_dense(gpu, KD_ATLAS_SLICES(n, 2), "tree.depth", &svo->depths, &svo->depths_view);
    if (!status)
        status = make_buffers(gpu, svo, first);
    if (status)
        return status;
    kd_gpu_fill_buffer(gpu, svo->index, 0, kd_gpu_buffer_size(gpu, svo->index), KD_EMPTY);
    status = svo_reserve_nodes(gpu, svo, (uint32_t[KD_MAX_NODE_LEVELS]){4096, 4096, 4096, 4096});
    if (!status)
        status = svo_reserve_leaves(gpu, svo, 4096);
    if (!status)
        status = svo_reserve_sums(gpu, svo, 4096);
    if (!status)
        status = svo_reserve_fresh(gpu, svo, 4096);
    if (!status)
        status = svo_reserve_entries(gpu, svo, 4096);
    return status ? status : svo_reserve_dynamic(gpu, svo, 4096);
}

void svo_destroy(kd_gpu *gpu, kd_svo *svo)
{
    kd_gpu_buffer buffers[] = {svo->told,          svo->uniform,       svo->masks,       svo->moving,
                               svo->fresh,         svo->level_masks,   svo->before,      svo->moved,
                               svo->diff,          svo->work,          svo->book,        svo->counters,
                               svo->sums,          svo->static_albedo, svo->taken,       svo->static_emission,
                               svo->dynamic_cells, svo->heads,         svo->next,        svo->groups,
                               svo->index,         svo->nodes,         svo->leaves,      svo->data,
                               svo->fresh_heads,   svo->entries,       svo->entry_glows, svo->moved_cells};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        kd_gpu_destroy_buffer(gpu, buffers[i]);
    kd_gpu_texture textures[] = {svo->atlas_view, svo->atlas, svo->depths_view, svo->depths};
    for (size_t i = 0; i < sizeof textures / sizeof *textures; i++)
        kd_gpu_destroy_texture(gpu, textures[i]);
    memset(svo, 0, sizeof *svo);
}

static kd_status reserve(kd_gpu *gpu, kd_gpu_buffer *buffer, uint32_t *capacity, uint32_t cells, size_t size,
                         const char *name)
{
    if (cells <= *capacity)
        return KD_OK;
    kd_status status = kd_gpu_ensure_buffer(gpu, buffer, cells * size, 0, name);
    if (!status)
        *capacity = cells;
    return status;
}

kd_status svo_reserve_sums(kd_gpu *gpu, kd_svo *svo, uint32_t cells)
{
    return reserve(gpu, &svo->sums, &svo->sum_capacity, cells, KD_SUM_WORDS * 4, "svo.sums");
}

kd_status svo_reserve_fresh(kd_gpu *gpu, kd_svo *svo, uint64_t words)
{
    if (!words)
        return KD_OK;
    uint64_t heads = words * 16, most = svo->most_bytes / 128 * 128;
    uint32_t marks = (uint32_t)(words * 4 < most ? words : most / 4);
    kd_status status =
        kd_gpu_ensure_buffer(gpu, &svo->fresh_heads, heads < most ? heads : most, 0, "svo.fresh");
    return status ? status : reserve(gpu, &svo->fresh, &svo->fresh_words, marks, 4, "svo.fresh");
}

kd_status svo_reserve_entries(kd_gpu *gpu, kd_svo *svo, uint32_t entries)
{
    size_t glows = svo->glows ? (size_t)(entries > svo->entry_room ? entries : svo->entry_room) * 4 : 4;
    kd_status status = kd_gpu_ensure_buffer(gpu, &svo->entry_glows, glows, 0, "svo.fresh");
    return status ? status : reserve(gpu, &svo->entries, &svo->entry_room, entries, 16, "svo.fresh");
}

kd_status svo_reserve_emission(kd_gpu *gpu, kd_svo *svo, bool wanted)
{
    kd_gpu_buffer made = {0};
    if (svo->glows == wanted)
        return KD_OK;
    svo->glows = wanted;
    kd_status status =
        make_buffer(gpu, &made, svo_emission_bytes(svo, svo->leaf_room), "svo.static_emission");
    svo->glows = status ? !wanted : wanted;
    if (status)
        return status;
    kd_gpu_destroy_buffer(gpu, svo->static_emission);
    svo->static_emission = made;
    return KD_OK;
}

kd_status svo_reserve_before(kd_gpu *gpu, kd_svo *svo)
{
    return kd_gpu_ensure_buffer(gpu, &svo->before, kd_gpu_buffer_size(gpu, svo->level_masks), 0,
                                "svo.before");
}

kd_status svo_reserve_work(kd_gpu *gpu, kd_svo *svo, uint64_t words)
{
    return kd_gpu_ensure_buffer(gpu, &svo->work, words * 4, 0, "svo.work");
}

kd_status svo_reserve_moving(kd_gpu *gpu, kd_svo *svo, bool wanted)
{
    kd_gpu_buffer made = {0}, moved = {0};
    size_t bytes = wanted ? (size_t)kd_svo_parent_words(svo) * 4 : 4;
    if (svo->has_moving == wanted)
        return KD_OK;
    kd_status status = make_buffer(gpu, &made, 2 * bytes, "svo.moving");
    if (!status)
        status = make_buffer(gpu, &moved, bytes, "svo.moving");
    if (status) {
        kd_gpu_destroy_buffer(gpu, made);
        return status;
    }
    kd_gpu_destroy_buffer(gpu, svo->moving);
    kd_gpu_destroy_buffer(gpu, svo->moved);
    svo->moving = made;
    svo->moved = moved;
    svo->has_moving = wanted;
    if (!wanted) {
        kd_gpu_destroy_buffer(gpu, svo->moved_cells);
        svo->moved_cells = (kd_gpu_buffer){0};
        svo->moved_room = 0;
    }
    return KD_OK;
}

kd_status svo_reserve_dynamic(kd_gpu *gpu, kd_svo *svo, uint32_t parents)
{
    uint32_t held = svo->dynamic_capacity;
    if (parents <= held)
        return KD_OK;
    kd_status status = kd_gpu_ensure_buffer(gpu, &svo->heads, (size_t)parents * 4, 0, "svo.chains");
    if (!status)
        kd_gpu_fill_buffer(gpu, svo->heads, 0, (size_t)parents * 4, KD_EMPTY);
    if (!status)
        status = reserve(gpu, &svo->dynamic_cells, &svo->dynamic_capacity, parents, SVO_PARENT_CELL_BYTES,
                         "svo.dynamic_cells");
    return status;
}

kd_status svo_reserve_chains(kd_gpu *gpu, kd_svo *svo, uint64_t voxels)
{
    uint64_t bytes = voxels * SVO_CHAIN_BYTES;
    if (kd_gpu_buffer_size(gpu, svo->next) > 4 * bytes) {
        kd_gpu_destroy_buffer(gpu, svo->next);
        svo->next = (kd_gpu_buffer){0};
    }
    if (!bytes)
        return KD_OK;
    kd_status status = kd_gpu_ensure_buffer(gpu, &svo->next, bytes, 0, "svo.chains");
    size_t groups = (size_t)(voxels / KD_MOVING_GROUP) * 4;
    return status ? status : kd_gpu_ensure_buffer(gpu, &svo->groups, groups, 0, "svo.chains");
}

void svo_write_params(kd_gpu *gpu, const kd_svo *svo, const kd_voxel_scene *scene)
{
    float unit = scene->stored_unit > 0 ? scene->stored_unit : 1;
    struct kd_tree_params p = {
        .info = {svo->cascades, scene->resolution, svo->leaf_level, svo_levels(svo)},
        .capacity = {svo->node_capacity, svo->dynamic_room, svo->given_up, 0},
        .light = {svo->glows ? scene->brightest_emission : 0, 1 / unit, unit, svo->strict ? 1 : 0},
        .atlas = {1.0f / KD_DENSE, 1.0f / KD_DENSE, 1.0f / (float)KD_ATLAS_SLICES(svo->cascades, 6),
                  1.0f / (float)KD_ATLAS_SLICES(svo->cascades, 2)},
    };
    float half = 0.5f * (float)scene->resolution * scene->span[0];
    p.centre = (kd_gl_vec4){scene->origin_ws[0].x + half, scene->origin_ws[0].y + half,
                            scene->origin_ws[0].z + half, 1 / half};
    for (uint32_t c = 0; c < svo->cascades; c++) {
        const int32_t *o = scene->origin_cells[c];
        p.cascade[c] =
            (kd_gl_vec4){scene->origin_ws[c].x, scene->origin_ws[c].y, scene->origin_ws[c].z, scene->span[c]};
        p.origin[c] = (kd_gl_ivec4){o[0], o[1], o[2], 0};
    }
    p.node_offset = svo->places.child;
    p.data_offset = (kd_gl_uvec4){0, kd_svo_data_first(svo, 2), kd_svo_data_first(svo, 3), 0};
    kd_gpu_write_buffer(gpu, svo->uniform, 0, &p, sizeof p);
}

void svo_view(kd_gpu *gpu, uint32_t *viewed, kd_gpu_texture *texture, kd_gpu_buffer buffer,
              kd_texture_format format)
{
    if (*viewed == buffer.id)
        return;
    kd_gpu_destroy_texture(gpu, *texture);
    *texture = kd_gpu_make_texel_buffer(gpu, buffer, format);
    *viewed = buffer.id;
}

static void count_voxels(const kd_voxel_scene *scene, kd_tree *tree)
{
    memset(tree->cascade_voxels, 0, sizeof tree->cascade_voxels);
    for (uint32_t i = 0; i < scene->object_count; i++)
        for (uint32_t c = 0; c < scene->cascade_count; c++)
            if (scene->objects[i].alive && scene->objects[i].segment_count[c])
                tree->cascade_voxels[c] += scene->objects[i].voxels[c];
}

void svo_publish(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene, kd_tree *tree)
{
    tree->uniform = svo->uniform;
    tree->radiance = svo->atlas_view;
    tree->depth = svo->depths_view;
    tree->cascade_count = svo->cascades;
    tree->resolution = scene->resolution;
    tree->dense_resolution = KD_DENSE;
    tree->strict = svo->strict;
    memcpy(tree->span_m, scene->span, sizeof tree->span_m);
    tree->cached_voxels = scene->cached_voxels;
    tree->static_voxels = scene->pages[KD_LAYER_STATIC].voxel_count;
    tree->dynamic_voxels = scene->pages[KD_LAYER_DYNAMIC].voxel_count;
    tree->resident_voxels = tree->static_voxels + tree->dynamic_voxels;
    count_voxels(scene, tree);
    svo_view(gpu, &state->texel_viewed[0], &tree->index, svo->index, KD_R32UI);
    svo_view(gpu, &state->texel_viewed[1], &tree->nodes, svo->nodes, KD_R32UI);
    svo_view(gpu, &state->texel_viewed[2], &tree->leaves, svo->leaves, KD_RG32UI);
    svo_view(gpu, &state->texel_viewed[3], &tree->data, svo->data, KD_RG32UI);
}
