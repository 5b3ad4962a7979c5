/* Systems of the octree: svo_prepare (room and uniform block), svo_build (order-free build of what changed),
 * svo_filter (bottom-up). */
#include "systems/svo/svo.h"

#include <stdlib.h>

#include "components/bounce.h"
#include "components/frame.h"
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

static const char *const program_paths[SVO_PROGRAM_COUNT] = {
    [SVO_LINK_LIST] = "shaders/svo/link_list.comp",
    [SVO_LINK] = "shaders/svo/link.comp",
    [SVO_CELLS] = "shaders/svo/cells.comp",
    [SVO_LINK_STATIC] = "shaders/svo/link_static.comp",
    [SVO_CELLS_STATIC] = "shaders/svo/cells_static.comp",
    [SVO_MERGE] = "shaders/svo/merge.comp",
    [SVO_MERGE_STALE] = "shaders/svo/merge_stale.comp",
    [SVO_REDUCE] = "shaders/svo/reduce.comp",
    [SVO_DIFF] = "shaders/svo/diff.comp",
    [SVO_VANISH] = "shaders/svo/vanish.comp",
    [SVO_COME] = "shaders/svo/come.comp",
    [SVO_SETTLE] = "shaders/svo/settle.comp",
    [SVO_EMPTY] = "shaders/svo/empty.comp",
    [SVO_TOUCHED] = "shaders/svo/touched.comp",
    [SVO_RELEASE_BLOCKS] = "shaders/svo/release_blocks.comp",
    [SVO_TAKE_BLOCKS] = "shaders/svo/take_blocks.comp",
    [SVO_SETTLE_BLOCKS] = "shaders/svo/settle_blocks.comp",
    [SVO_SHOW_BLOCKS] = "shaders/svo/show_blocks.comp",
    [SVO_SHOW_MOVING] = "shaders/svo/show_moving.comp",
    [SVO_GATHER_BLOCKS] = "shaders/svo/gather_blocks.comp",
    [SVO_ARGS] = "shaders/svo/args.comp",
    [SVO_FILTER_SPARSE] = "shaders/svo/filter_sparse.comp",
    [SVO_DENSE_LIST] = "shaders/svo/dense_list.comp",
    [SVO_NODE_LIST] = "shaders/svo/node_list.comp",
    [SVO_FILTER_DENSE] = "shaders/svo/filter_dense.comp",
    [SVO_FILTER_UP] = "shaders/svo/filter_up.comp",
    [SVO_ABOVE_LIST] = "shaders/svo/above_list.comp",
    [SVO_TELL_LEAVES] = "shaders/svo/tell_leaves.comp",
    [SVO_TELL_CHANGES] = "shaders/svo/tell_changes.comp",
    [SVO_RENUMBER] = "shaders/svo/renumber.comp",
    [SVO_MOVE] = "shaders/svo/move.comp",
    [SVO_WAKE] = "shaders/svo/wake.comp",
    [SVO_FILTER_ABOVE] = "shaders/svo/filter_above.comp",
    [SVO_CENSUS] = "shaders/svo/census.comp",
    [SVO_CENSUS_KEPT] = "shaders/svo/census_kept.comp",
    [SVO_CENSUS_FRESH] = "shaders/svo/census_fresh.comp",
    [SVO_TAKEN_ADD] = "shaders/svo/taken_add.comp",
    [SVO_TAKEN_MARK] = "shaders/svo/taken_mark.comp",
    [SVO_TAKEN_LEVEL] = "shaders/svo/taken_level.comp",
    [SVO_TAKEN_LIST] = "shaders/svo/taken_list.comp",
    [SVO_TAKEN_SETTLE] = "shaders/svo/taken_settle.comp",
    [SVO_TAKEN_BLOCKS] = "shaders/svo/taken_blocks.comp",
    [SVO_TAKEN_PACK] = "shaders/svo/taken_pack.comp",
};

static bool compile(kd_gpu *gpu, svo_state *state, int first, int end, bool atomic)
{
    const char *take[] = {"KD_TAKE 1", NULL};
    bool all = true;
    for (int i = first; i < end; i++) {
        const char *const *defines = i == SVO_TAKEN_ADD && atomic ? take : NULL;
        state->programs[i] =
            kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = program_paths[i], .defines = defines});
        all = all && state->programs[i].id;
    }
    return all;
}

/* Buffers, and the programs of the build that was chosen. */
static kd_status make(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                      const kd_settings *settings)
{
    svo_allow(gpu, state, svo, settings->svo_memory);
    if ((uint64_t)scene->stale_places.groups * 4 > (uint64_t)kd_gpu_get_info(gpu)->max_ssbo_bytes)
        return KD_NO_MEMORY; /* what is to be made anew could not be bound */
    kd_status status = svo_make(gpu, svo, scene);
    svo->strict = settings->light_leak == KD_LEAK_STRICT;
    bool taken = scene->build != KD_SVO_BUILD_ORDERFREE, atomic = scene->build == KD_SVO_BUILD_ATOMIC;
    if (!status && taken && !compile(gpu, state, SVO_TAKEN, SVO_PROGRAM_COUNT, atomic))
        status = KD_GPU;
    return status;
}

static void say_layers(const kd_settings *settings)
{
    if (settings->svo_build != KD_SVO_BUILD_ORDERFREE && settings->svo_layers != KD_SVO_LAYERS_ONE)
        kd_log(KD_LOG_WARNING,
               "svo.build=%s makes the whole tree in every frame; it is used with "
               "svo.layers=one (say so to be rid of this message)",
               settings->svo_build == KD_SVO_BUILD_ATOMIC ? "atomic" : "levels");
}

static void prepare(kd_system_context *context)
{
    kd_voxel_scene *scene = kd_singleton(context->world, kd_voxel_scene);
    kd_svo *svo = kd_singleton(context->world, kd_svo);
    svo_state *state = context->user;
    const kd_settings *settings = &kd_singleton(context->world, kd_frame)->settings;
    bool first = !svo->masks.id && !svo->failed;
    if (first)
        say_layers(settings);
    if (first && make(context->gpu, state, svo, scene, settings) != KD_OK) {
        kd_log(KD_LOG_ERROR, "octree: no room for %u cascades of %u^3; choose a smaller voxels.resolution",
               scene->cascade_count, scene->resolution);
        svo_destroy(context->gpu, svo);
        svo->failed = true;
    }
    svo->again = false;
    svo->runs++;
    svo_allow(context->gpu, state, svo, settings->svo_memory); /* before what is sized by what is allowed */
    uint64_t fresh_words = scene->static_changed ? 8ull * scene->stale_patch_count : 0;
    if (svo->uniform.id && svo_reserve_fresh(context->gpu, svo, fresh_words) != KD_OK) {
        kd_log(KD_LOG_ERROR, "octree: no memory to bring %u patches of cells in; there is no indirect light",
               scene->stale_patch_count);
        svo_destroy(context->gpu, svo);
        svo->failed = true;
    }
    state->fresh.wanted = (uint32_t)(fresh_words < svo->fresh_words ? fresh_words : svo->fresh_words);
    if (svo->uniform.id && svo_reserve_emission(context->gpu, svo, scene->brightest_emission > 0) != KD_OK)
        svo_say_once(state, SVO_SAID_GLOW,
                     "octree: no memory for what glows; it lights nothing; raise voxels.span");
    bool moves = scene->pages[KD_LAYER_DYNAMIC].segment_count && scene->build == KD_SVO_BUILD_ORDERFREE;
    state->still_runs = moves ? 0 : state->still_runs + 1;
    if (svo->uniform.id && moves && svo_reserve_moving(context->gpu, svo, true) != KD_OK)
        svo_say_once(state, SVO_SAID_MOVING,
                     "octree: no memory for what moves; it stays dark; choose a smaller "
                     "voxels.resolution");
    if (svo->uniform.id)
        svo_write_params(context->gpu, svo, scene);
}

void svo_args(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, uint32_t counter, uint32_t most,
              uint32_t factor, uint32_t args)
{
    uint32_t pass[4] = {counter, most, factor, args};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_dispatch(gpu, state->programs[SVO_ARGS], 1, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_INDIRECT);
}

uint32_t svo_read_counter(kd_gpu *gpu, const kd_svo *svo, uint32_t counter)
{
    uint32_t value = 0;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_read_buffer(gpu, svo->counters, counter * 4, &value, sizeof value);
    return value;
}

/* What a cascade has whether or not anything is in it: dense cells in six directions and their index, bits of
 * dense cells, and masks of nodes, of leaf parents with static cells, and of those in which something moves
 * with their ranks. */
static uint64_t empty_cascade_bytes(const kd_svo *svo)
{
    const uint64_t cells = KD_DENSE * KD_DENSE * KD_DENSE;
    uint64_t parts = kd_svo_parent_words(svo) / svo->cascades;
    uint64_t words = 4 * KD_DENSE_WORDS + KD_UP_CELLS + 8 * KD_FREE_BLOCKS;
    words += svo->asleep ? 0 : parts;
    words += svo->has_moving ? 3 * parts : 0;
    for (uint32_t l = 0; l < (svo->asleep ? 1 : svo_levels(svo)); l++)
        words += svo->mask_words[l] / svo->cascades;
    return cells * (6u * 4 + 2u * 4 + (svo_levels(svo) == 1 ? 8 : 4)) + words * 4;
}

/* Bytes of a node: code, place in the stack of numbers; its child words, and those that lead to leaves, or
 * the word of its block; below the dense level its filtered data. */
static uint64_t node_bytes(const kd_svo *svo, uint32_t l)
{
    uint32_t last = svo_levels(svo) - 1, words = l == last ? 1 : l + 1 == last ? 16 : 8;
    return 2 * 4 + (l > 0 ? 8u : 0u) + words * 4;
}

static void spread_counts(const kd_svo *svo, const uint32_t *counts, kd_tree *tree)
{
    tree->node_count = 0;
    for (uint32_t c = 0; c < svo->cascades; c++) {
        tree->cascade_nodes[c] = 0;
        tree->cascade_bytes[c] = empty_cascade_bytes(svo);
        for (uint32_t l = 0; l < svo_levels(svo); l++) {
            uint32_t nodes = counts[KD_COUNT_NODES + 4 * l + c];
            tree->cascade_nodes[c] += nodes;
            tree->cascade_bytes[c] += nodes * node_bytes(svo, l);
        }
        uint64_t slots = kd_svo_wide_blocks(svo) ? 8 * tree->cascade_nodes[c] : counts[KD_COUNT_CELLS + c];
        tree->cascade_bytes[c] += slots * (svo->glows ? 20 : 12);
        tree->node_count += tree->cascade_nodes[c];
    }
}

/* Counts of earlier frames come back without a wait, for the statistics alone: room depends on nothing that
 * depends on time. */
static void follow_counts(kd_gpu *gpu, svo_state *state, kd_svo *svo, kd_tree *tree)
{
    const uint32_t *counts;
    uint64_t run;
    size_t size;
    while ((counts = kd_gpu_readback_poll(gpu, state->readback, false, &run, &size)) != NULL) {
        svo->lit_run = counts[KD_COUNT_LIT];
        svo->lit_known = (uint32_t)run;
        tree->leaf_cells = counts[KD_COUNT_STATIC] + counts[KD_COUNT_DYNAMIC];
        spread_counts(svo, counts, tree);
    }
}

/* What nothing static has gone stale in, and nothing moves in or did, is the tree of the frame before. */
static bool has_changed(const svo_state *state, const kd_voxel_scene *scene)
{
    return scene->static_changed || state->dynamic_before || svo_asks_for_room(state) ||
           scene->pages[KD_LAYER_DYNAMIC].segment_count > 0 || scene->one_layer;
}

static svo_build *const builds[] = {[KD_SVO_BUILD_ORDERFREE] = svo_build_orderfree,
                                    [KD_SVO_BUILD_ATOMIC] = svo_build_atomic,
                                    [KD_SVO_BUILD_LEVELS] = svo_build_levels};

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
    if (!svo->again)
        svo_give_back(gpu, state, svo, scene);
    bool changed = has_changed(state, scene);
    svo->changed_run = changed ? svo->runs : svo->changed_run;
    state->same_runs = changed ? 0 : state->same_runs + 1;
    if (changed && svo->asleep && svo_wake(gpu, state, svo) != KD_OK) {
        svo_say_once(state, SVO_SAID_WORK, SVO_NO_MEMORY);
        return;
    }
    svo_begin_nodes(gpu, state, svo, scene);
    if (changed) {
        kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, svo->uniform, 0, sizeof(struct kd_tree_params));
        bool twice = svo->again;
        builds[scene->build](gpu, state, svo, scene);
        if (svo->again && !twice)
            return;
    }
    if (scene->one_layer && svo->wants_changes)
        svo_tell_changes(gpu, state, svo);
    svo_reserve_filter(gpu, state, svo);
    state->dynamic_before = scene->pages[KD_LAYER_DYNAMIC].segment_count > 0;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_readback_buffer(gpu, state->readback, svo->counters, 0, KD_COUNT_WORDS * 4, svo->runs);
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

static kd_status init(kd_system_context *context)
{
    svo_state *s = context->user;
    kd_gpu *gpu = context->gpu;
    bool all = compile(gpu, s, 0, SVO_TAKEN, false);
    s->readback = kd_gpu_make_readback(gpu, KD_COUNT_WORDS * 4, 4, "svo.counters");
    kd_status status = kd_gpu_rank_init(gpu, &s->rank);
    return all && s->readback.id ? status : KD_GPU;
}

static void fini(kd_system_context *context)
{
    svo_state *s = context->user;
    kd_gpu *gpu = context->gpu;
    kd_tree *tree = kd_singleton(context->world, kd_tree);
    for (int i = 0; i < SVO_PROGRAM_COUNT; i++)
        kd_gpu_destroy_program(gpu, s->programs[i]);
    kd_gpu_texture views[] = {tree->index, tree->nodes, tree->leaves, tree->data};
    for (size_t i = 0; i < sizeof views / sizeof *views; i++)
        kd_gpu_destroy_texture(gpu, views[i]);
    kd_texel_view_fini(gpu, &s->page_view);
    kd_texel_view_fini(gpu, &s->next_view);
    kd_texel_view_fini(gpu, &s->object_view);
    kd_texel_view_fini(gpu, &s->moving_view);
    kd_texel_view_fini(gpu, &s->still_view);
    kd_texel_view_fini(gpu, &s->moved_view);
    kd_texel_view_fini(gpu, &s->segment_view);
    kd_texel_view_fini(gpu, &s->shape_view);
    kd_texel_view_fini(gpu, &s->color_view);
    kd_texel_view_fini(gpu, &s->stale_view);
    kd_texel_view_fini(gpu, &s->entry_view);
    kd_texel_view_fini(gpu, &s->glow_view);
    kd_rigid_access_fini(gpu, &s->rigid);
    kd_gpu_destroy_readback(gpu, s->readback);
    kd_gpu_rank_fini(gpu, &s->rank);
    svo_destroy(gpu, kd_singleton(context->world, kd_svo));
    *tree = (kd_tree){0};
    free(s);
}

static kd_status add_prepare(kd_schedule *s, svo_state *state)
{
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = "svo_prepare",
               .phase = KD_PHASE_VOXEL_IO,
               .where = KD_ON_GPU,
               .components = {KD_USES(kd_voxel_scene), KD_CHANGES(kd_svo), KD_USES(kd_frame)},
               .resources = {{"tree.uniform", KD_USE_COPY_WRITE}, {"svo.masks", KD_USE_COPY_WRITE}},
               .run_if = kd_frame_needs_voxels,
               .no_commands = true,
               .run = prepare,
               .init = init,
               .fini = fini,
               .user = state,
           });
}

static bool builds_again(kd_system_context *context)
{
    return kd_frame_needs_voxels(context) && kd_singleton(context->world, kd_svo)->again;
}

/* Once more when cascades have given a level up for want of room, or have one back. */
static kd_status add_build(kd_schedule *s, svo_state *state, bool again)
{
    return kd_schedule_add(
        s, &(kd_system_desc){
               .name = again ? "svo_build_again" : "svo_build",
               .phase = again ? KD_PHASE_SVO_AGAIN : KD_PHASE_SVO_BUILD,
               .where = KD_ON_GPU,
               .components = {KD_USES(kd_voxel_scene), KD_CHANGES(kd_svo), KD_CHANGES(kd_tree),
                              KD_USES(kd_frame)},
               .resources = {{"voxels.pages", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_SAMPLED},
                             {"voxels.objects", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
                             {"voxels.chunks", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
                             {"voxels.cache", KD_USE_STORAGE_READ | KD_USE_SAMPLED},
                             {"voxels.stale", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_SAMPLED |
                                                  KD_USE_INDIRECT | KD_USE_COPY_READ | KD_USE_COPY_WRITE},
                             {"tree.uniform", KD_USE_UNIFORM | KD_USE_COPY_WRITE},
                             {"svo.masks", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_SAMPLED |
                                               KD_USE_COPY_WRITE},
                             {"svo.fresh", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_SAMPLED |
                                               KD_USE_COPY_WRITE},
                             {"svo.chains", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ | KD_USE_COPY_WRITE},
                             {"svo.cells", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ | KD_USE_COPY_READ |
                                               KD_USE_COPY_WRITE},
                             {"svo.levels", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ | KD_USE_COPY_WRITE},
                             {"svo.changes", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ | KD_USE_COPY_READ |
                                                 KD_USE_COPY_WRITE},
                             {"svo.book", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ | KD_USE_COPY_READ |
                                              KD_USE_COPY_WRITE},
                             {"svo.counters", KD_USE_STORAGE_WRITE | KD_USE_STORAGE_READ | KD_USE_INDIRECT |
                                                  KD_USE_COPY_READ | KD_USE_COPY_WRITE},
                             {"tree.nodes", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_COPY_READ |
                                                KD_USE_COPY_WRITE},
                             {"tree.leaves", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_COPY_READ |
                                                 KD_USE_COPY_WRITE},
                             {"tree.data", KD_USE_COPY_READ | KD_USE_COPY_WRITE}},
               .run_if = again ? builds_again : kd_frame_needs_voxels,
               .no_commands = true,
               .run = build,
               .bytes_moved = build_bytes,
               .user = state,
           });
}

static bool filters_again(kd_system_context *context)
{
    return kd_frame_needs_voxels(context) && kd_singleton(context->world, kd_bounce)->again;
}

/* Once for the light that has entered, and once more when bounced light has entered in the same frame. */
static kd_status add_filter(kd_schedule *s, svo_state *state, bool again)
{
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = again ? "svo_filter_again" : "svo_filter",
                                  .phase = again ? KD_PHASE_BOUNCE_FILTER : KD_PHASE_SVO_FILTER,
                                  .where = KD_ON_GPU,
                                  .components = {KD_USES(kd_svo), KD_USES(kd_frame), KD_USES(kd_bounce)},
                                  .resources = {{"svo.levels", KD_USE_STORAGE_READ},
                                                {"svo.book", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE},
                                                {"svo.counters", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE |
                                                                     KD_USE_INDIRECT | KD_USE_COPY_WRITE},
                                                {"tree.uniform", KD_USE_UNIFORM},
                                                {"tree.nodes", KD_USE_STORAGE_READ},
                                                {"tree.leaves", KD_USE_STORAGE_READ},
                                                {"tree.data", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE},
                                                {"tree.radiance", KD_USE_IMAGE_READ | KD_USE_IMAGE_WRITE}},
                                  .run_if = again ? filters_again : kd_frame_needs_voxels,
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
        status = add_build(s, state, false);
    if (!status)
        status = add_build(s, state, true);
    if (!status)
        status = add_filter(s, state, false);
    if (!status)
        status = add_filter(s, state, true);
    return status;
}
