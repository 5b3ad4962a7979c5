/* System deform: uploads the joint palette and the work list, and rewrites the vertices of all deforming
 * instances with one dispatch. Does not run in a frame in which no joint and no weight has changed. */

#include "systems/deform/deform.h"

#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "systems/deform/internal.h"

static bool deform_needed(kd_system_context *c)
{
    const deform_work *work = deform_work_get(kd_singleton(c->world, kd_joint_palette));
    return work && (work->rows_changed || work->work_changed);
}

void deform_ensure(kd_gpu *gpu, kd_gpu_buffer *buffer, size_t size, const char *name)
{
    size_t old = buffer->id ? kd_gpu_buffer_size(gpu, *buffer) : 0;
    if (size <= old)
        return;
    kd_gpu_destroy_buffer(gpu, *buffer);
    *buffer = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = size + size / 2, .usage = KD_BUFFER_STREAM, .name = name});
}

void deform_upload(kd_gpu *gpu, kd_gpu_buffer *buffer, const char *name, const deform_array *first,
                   const deform_array *second)
{
    const deform_array *const arrays[] = {first, second};
    size_t size = 0, at = 0;
    for (int i = 0; i < 2 && arrays[i]; i++)
        size += (size_t)arrays[i]->count * arrays[i]->item_bytes;
    deform_ensure(gpu, buffer, size, name);
    for (int i = 0; i < 2 && arrays[i]; i++) {
        size_t bytes = (size_t)arrays[i]->count * arrays[i]->item_bytes;
        if (bytes)
            kd_gpu_write_buffer(gpu, *buffer, at, arrays[i]->items, bytes);
        at += bytes;
    }
}

static void upload(kd_gpu *gpu, kd_joint_palette *palette, deform_work *work)
{
    deform_upload(gpu, &palette->matrices, "joint palette", &work->rows, NULL);
    deform_upload(gpu, &work->items_buffer, "deform items", &work->items, NULL);
    deform_upload(gpu, &work->words_buffer, "deform groups", &work->groups, &work->weights);
}

static void dispatch(kd_gpu *gpu, const kd_scene_store *store, const kd_joint_palette *palette,
                     const deform_work *work)
{
    uint32_t count = work->groups.count;
    const struct kd_deform_params params = {.count = {.x = count}};
    kd_gpu_bind_uniform(gpu, KD_BIND_PASS, &params, sizeof params);
    kd_gpu_bind_storage(gpu, KD_DEFORM_GEOMETRY, store->geometry);
    kd_gpu_bind_storage(gpu, KD_DEFORM_SKINS, store->skins_buffer);
    kd_gpu_bind_storage(gpu, KD_DEFORM_MORPHS, store->morphs);
    kd_gpu_bind_storage(gpu, KD_DEFORM_JOINTS, palette->matrices);
    kd_gpu_bind_storage(gpu, KD_DEFORM_ITEMS, work->items_buffer);
    kd_gpu_bind_storage(gpu, KD_DEFORM_WORDS, work->words_buffer);
    kd_gpu_dispatch(gpu, work->program, count < KD_DEFORM_ROW ? count : KD_DEFORM_ROW,
                    (count + KD_DEFORM_ROW - 1) / KD_DEFORM_ROW, 1);
}

static void deform_run(kd_system_context *c)
{
    kd_joint_palette *palette = kd_singleton(c->world, kd_joint_palette);
    const kd_scene_store *store = kd_singleton(c->world, kd_scene_store);
    deform_work *work = deform_work_get(palette);
    upload(c->gpu, palette, work);
    if (work->groups.count)
        dispatch(c->gpu, store, palette, work);
    work->rows_changed = work->work_changed = false;
    work->surfaces_due = work->surfaces.count != 0;
}

static uint64_t deform_bytes(const kd_system_context *c)
{
    const kd_joint_palette *palette = kd_singleton(c->world, kd_joint_palette);
    const deform_work *work = palette->internal;
    const uint64_t vertex = 2 * KD_GEOMETRY_WORDS * sizeof(uint32_t) + KD_SKIN_WORDS * sizeof(uint32_t);
    return work ? work->groups.count * (uint64_t)KD_DEFORM_GROUP * vertex : 0;
}

static kd_status deform_init(kd_system_context *c)
{
    kd_joint_palette *palette = kd_singleton(c->world, kd_joint_palette);
    deform_work *work = deform_work_get(palette);
    if (!work)
        return kd_fail(KD_NO_MEMORY, "out of memory for the joint palette");
    work->program =
        kd_gpu_make_program(c->gpu, &(kd_gpu_program_desc){.compute = "shaders/deform/deform.comp"});
    /* Others bind the palette whether or not anything has joints. */
    deform_ensure(c->gpu, &palette->matrices, 3 * sizeof(kd_vec4), "joint palette");
    deform_ensure(c->gpu, &work->items_buffer, sizeof(struct kd_deform_item), "deform items");
    deform_ensure(c->gpu, &work->words_buffer, 2 * sizeof(uint32_t), "deform groups");
    work->rows_changed = work->work_changed = true;
    return work->program.id ? KD_OK : KD_GPU;
}

static void deform_fini(kd_system_context *c)
{
    kd_joint_palette *palette = kd_singleton(c->world, kd_joint_palette);
    deform_work *work = deform_work_get(palette);
    kd_gpu_destroy_buffer(c->gpu, palette->matrices);
    palette->matrices = (kd_gpu_buffer){0};
    if (!work)
        return;
    kd_gpu_destroy_buffer(c->gpu, work->items_buffer);
    kd_gpu_destroy_buffer(c->gpu, work->words_buffer);
    kd_gpu_destroy_program(c->gpu, work->program);
    work->items_buffer = work->words_buffer = (kd_gpu_buffer){0};
    work->program = (kd_gpu_program){0};
}

kd_status deform_register_deform(kd_schedule *s)
{
    return kd_schedule_add(s,
                           &(kd_system_desc){
                               .name = "deform",
                               .phase = KD_PHASE_DEFORM,
                               .where = KD_ON_GPU,
                               .components = {KD_CHANGES(kd_joint_palette), KD_USES(kd_scene_store)},
                               .resources = {{"scene.joints", KD_USE_COPY_WRITE | KD_USE_STORAGE_READ},
                                             {"scene.vertices", KD_USE_STORAGE_READ | KD_USE_STORAGE_WRITE},
                                             {"scene.static", KD_USE_STORAGE_READ}},
                               .no_commands = true,
                               .run = deform_run,
                               .run_if = deform_needed,
                               .init = deform_init,
                               .fini = deform_fini,
                               .bytes_moved = deform_bytes,
                           });
}

kd_status kd_deform_import(kd_schedule *s)
{
    kd_status status = deform_register_joint_palette(s);
    if (status == KD_OK)
        status = deform_register_deform(s);
    return status == KD_OK ? deform_register_subdivide(s) : status;
}
