/* Systems light_inject and light_inject_again: direct light, emission and bounced light enter the leaves of
 * the octree. */
#include "systems/lighting/lighting.h"

#include <stdlib.h>
#include <string.h>

#include "components/bounce.h"
#include "components/emitters.h"
#include "components/frame.h"
#include "components/render_targets.h"
#include "components/sky.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "systems/lighting/emitters.h"
#include "systems/lighting/jump.h"
#include "systems/lighting/leaves.h"

/* What light in the tree follows from, beside the tree itself. */
typedef struct lit_by {
    kd_settings settings;
    uint32_t lights, sky;
    float brightest, unit;
    bool feeds;
} lit_by;

typedef struct inject_state {
    kd_gpu_program inject[4]; /* by kinds of light: bit 0 directional, bit 1 local */
    bool tried[4];            /* a program that failed is not compiled again every frame */
    kd_gpu_program enclosed;
    bool tried_enclosed;
    kd_gpu_buffer open; /* float of each light: whether matter shuts it in */
    lit_by now;
    uint32_t same_since; /* kd_svo.runs from which on it has been the same */
} inject_state;

static kd_gpu_program find_program(kd_gpu *gpu, inject_state *state, const kd_lighting *lighting)
{
    static const char *const words[] = {"DIRECTIONAL", "LOCAL"};
    const char *defines[3] = {NULL}; /* NULL ends them */
    const bool there[] = {lighting->directional_count > 0,
                          lighting->light_count > lighting->directional_count};
    uint32_t kinds = 0, count = 0;
    for (uint32_t i = 0; i < 2; i++)
        if (there[i]) {
            kinds |= 1u << i;
            defines[count++] = words[i];
        }
    if (!state->tried[kinds])
        state->inject[kinds] = kd_gpu_make_program(
            gpu, &(kd_gpu_program_desc){.compute = "shaders/lighting/inject.comp", .defines = defines});
    state->tried[kinds] = true;
    return state->inject[kinds];
}

void lighting_bind_leaves(kd_gpu *gpu, const kd_svo *svo)
{
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, svo->uniform, 0, sizeof(struct kd_tree_params));
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->leaves);
    kd_gpu_bind_storage(gpu, 2, svo->moving);
    kd_gpu_bind_storage(gpu, 3, svo->static_albedo);
    kd_gpu_bind_storage(gpu, 4, svo->static_emission);
    kd_gpu_bind_storage(gpu, 5, svo->dynamic_cells);
    kd_gpu_bind_storage(gpu, 7, svo->book);
}

static void bind_lights(kd_gpu *gpu, const kd_lighting *lighting)
{
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_VIEW, lighting->view, 0, sizeof(struct kd_view_params));
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_LIGHTS, lighting->lights, 0, sizeof(struct kd_lights_params));
    kd_gpu_bind_texture(gpu, KD_UNIT_SHADOW_DIRECTIONAL, lighting->shadow_directional);
    kd_gpu_bind_texture(gpu, KD_UNIT_SHADOW_SPOT, lighting->shadow_spot);
}

/* Look from each local light at what is round it. Wants the pass's parameters bound. */
static void find_enclosed(kd_gpu *gpu, inject_state *state, const kd_lighting *lighting, const kd_svo *svo)
{
    if (!state->open.id)
        state->open = kd_gpu_make_buffer(
            gpu, &(kd_gpu_buffer_desc){.size = KD_MAX_LIGHTS * 4, .zeroed = true, .name = "lights.open"});
    if (lighting->light_count == lighting->directional_count)
        return;
    if (!state->tried_enclosed)
        state->enclosed =
            kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/lighting/enclosed.comp"});
    state->tried_enclosed = true;
    lighting_bind_leaves(gpu, svo);
    kd_gpu_bind_storage(gpu, 3, svo->index);
    kd_gpu_bind_storage(gpu, 4, svo->nodes);
    kd_gpu_bind_storage(gpu, 6, state->open);
    kd_gpu_dispatch_linear(gpu, state->enclosed, (lighting->light_count + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

static void inject(kd_system_context *context, bool send_out)
{
    inject_state *state = context->user;
    const kd_bounce *bounce = kd_singleton(context->world, kd_bounce);
    bool lamps = kd_singleton(context->world, kd_frame)->settings.light_bounces != KD_BOUNCES_NONE;
    const kd_svo *svo = kd_singleton(context->world, kd_svo);
    const kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    kd_gpu *gpu = context->gpu;
    if (!svo->leaves.id || !bounce->entries.id)
        return;
    uint32_t pass[8] = {kd_svo_leaf_parent_level(svo) - KD_DENSE_LOG2,
                        kd_svo_moving_room(svo),
                        svo->runs,
                        0,
                        bounce->frame,
                        send_out ? bounce->period * KD_BOUNCE_MAX_TURNS : 0,
                        lamps};
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, pass, sizeof pass);
    bind_lights(gpu, lighting);
    find_enclosed(gpu, state, lighting, svo);
    lighting_bind_leaves(gpu, svo);
    kd_gpu_bind_storage(gpu, 6, state->open);
    kd_emitters_bind(gpu, kd_singleton(context->world, kd_emitters));
    kd_gpu_bind_texture(gpu, KD_UNIT_BOUNCE, bounce->view);
    kd_gpu_dispatch_indirect(gpu, find_program(gpu, state, lighting), svo->counters, KD_ARGS_ALL * 4);
}

/* Would all leaves get the light that they have, and all that bounces stay as it is? That is so when
 * everything has been the same for as long as light bounces its way round once, and no leaf has changed. How
 * late that becomes known changes nothing, since nothing would change. */
static bool has_settled(inject_state *state, kd_world *world)
{
    const kd_svo *svo = kd_singleton(world, kd_svo);
    const kd_bounce *bounce = kd_singleton(world, kd_bounce);
    const kd_voxel_scene *scene = kd_singleton(world, kd_voxel_scene);
    lit_by now;
    memset(&now, 0, sizeof now);
    now.settings = kd_singleton(world, kd_frame)->settings;
    now.lights = kd_singleton(world, kd_lighting)->version;
    now.sky = kd_singleton(world, kd_sky_light)->version;
    now.brightest = scene->brightest_emission;
    now.unit = scene->stored_unit;
    now.feeds = bounce->feeds;
    if (memcmp(&now, &state->now, sizeof now) != 0)
        state->same_since = svo->runs;
    memcpy(&state->now, &now, sizeof now);
    uint32_t since = state->same_since > svo->changed_run ? state->same_since : svo->changed_run;
    since = since > svo->lit_run ? since : svo->lit_run;
    return !bounce->again && bounce->settling == 0 && svo->lit_known > since + bounce->period + 1;
}

static void run(kd_system_context *context)
{
    kd_bounce *bounce = kd_singleton(context->world, kd_bounce);
    bounce->settled = has_settled(context->user, context->world);
    if (!bounce->settled)
        inject(context, bounce->feeds);
}

static void run_again(kd_system_context *context)
{
    inject(context, true);
}

static bool injects_again(kd_system_context *context)
{
    return kd_frame_needs_voxels(context) && kd_singleton(context->world, kd_bounce)->again;
}

static void fini(kd_system_context *context)
{
    inject_state *state = context->user;
    for (uint32_t i = 0; i < 4; i++)
        kd_gpu_destroy_program(context->gpu, state->inject[i]);
    kd_gpu_destroy_program(context->gpu, state->enclosed);
    kd_gpu_destroy_buffer(context->gpu, state->open);
    free(state);
}

static kd_system_desc inject_desc(inject_state *state)
{
    return (kd_system_desc){
        .name = "light_inject",
        .phase = KD_PHASE_LIGHT_INJECT,
        .where = KD_ON_GPU,
        .components = {KD_USES(kd_svo), KD_USES(kd_lighting), KD_USES(kd_frame), KD_CHANGES(kd_bounce),
                       KD_USES(kd_emitters), KD_USES(kd_voxel_scene), KD_USES(kd_sky_light)},
        .resources = {{"svo.book", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE},
                      {"svo.masks", KD_USE_STORAGE_READ},
                      {"tree.nodes", KD_USE_STORAGE_READ},
                      {"svo.cells", KD_USE_STORAGE_READ},
                      {"svo.counters", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE | KD_USE_INDIRECT},
                      {"tree.uniform", KD_USE_UNIFORM},
                      {"lights.uniform", KD_USE_UNIFORM},
                      {"shadow.maps", KD_USE_SAMPLED},
                      {"bounce", KD_USE_SAMPLED},
                      {"emitters", KD_USE_UNIFORM},
                      {"tree.leaves", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE}},
        .run_if = kd_frame_needs_voxels,
        .no_commands = true,
        .run = run,
        .fini = fini,
        .user = state,
    };
}

kd_status kd_lighting_import(kd_schedule *s)
{
    inject_state *state = calloc(1, sizeof *state);
    if (!state)
        return KD_NO_MEMORY;
    kd_system_desc desc = inject_desc(state);
    kd_status status = emitters_import(s);
    if (!status)
        status = jump_import(s);
    if (!status)
        status = kd_schedule_add(s, &desc);
    if (status)
        return status;
    desc.name = "light_inject_again";
    desc.phase = KD_PHASE_BOUNCE_INJECT;
    desc.run_if = injects_again;
    desc.run = run_again;
    desc.fini = NULL;
    return kd_schedule_add(s, &desc);
}
