/* Systems motion and motion_keep: where each object and each deformed vertex was in the frame before, for the
 * motion that is drawn beside the G-buffer. Matrices are kept by entity on the CPU, since the draw list's
 * numbers change; deformed vertices in a copy of the geometry stream, of which only what deforms is copied
 * every frame. What was not there a frame ago has not moved. */

#include <stdlib.h>
#include <string.h>

#include "components/camera.h"
#include "components/film.h"
#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "components/transform.h"
#include "runtime/core/arena.h"
#include "runtime/core/log.h"
#include "runtime/gpu/gpu.h"
#include "shaders/shared/scene.h"
#include "systems/film/film.h"

typedef struct kept_model {
    uint32_t generation; /* of the entity; 0: none was drawn */
    kd_mat4 model;
} kept_model;

typedef struct motion_state {
    kept_model *kept; /* by entity index */
    uint32_t kept_capacity;
    uint32_t kept_vertices; /* of the geometry stream that are in its copy */
    bool known;             /* there was a frame before */
} motion_state;

static const size_t vertex_bytes = KD_GEOMETRY_WORDS * sizeof(uint32_t);

static bool motion_needed(kd_system_context *context)
{
    return kd_singleton(context->world, kd_film)->layers;
}

static bool keep_needed(kd_system_context *context)
{
    const kd_film *film = kd_singleton(context->world, kd_film);
    return film->layers && kd_film_is_last(film);
}

/* The matrix that takes the draw's vertices to the world: skinned ones are there already. */
static kd_mat4 model_of(const kd_world *w, const kd_scene_store *store, const kd_draw *draw)
{
    const kd_world_transform *world = kd_find(w, draw->entity, kd_world_transform);
    bool skinned = draw->deformed && kd_find(w, draw->entity, kd_skin_instance) &&
                   store->deformed_primitives[draw->primitive].first_skin_vertex != KD_NONE;
    return skinned || !world ? KD_MAT4_IDENTITY : world->matrix;
}

static kd_mat4 previous_model(const motion_state *s, const kd_draw *draw, const kd_mat4 *now)
{
    uint32_t index = draw->entity.index;
    bool known = index < s->kept_capacity && s->kept[index].generation == draw->entity.generation;
    return known ? s->kept[index].model : *now;
}

static void upload_models(kd_system_context *context, const motion_state *s, kd_motion *motion)
{
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    kd_mat4 *models = KD_ARENA_NEW(context->scratch, kd_mat4, list->draw_count + 1ull);
    if (!models) {
        kd_fail(KD_NO_MEMORY, "motion: no memory for %u objects; use a smaller scene", list->draw_count);
        return;
    }
    models[list->draw_count] = KD_MAT4_IDENTITY;
    for (uint32_t i = 0; i < list->draw_count; i++) {
        kd_mat4 now = model_of(context->world, store, &list->draws[i]);
        models[list->draws[i].args.base_instance] = previous_model(s, &list->draws[i], &now);
    }
    size_t size = (list->draw_count + 1ull) * sizeof *models;
    if (kd_gpu_ensure_buffer(context->gpu, &motion->models, size, 0, "motion models") == KD_OK)
        kd_gpu_write_buffer(context->gpu, motion->models, 0, models, size);
}

/* Vertices that came since the last frame are copied as they are now. */
static void follow_geometry(kd_gpu *gpu, const kd_scene_store *store, motion_state *s, kd_motion *motion)
{
    size_t kept = s->kept_vertices * vertex_bytes, size = store->vertex_count * vertex_bytes;
    if (store->vertex_count <= s->kept_vertices || kd_gpu_buffer_size(gpu, store->geometry) < size)
        return;
    if (kd_gpu_ensure_buffer(gpu, &motion->geometry, size, kept, "motion vertices") != KD_OK)
        return;
    kd_gpu_copy_buffer(gpu, store->geometry, kept, motion->geometry, kept, size - kept);
    s->kept_vertices = store->vertex_count;
}

static void motion_run(kd_system_context *context)
{
    motion_state *s = context->user;
    kd_motion *motion = kd_singleton(context->world, kd_motion);
    if (!s->known)
        motion->view_projection = kd_singleton(context->world, kd_view)->view_projection;
    upload_models(context, s, motion);
    follow_geometry(context->gpu, kd_singleton(context->world, kd_scene_store), s, motion);
}

/* ---- after the frame ---- */

static bool reserve_kept(motion_state *s, uint32_t index)
{
    if (index < s->kept_capacity)
        return true;
    uint32_t capacity = index + 1 + index / 2;
    kept_model *more = realloc(s->kept, capacity * sizeof *more);
    if (!more)
        return false;
    memset(more + s->kept_capacity, 0, (capacity - s->kept_capacity) * sizeof *more);
    s->kept = more;
    s->kept_capacity = capacity;
    return true;
}

static void keep_vertices(kd_gpu *gpu, const kd_scene_store *store, const kd_draw_list *list,
                          const motion_state *s, const kd_motion *motion)
{
    for (uint32_t i = 0; i < list->deforming_count; i++) {
        const kd_draw *draw = &list->draws[list->deforming[i]];
        const kd_store_primitive *p = &store->deformed_primitives[draw->primitive];
        size_t offset = p->base_vertex * vertex_bytes;
        if (draw->deformed && p->base_vertex + p->vertex_count <= s->kept_vertices)
            kd_gpu_copy_buffer(gpu, store->geometry, offset, motion->geometry, offset,
                               p->vertex_count * vertex_bytes);
    }
}

static void motion_keep_run(kd_system_context *context)
{
    motion_state *s = context->user;
    const kd_draw_list *list = kd_singleton(context->world, kd_draw_list);
    const kd_scene_store *store = kd_singleton(context->world, kd_scene_store);
    kd_motion *motion = kd_singleton(context->world, kd_motion);
    motion->view_projection = kd_singleton(context->world, kd_view)->view_projection;
    s->known = true;
    for (uint32_t i = 0; i < list->draw_count; i++) {
        const kd_draw *draw = &list->draws[i];
        if (reserve_kept(s, draw->entity.index))
            s->kept[draw->entity.index] =
                (kept_model){draw->entity.generation, model_of(context->world, store, draw)};
    }
    keep_vertices(context->gpu, store, list, s, motion);
}

/* Frees the state: registered first, ends last. */
static void motion_fini(kd_system_context *context)
{
    motion_state *s = context->user;
    kd_motion *motion = kd_singleton(context->world, kd_motion);
    kd_gpu_destroy_buffer(context->gpu, motion->models);
    kd_gpu_destroy_buffer(context->gpu, motion->geometry);
    *motion = (kd_motion){0};
    free(s->kept);
    free(s);
}

#define MOTION_READS                                                                                         \
    KD_USES(kd_film), KD_USES(kd_draw_list), KD_USES(kd_scene_store), KD_USES(kd_world_transform),           \
        KD_USES(kd_skin_instance), KD_USES(kd_view)

kd_status kd_motion_import(kd_schedule *schedule)
{
    motion_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return kd_fail(KD_NO_MEMORY, "motion: no memory for its state; free some");
    kd_status status = kd_schedule_add(
        schedule,
        &(kd_system_desc){.name = "motion",
                          .phase = KD_PHASE_GEOMETRY,
                          .where = KD_ON_GPU,
                          .components = {MOTION_READS, KD_CHANGES(kd_motion)},
                          .resources = {{"scene.vertices", KD_USE_COPY_READ}, {"motion", KD_USE_COPY_WRITE}},
                          .no_commands = true,
                          .run_if = motion_needed,
                          .run = motion_run,
                          .fini = motion_fini,
                          .user = s});
    if (status != KD_OK) {
        free(s);
        return status;
    }
    return kd_schedule_add(schedule, &(kd_system_desc){.name = "motion_keep",
                                                       .phase = KD_PHASE_CAPTURE,
                                                       .where = KD_ON_GPU,
                                                       .components = {MOTION_READS, KD_CHANGES(kd_motion)},
                                                       .resources = {{"scene.vertices", KD_USE_COPY_READ},
                                                                     {"motion", KD_USE_COPY_WRITE}},
                                                       .no_commands = true,
                                                       .run_if = keep_needed,
                                                       .run = motion_keep_run,
                                                       .user = s});
}
