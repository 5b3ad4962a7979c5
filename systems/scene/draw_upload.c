/* System draw_upload: the draw list's objects and arguments to the GPU, when they differ from what is there.
 */

#include <stdlib.h>

#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "systems/scene/internal.h"

static bool upload_needed(kd_system_context *c)
{
    const scene_draws *d = scene_draws_get(kd_singleton(c->world, kd_draw_list));
    return d && d->changed;
}

static void destroy_buffers(kd_gpu *gpu, kd_draw_list *list)
{
    kd_gpu_buffer *const buffers[] = {&list->objects, &list->object_ids, &list->args};
    for (size_t i = 0; i < sizeof buffers / sizeof *buffers; i++) {
        kd_gpu_destroy_buffer(gpu, *buffers[i]);
        *buffers[i] = (kd_gpu_buffer){0};
    }
}

static bool make_buffers(kd_gpu *gpu, kd_draw_list *list, uint32_t capacity)
{
    uint32_t *ids = malloc(capacity * sizeof *ids);
    if (!ids)
        return false;
    for (uint32_t i = 0; i < capacity; i++)
        ids[i] = i;
    destroy_buffers(gpu, list);
    list->objects = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = capacity * sizeof(struct kd_object),
                                                                  .usage = KD_BUFFER_STREAM,
                                                                  .name = "objects"});
    list->args = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = capacity * sizeof(kd_draw_indexed),
                                                               .usage = KD_BUFFER_STREAM,
                                                               .name = "draw arguments"});
    list->object_ids = kd_gpu_make_buffer(
        gpu, &(kd_gpu_buffer_desc){.size = capacity * sizeof *ids, .data = ids, .name = "object numbers"});
    free(ids);
    return true;
}

/* Send the draws [first, end). */
static void send(kd_gpu *gpu, const kd_draw_list *list, const scene_draws *d, uint32_t first, uint32_t end)
{
    uint32_t count = end - first;
    kd_gpu_write_buffer(gpu, list->objects, first * sizeof *d->objects, d->objects + first,
                        count * sizeof *d->objects);
    kd_gpu_write_buffer(gpu, list->args, first * sizeof *d->args, d->args + first, count * sizeof *d->args);
}

/* Runs of what is dirty, each at once. */
static void send_dirty(kd_gpu *gpu, const kd_draw_list *list, scene_draws *d)
{
    uint32_t blocks = (list->draw_count + SCENE_DIRTY_DRAWS - 1) / SCENE_DIRTY_DRAWS, first = 0, end = 0;
    d->sent = 0;
    for (uint32_t w = 0; w * 64 < blocks; w++) {
        for (uint64_t bits = d->dirty[w]; bits; bits &= bits - 1) {
            uint32_t at = (w * 64 + (uint32_t)__builtin_ctzll(bits)) * SCENE_DIRTY_DRAWS;
            if (at >= list->draw_count)
                break;
            if (at != end && end > first)
                send(gpu, list, d, first, end);
            first = at == end ? first : at;
            end = at + SCENE_DIRTY_DRAWS < list->draw_count ? at + SCENE_DIRTY_DRAWS : list->draw_count;
            d->sent += end - at;
        }
        d->dirty[w] = 0;
    }
    if (end > first)
        send(gpu, list, d, first, end);
}

static void draw_upload_run(kd_system_context *c)
{
    kd_draw_list *list = kd_singleton(c->world, kd_draw_list);
    scene_draws *d = scene_draws_get(list);
    if (!d->gpu_capacity || d->gpu_capacity < list->draw_count) {
        uint32_t capacity = d->capacity ? d->capacity : 1;
        if (capacity > d->most)
            capacity = d->most;
        if (!make_buffers(c->gpu, list, capacity)) {
            kd_log(KD_LOG_ERROR, "out of memory for the draw list's buffers; it is tried again");
            return;
        }
        d->gpu_capacity = capacity;
        for (uint32_t i = 0; i < list->draw_count; i += SCENE_DIRTY_DRAWS)
            scene_mark_dirty(d, i);
    }
    send_dirty(c->gpu, list, d);
    d->changed = false;
}

static uint64_t draw_upload_bytes(const kd_system_context *c)
{
    const scene_draws *d = scene_draws_get(kd_singleton(c->world, kd_draw_list));
    return (d ? d->sent : 0) * (sizeof(struct kd_object) + sizeof(kd_draw_indexed));
}

static kd_status draw_upload_init(kd_system_context *c)
{
    scene_draws *d = scene_draws_get(kd_singleton(c->world, kd_draw_list));
    if (!d)
        return kd_fail(KD_NO_MEMORY, "out of memory for the draw list");
    d->most = (uint32_t)((size_t)kd_gpu_get_info(c->gpu)->max_ssbo_bytes / sizeof(struct kd_object));
    d->changed = true; /* so that the buffers stand even in a world without meshes */
    return KD_OK;
}

static void draw_upload_fini(kd_system_context *c)
{
    kd_draw_list *list = kd_singleton(c->world, kd_draw_list);
    scene_draws *d = scene_draws_get(list);
    destroy_buffers(c->gpu, list);
    if (d) {
        d->gpu_capacity = 0;
        d->changed = true;
    }
}

kd_status scene_register_draw_upload(kd_schedule *s)
{
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "draw_upload",
                                  .phase = KD_PHASE_CULL,
                                  .where = KD_ON_GPU,
                                  .components = {KD_CHANGES(kd_draw_list)},
                                  .resources = {{"scene.objects", KD_USE_COPY_WRITE}},
                                  .no_commands = true,
                                  .run = draw_upload_run,
                                  .run_if = upload_needed,
                                  .init = draw_upload_init,
                                  .fini = draw_upload_fini,
                                  .bytes_moved = draw_upload_bytes,
                              });
}
