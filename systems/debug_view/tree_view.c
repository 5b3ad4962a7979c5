/* System view_tree: `--view octree` marches every pixel's ray through the tree, `--view lookup` asks the tree
 * at every visible surface. Albedo and normal above the leaves, which the tree itself does not keep, are
 * added up for the frame. */
#include <stdlib.h>

#include "components/tree_access.h"
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/debug_view/internal.h"

typedef struct tree_view {
    kd_tree_program octree, lookup, means;
    kd_gpu_buffer sums;
} tree_view;

static void bind_cells(kd_gpu *gpu, const kd_svo *svo)
{
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->leaves);
    kd_gpu_bind_storage(gpu, 2, svo->moving);
    kd_gpu_bind_storage(gpu, 3, svo->static_albedo);
    kd_gpu_bind_storage(gpu, 4, svo->static_emission);
    kd_gpu_bind_storage(gpu, 5, svo->dynamic_cells);
    kd_gpu_bind_storage(gpu, 7, svo->book);
}

static bool shows_attributes(const kd_frame *frame)
{
    kd_view_channel channel = kd_frame_channel(frame);
    return channel == KD_CHANNEL_ALBEDO || channel == KD_CHANNEL_NORMAL;
}

/* Make room for the sums of every cell above the leaves, or for none where none are shown. */
static kd_status fit_sums(kd_gpu *gpu, tree_view *v, const kd_svo *svo, bool wanted)
{
    size_t dense = (size_t)svo->cascades * KD_DENSE * KD_DENSE * KD_DENSE + KD_MEAN_ABOVE;
    size_t sparse = (size_t)(kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2) * svo->node_capacity;
    size_t entries = wanted ? dense + sparse : 1;
    return kd_gpu_ensure_buffer(gpu, &v->sums, entries * KD_MEAN_WORDS * 4, 0, "view.means");
}

static void add_up(kd_gpu *gpu, const tree_view *v, const kd_svo *svo)
{
    kd_gpu_fill_buffer(gpu, v->sums, 0, kd_gpu_buffer_size(gpu, v->sums), 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_dispatch_linear(gpu, v->means.program, (svo->node_capacity + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void bind_gbuffer(kd_gpu *gpu, const kd_gbuffer *g)
{
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_ALBEDO, g->albedo);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_NORMAL, g->normal);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_MATERIAL, g->material);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_EMISSIVE, g->emissive);
    kd_gpu_bind_texture(gpu, KD_UNIT_GBUFFER_DEPTH, g->depth);
}

/* Compile what the view needs. Returns its program, NULL when there is none or no tree. */
static const kd_tree_program *fit_programs(kd_gpu *gpu, tree_view *v, const kd_tree *tree, bool octree,
                                           bool sums)
{
    const char *path = octree ? "shaders/debug_view/octree.comp" : "shaders/debug_view/lookup.comp";
    kd_tree_program *program = octree ? &v->octree : &v->lookup;
    bool all = tree->radiance.id && kd_tree_fit_program(gpu, tree, path, program) &&
               (!sums || kd_tree_fit_program(gpu, tree, "shaders/debug_view/means.comp", &v->means));
    return all ? program : NULL;
}

static void run(kd_system_context *context)
{
    tree_view *v = context->user;
    kd_gpu *gpu = context->gpu;
    const kd_frame *frame = kd_singleton(context->world, kd_frame);
    const kd_tree *tree = kd_singleton(context->world, kd_tree);
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    bool sums = shows_attributes(frame) && (frame->settings.view_level > 0 || svo->given_up);
    debug_view_begin(context);
    const kd_tree_program *program = fit_programs(gpu, v, tree, frame->view == KD_VIEW_OCTREE, sums);
    if (!program)
        return;
    if (fit_sums(gpu, v, svo, sums) != KD_OK) {
        kd_log(KD_LOG_WARNING, "view of the tree: no memory for albedo and normals of level %d; show another",
               (int)frame->settings.view_level);
        return;
    }
    struct kd_debug_view_params params = debug_view_params(frame, svo);
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_tree_bind(gpu, tree);
    bind_gbuffer(gpu, kd_singleton(context->world, kd_gbuffer));
    bind_cells(gpu, svo);
    kd_gpu_bind_storage(gpu, 6, v->sums);
    if (sums)
        add_up(gpu, v, svo);
    debug_view_dispatch(context, program->program);
}

static bool asked_for(kd_system_context *context)
{
    uint32_t view = kd_singleton(context->world, kd_frame)->view;
    return view == KD_VIEW_OCTREE || view == KD_VIEW_LOOKUP;
}

static void fini(kd_system_context *context)
{
    tree_view *v = context->user;
    kd_gpu_destroy_program(context->gpu, v->octree.program);
    kd_gpu_destroy_program(context->gpu, v->lookup.program);
    kd_gpu_destroy_program(context->gpu, v->means.program);
    kd_gpu_destroy_buffer(context->gpu, v->sums);
    free(v);
}

kd_status debug_view_add_tree(kd_schedule *s)
{
    tree_view *v = calloc(1, sizeof *v);
    if (!v)
        return KD_NO_MEMORY;
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "view_tree",
                                  .phase = KD_PHASE_VIEW,
                                  .where = KD_ON_GPU,
                                  .components = {KD_USES(kd_tree), KD_USES(kd_svo), KD_USES(kd_lighting),
                                                 KD_USES(kd_frame), KD_USES(kd_gbuffer), KD_USES(kd_picture)},
                                  .resources = {{"tree.uniform", KD_USE_UNIFORM},
                                                {"tree.radiance", KD_USE_SAMPLED},
                                                {"tree.nodes", KD_USE_SAMPLED},
                                                {"tree.leaves", KD_USE_SAMPLED | KD_USE_STORAGE_READ},
                                                {"tree.data", KD_USE_SAMPLED},
                                                {"svo.masks", KD_USE_STORAGE_READ},
                                                {"svo.cells", KD_USE_STORAGE_READ},
                                                {"svo.book", KD_USE_STORAGE_READ},
                                                {"svo.counters", KD_USE_STORAGE_READ},
                                                {"gbuffer", KD_USE_SAMPLED},
                                                {"lights.uniform", KD_USE_UNIFORM},
                                                {"picture", KD_USE_IMAGE_WRITE | KD_USE_COPY_WRITE}},
                                  .run_if = asked_for,
                                  .no_commands = true,
                                  .run = run,
                                  .fini = fini,
                                  .user = v,
                              });
}
