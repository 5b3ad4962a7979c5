/* Buffers of the octree and their sizes. */
#include <string.h>

#include "systems/svo/internal.h"

#define ATLAS_WIDTH (6 * KD_DENSE)

static uint32_t atlas_depth(uint32_t cascades)
{
    return cascades * KD_DENSE + KD_DENSE / 2;
}

static kd_status make_buffer(kd_gpu *gpu, kd_gpu_buffer *out, size_t size, const char *name)
{
    *out = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = size, .zeroed = true, .name = name});
    return out->id ? KD_OK : KD_GPU;
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
    uint32_t dense_words = 1u << (3 * KD_DENSE_LOG2 - 5);
    svo->atlas = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = KD_TEXTURE_3D,
                                                                 .format = KD_RGBA16F,
                                                                 .width = ATLAS_WIDTH,
                                                                 .height = KD_DENSE,
                                                                 .depth = atlas_depth(n),
                                                                 .filter = KD_LINEAR,
                                                                 .name = "tree.radiance"});
    if (!svo->atlas.id)
        return KD_GPU;
    kd_gpu_clear_texture(gpu, svo->atlas, 0, NULL);
    kd_status status = make_buffer(gpu, &svo->uniform, sizeof(struct kd_tree_params), "tree.uniform");
    size_t was = (size_t)(n - 1) * 32768 + 37449;
    if (!status)
        status = make_buffer(gpu, &svo->masks, (size_t)svo->layer_words * 8, "svo.masks");
    if (!status)
        status = make_buffer(gpu, &svo->ranks, (size_t)svo->layer_words * 8, "svo.ranks");
    if (!status)
        status = make_buffer(gpu, &svo->level_masks, (size_t)first * 4, "svo.level_masks");
    if (!status)
        status = make_buffer(gpu, &svo->level_ranks, (size_t)first * 4, "svo.level_ranks");
    if (!status)
        status = make_buffer(gpu, &svo->counters, KD_COUNT_WORDS * 4, "svo.counters");
    if (!status)
        status = make_buffer(gpu, &svo->index, (size_t)n * KD_DENSE * KD_DENSE * KD_DENSE * 4, "tree.index");
    if (!status)
        status =
            make_buffer(gpu, &svo->occupancy, ((size_t)n * dense_words + dense_words) * 4, "svo.occupancy");
    if (!status)
        status = make_buffer(gpu, &svo->was, was * 4, "svo.was");
    if (!status)
        status = svo_reserve_nodes(gpu, svo, 4096);
    if (!status)
        status = svo_reserve_cells(gpu, svo, KD_LAYER_STATIC, 4096);
    if (!status)
        status = svo_reserve_cells(gpu, svo, KD_LAYER_DYNAMIC, 4096);
    return status;
}

void svo_destroy(kd_gpu *gpu, kd_svo *svo)
{
    kd_gpu_buffer buffers[] = {svo->uniform,     svo->masks,        svo->ranks,         svo->level_masks,
                               svo->level_ranks, svo->lists[0],     svo->lists[1],      svo->counters,
                               svo->sums,        svo->static_cells, svo->dynamic_cells, svo->index,
                               svo->nodes,       svo->leaves,       svo->data,          svo->occupancy,
                               svo->was};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++)
        kd_gpu_destroy_buffer(gpu, buffers[i]);
    kd_gpu_destroy_texture(gpu, svo->atlas);
    memset(svo, 0, sizeof *svo);
}

kd_status svo_reserve_nodes(kd_gpu *gpu, kd_svo *svo, uint32_t nodes)
{
    if (nodes <= svo->node_capacity)
        return KD_OK;
    size_t levels = svo->leaf_level - KD_DENSE_LOG2;
    kd_status status = kd_gpu_ensure_buffer(gpu, &svo->leaves, (size_t)nodes * 64, 0, "tree.leaves");
    size_t inner = levels > 1 ? levels - 1 : 1;
    if (!status)
        status = kd_gpu_ensure_buffer(gpu, &svo->nodes, inner * nodes * 32, 0, "tree.nodes");
    if (!status)
        status = kd_gpu_ensure_buffer(gpu, &svo->data, inner * nodes * 8, 0, "tree.data");
    for (int i = 0; i < 2 && !status; i++)
        status = kd_gpu_ensure_buffer(gpu, &svo->lists[i], levels * nodes * 4,
                                      levels * svo->node_capacity * 4, "svo.lists");
    if (!status)
        svo->node_capacity = nodes;
    return status;
}

kd_status svo_reserve_cells(kd_gpu *gpu, kd_svo *svo, kd_voxel_layer layer, uint32_t cells)
{
    uint32_t *capacity = layer == KD_LAYER_STATIC ? &svo->static_capacity : &svo->dynamic_capacity;
    kd_gpu_buffer *buffer = layer == KD_LAYER_STATIC ? &svo->static_cells : &svo->dynamic_cells;
    if (cells <= *capacity)
        return KD_OK;
    kd_status status = kd_gpu_ensure_buffer(gpu, buffer, (size_t)cells * 16, 0, "svo.cells");
    if (!status)
        status = kd_gpu_ensure_buffer(gpu, &svo->sums, (size_t)cells * KD_SUM_WORDS * 4, 0, "svo.sums");
    if (!status)
        *capacity = cells;
    return status;
}

void svo_write_params(kd_gpu *gpu, const kd_svo *svo, const kd_voxel_scene *scene)
{
    float unit = scene->stored_unit > 0 ? scene->stored_unit : 1;
    struct kd_tree_params p = {
        .info = {svo->cascades, scene->resolution, svo->leaf_level, svo->leaf_level - KD_DENSE_LOG2},
        .capacity = {svo->node_capacity, svo->node_capacity, svo->dynamic_room, svo->static_room},
        .light = {scene->brightest_emission, 1 / unit, unit, 0},
        .atlas = {1.0f / ATLAS_WIDTH, 1.0f / KD_DENSE, 1.0f / (float)atlas_depth(svo->cascades), 0},
    };
    float half = 0.5f * (float)scene->resolution * scene->span[0];
    p.centre = (kd_gl_vec4){scene->origin_ws[0].x + half, scene->origin_ws[0].y + half,
                            scene->origin_ws[0].z + half, 1 / half};
    for (uint32_t c = 0; c < svo->cascades; c++)
        p.cascade[c] =
            (kd_gl_vec4){scene->origin_ws[c].x, scene->origin_ws[c].y, scene->origin_ws[c].z, scene->span[c]};
    p.node_offset = (kd_gl_uvec4){0, 8 * svo->node_capacity, 16 * svo->node_capacity, 0};
    p.data_offset = (kd_gl_uvec4){0, svo->node_capacity, 2 * svo->node_capacity, 0};
    kd_gpu_write_buffer(gpu, svo->uniform, 0, &p, sizeof p);
}

static void view(kd_gpu *gpu, uint32_t *viewed, kd_gpu_texture *texture, kd_gpu_buffer buffer,
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
    tree->radiance = svo->atlas;
    tree->cascade_count = svo->cascades;
    tree->resolution = scene->resolution;
    tree->dense_resolution = KD_DENSE;
    memcpy(tree->span_m, scene->span, sizeof tree->span_m);
    tree->cached_voxels = scene->cached_voxels;
    tree->static_voxels = scene->pages[KD_LAYER_STATIC].voxel_count;
    tree->dynamic_voxels = scene->pages[KD_LAYER_DYNAMIC].voxel_count;
    tree->resident_voxels = tree->static_voxels + tree->dynamic_voxels;
    count_voxels(scene, tree);
    view(gpu, &state->texel_viewed[0], &tree->index, svo->index, KD_R32UI);
    view(gpu, &state->texel_viewed[1], &tree->nodes, svo->nodes, KD_R32UI);
    view(gpu, &state->texel_viewed[2], &tree->leaves, svo->leaves, KD_RG32UI);
    view(gpu, &state->texel_viewed[3], &tree->data, svo->data, KD_RG32UI);
}
