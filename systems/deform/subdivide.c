/* System subdivide: the surfaces of the cages that the deform pass has posed. */

#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "systems/deform/internal.h"

_Static_assert(sizeof(kd_stencil_row) == sizeof(struct kd_stencil_row_words) &&
                   sizeof(kd_stencil) == sizeof(struct kd_stencil_words),
               "stencils go to the GPU as they are");

static bool subdivide_needed(kd_system_context *c)
{
    const deform_work *work = deform_work_get(kd_singleton(c->world, kd_joint_palette));
    return work && work->surfaces_due;
}

static void subdivide_run(kd_system_context *c)
{
    const kd_scene_store *store = kd_singleton(c->world, kd_scene_store);
    deform_work *work = deform_work_get(kd_singleton(c->world, kd_joint_palette));
    uint32_t count = work->surface_groups.count;
    const struct kd_deform_params params = {.count = {.x = count}};
    deform_upload(c->gpu, &work->surfaces_buffer, "subdivide items", &work->surfaces, NULL);
    deform_upload(c->gpu, &work->surface_words, "subdivide groups", &work->surface_groups, NULL);
    kd_gpu_bind_uniform(c->gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_storage(c->gpu, KD_DEFORM_GEOMETRY, store->geometry);
    kd_gpu_bind_storage(c->gpu, KD_SUBDIVIDE_ROWS, store->stencil_rows);
    kd_gpu_bind_storage(c->gpu, KD_SUBDIVIDE_STENCILS, store->stencils);
    kd_gpu_bind_storage(c->gpu, KD_DEFORM_ITEMS, work->surfaces_buffer);
    kd_gpu_bind_storage(c->gpu, KD_DEFORM_WORDS, work->surface_words);
    kd_gpu_dispatch(c->gpu, work->subdivide, count < KD_DEFORM_ROW ? count : KD_DEFORM_ROW,
                    (count + KD_DEFORM_ROW - 1) / KD_DEFORM_ROW, 1);
    work->surfaces_due = false;
}

static uint64_t subdivide_bytes(const kd_system_context *c)
{
    const kd_joint_palette *palette = kd_singleton(c->world, kd_joint_palette);
    const deform_work *work = palette->internal;
    /* Rows of regular patches have 16 entries. */
    const uint64_t vertex =
        2 * KD_GEOMETRY_WORDS * sizeof(uint32_t) + sizeof(kd_stencil_row) + 16 * sizeof(kd_stencil);
    return work ? work->surface_groups.count * (uint64_t)KD_DEFORM_GROUP * vertex : 0;
}

static kd_status subdivide_init(kd_system_context *c)
{
    deform_work *work = deform_work_get(kd_singleton(c->world, kd_joint_palette));
    if (!work)
        return kd_fail(KD_NO_MEMORY, "out of memory for subdivision surfaces");
    work->subdivide =
        kd_gpu_make_program(c->gpu, &(kd_gpu_program_desc){.compute = "shaders/deform/subdivide.comp"});
    return work->subdivide.id ? KD_OK : KD_GPU;
}

static void subdivide_fini(kd_system_context *c)
{
    deform_work *work = deform_work_get(kd_singleton(c->world, kd_joint_palette));
    if (!work)
        return;
    kd_gpu_destroy_buffer(c->gpu, work->surfaces_buffer);
    kd_gpu_destroy_buffer(c->gpu, work->surface_words);
    kd_gpu_destroy_program(c->gpu, work->subdivide);
    work->surfaces_buffer = work->surface_words = (kd_gpu_buffer){0};
    work->subdivide = (kd_gpu_program){0};
}

kd_status deform_register_subdivide(kd_schedule *s)
{
    return kd_schedule_add(s,
                           &(kd_system_desc){
                               .name = "subdivide",
                               .phase = KD_PHASE_DEFORM,
                               .where = KD_ON_GPU,
                               .components = {KD_CHANGES(kd_joint_palette), KD_USES(kd_scene_store)},
                               .resources = {{"scene.vertices", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE},
                                             {"scene.static", KD_USE_STORAGE_READ}},
                               .no_commands = true,
                               .run = subdivide_run,
                               .run_if = subdivide_needed,
                               .init = subdivide_init,
                               .fini = subdivide_fini,
                               .bytes_moved = subdivide_bytes,
                           });
}
