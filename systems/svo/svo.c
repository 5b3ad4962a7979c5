/* Systems of the octree: svo_prepare (room and uniform block), svo_build (order-free build), svo_filter
 * (bottom-up). */
#include "systems/svo/svo.h"

#include <stdlib.h>

#include "components/frame.h"
#include "runtime/core/log.h"
#include "systems/svo/build.h"
#include "systems/svo/internal.h"

static void prepare(kd_system_context *context)
{
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_svo *svo = kd_singleton(context->world, kd_svo);
    if (!svo->masks.id && !svo->failed && svo_make(context->gpu, svo, scene) != KD_OK) {
        kd_log(KD_LOG_ERROR, "octree: no room for %u cascades of %u^3; choose a smaller voxels.resolution",
               scene->cascade_count, scene->resolution);
        svo_destroy(context->gpu, svo);
        svo->failed = true;
    }
    if (svo->uniform.id)
        svo_write_params(context->gpu, svo, scene);
}

/* What a cascade has whether or not anything is in it: dense cells in six directions and their index, the
 * bits of both layers' cells and of all levels, and the ranks of these. */
static uint64_t empty_cascade_bytes(const kd_svo *svo)
{
    const uint64_t cells = KD_DENSE * KD_DENSE * KD_DENSE;
    uint64_t words = 2 * (svo->layer_words / svo->cascades);
    for (uint32_t l = 0; l < svo->leaf_level - KD_DENSE_LOG2; l++)
        words += svo->mask_words[l] / svo->cascades;
    return cells * (6 * 8 + 4) + cells / 8 + words * 2 * 4;
}

/* Bytes of a node: both lists, its child words or leaves, and below the dense level its filtered data. */
static uint64_t node_bytes(const kd_svo *svo, uint32_t l)
{
    bool leaf_parent = l + 1 == svo->leaf_level - KD_DENSE_LOG2;
    return 2 * 4 + (leaf_parent ? 8u * 8 : 8u * 4) + (l > 0 ? 8u : 0);
}

static void spread_counts(const kd_svo *svo, const uint32_t *counts, kd_tree *tree)
{
    for (uint32_t c = 0; c < svo->cascades; c++) {
        tree->cascade_nodes[c] = 0;
        tree->cascade_bytes[c] = empty_cascade_bytes(svo);
        for (uint32_t l = 0; l < svo->leaf_level - KD_DENSE_LOG2; l++) {
            const uint32_t *before = counts + KD_COUNT_BEFORE + 4 * l;
            uint32_t end = c + 1 < svo->cascades ? before[c + 1] : counts[KD_COUNT_LEVEL + l];
            tree->cascade_nodes[c] += end - before[c];
            tree->cascade_bytes[c] += (end - before[c]) * node_bytes(svo, l);
        }
    }
}

/* Counts of earlier frames come back without a wait, for the statistics alone: room depends on nothing that
 * depends on time. */
static void follow_counts(kd_gpu *gpu, svo_state *state, kd_svo *svo, kd_tree *tree)
{
    const uint32_t *counts;
    size_t size;
    while ((counts = kd_gpu_readback_poll(gpu, state->readback, false, NULL, &size)) != NULL) {
        uint32_t levels = svo->leaf_level - KD_DENSE_LOG2;
        tree->leaf_cells = counts[KD_COUNT_STATIC] + counts[KD_COUNT_DYNAMIC];
        tree->node_count = 0;
        for (uint32_t l = 0; l < levels; l++)
            tree->node_count += counts[KD_COUNT_LEVEL + l];
        spread_counts(svo, counts, tree);
    }
}

static void build(kd_system_context *context)
{
    svo_state *state = context->user;
    kd_gpu *gpu = context->gpu;
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_svo *svo = kd_singleton(context->world, kd_svo);
    kd_tree *tree = kd_singleton(context->world, kd_tree);
    if (!svo->masks.id)
        return;
    state->bytes_build = 0;
    follow_counts(gpu, state, svo, tree);
    if (scene->static_changed)
        build_layer(gpu, state, svo, scene, KD_LAYER_STATIC);
    build_layer(gpu, state, svo, scene, KD_LAYER_DYNAMIC);
    build_tree(gpu, state, svo, scene);
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_readback_buffer(gpu, state->readback, svo->counters, 0, KD_COUNT_WORDS * 4, 0);
    svo_publish(gpu, state, svo, scene, tree);
}

static uint64_t build_bytes(const kd_system_context *context)
{
    const svo_state *state = context->user;
    return state->bytes_build;
}

static void filter(kd_system_context *context)
{
    kd_svo *svo = kd_singleton(context->world, kd_svo);
    if (svo->masks.id)
        svo_filter(context->gpu, context->user, svo);
}

static kd_gpu_program program(kd_gpu *gpu, const char *path, const char *const *defines)
{
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = path, .defines = defines});
}

static kd_status init(kd_system_context *context)
{
    svo_state *s = context->user;
    kd_gpu *gpu = context->gpu;
    const char *dense[] = {"KD_DENSE_LEVEL 1", NULL};
    s->accumulate = program(gpu, "shaders/svo/accumulate.comp", NULL);
    s->pack = program(gpu, "shaders/svo/pack.comp", NULL);
    s->merge = program(gpu, "shaders/svo/merge.comp", NULL);
    s->reduce = program(gpu, "shaders/svo/reduce.comp", NULL);
    s->args = program(gpu, "shaders/svo/args.comp", NULL);
    s->list = program(gpu, "shaders/svo/list.comp", NULL);
    s->list_dense = program(gpu, "shaders/svo/list.comp", dense);
    s->nodes = program(gpu, "shaders/svo/nodes.comp", NULL);
    s->filter_sparse = program(gpu, "shaders/svo/filter_sparse.comp", NULL);
    s->filter_dense = program(gpu, "shaders/svo/filter_dense.comp", NULL);
    s->filter_up = program(gpu, "shaders/svo/filter_up.comp", NULL);
    s->clear_dense = program(gpu, "shaders/svo/clear_dense.comp", NULL);
    s->readback = kd_gpu_make_readback(gpu, KD_COUNT_WORDS * 4, 4, "svo.counters");
    kd_status status = kd_gpu_rank_init(gpu, &s->rank);
    bool all = s->accumulate.id && s->pack.id && s->merge.id && s->reduce.id && s->args.id && s->list.id &&
               s->list_dense.id && s->nodes.id && s->filter_sparse.id && s->filter_dense.id &&
               s->filter_up.id && s->clear_dense.id && s->readback.id;
    return all ? status : KD_GPU;
}

static void fini(kd_system_context *context)
{
    svo_state *s = context->user;
    kd_gpu *gpu = context->gpu;
    kd_tree *tree = kd_singleton(context->world, kd_tree);
    kd_gpu_program programs[] = {s->accumulate,    s->pack,         s->merge,      s->reduce,
                                 s->args,          s->list,         s->list_dense, s->nodes,
                                 s->filter_sparse, s->filter_dense, s->filter_up,  s->clear_dense};
    for (size_t i = 0; i < sizeof programs / sizeof *programs; i++)
        kd_gpu_destroy_program(gpu, programs[i]);
    kd_gpu_texture views[] = {tree->index, tree->nodes, tree->leaves, tree->data};
    for (size_t i = 0; i < sizeof views / sizeof *views; i++)
        kd_gpu_destroy_texture(gpu, views[i]);
    kd_gpu_destroy_readback(gpu, s->readback);
    kd_gpu_rank_fini(gpu, &s->rank);
    svo_destroy(gpu, kd_singleton(context->world, kd_svo));
    *tree = (kd_tree){0};
    free(s);
}

static kd_status add_prepare(kd_schedule *s, svo_state *state)
{
    return kd_schedule_add(s,
                           &(kd_system_desc){
                               .name = "svo_prepare",
                               .phase = KD_PHASE_VOXEL_IO,
                               .where = KD_ON_GPU,
                               .components = {KD_USES(kd_voxel_scene), KD_CHANGES(kd_svo), KD_USES(kd_frame)},
                               .resources = {{"tree.uniform", KD_USE_COPY_WRITE}},
                               .run_if = kd_frame_needs_voxels,
                               .no_commands = true,
                               .run = prepare,
                               .init = init,
                               .fini = fini,
                               .user = state,
                           });
}

static kd_status add_build(kd_schedule *s, svo_state *state)
{
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "svo_build",
               .phase = KD_PHASE_SVO_BUILD,
               .where = KD_ON_GPU,
               .components = {KD_USES(kd_voxel_scene), KD_CHANGES(kd_svo), KD_CHANGES(kd_tree),
                              KD_USES(kd_frame)},
               .resources = {{"voxels.pages", KD_USE_STORAGE_READ},
                             {"voxels.objects", KD_USE_STORAGE_READ},
                             {"voxels.cache", KD_USE_STORAGE_READ},
                             {"tree.uniform", KD_USE_UNIFORM | KD_USE_COPY_WRITE},
                             {"svo.masks", KD_USE_STORAGE_READ},
                             {"svo.ranks", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ},
                             {"svo.cells", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ},
                             {"svo.levels", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ},
                             {"svo.counters", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ | KD_USE_INDIRECT |
                                                  KD_USE_COPY_READ | KD_USE_COPY_WRITE},
                             {"tree.nodes", KD_USE_STORAGE_WRITE | KD_USE_COPY_WRITE}},
               .run_if = kd_frame_needs_voxels,
               .no_commands = true,
               .run = build,
               .bytes_moved = build_bytes,
               .user = state,
           });
}

static kd_status add_filter(kd_schedule *s, svo_state *state)
{
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "svo_filter",
                                  .phase = KD_PHASE_SVO_FILTER,
                                  .where = KD_ON_GPU,
                                  .components = {KD_USES(kd_svo), KD_USES(kd_frame)},
                                  .resources = {{"svo.levels", KD_USE_STORAGE_READ | KD_USE_COPY_READ},
                                                {"svo.counters", KD_USE_STORAGE_READ | KD_USE_INDIRECT},
                                                {"tree.nodes", KD_USE_STORAGE_READ},
                                                {"tree.leaves", KD_USE_STORAGE_READ},
                                                {"tree.data", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE},
                                                {"svo.occupancy", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE |
                                                                      KD_USE_COPY_WRITE},
                                                {"tree.radiance", KD_USE_IMAGE_READ | KD_USE_IMAGE_WRITE}},
                                  .run_if = kd_frame_needs_voxels,
                                  .no_commands = true,
                                  .run = filter,
                                  .user = state,
                              });
}

kd_status kd_svo_import(kd_schedule *s)
{
    svo_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    kd_status status = add_prepare(s, state);
    if (!status)
        status = add_build(s, state);
    if (!status)
        status = add_filter(s, state);
    return status;
}
