/* System hierarchy: world transforms, parents before children. Only rows that the world has stamped since the
 * last run are computed, and all children when one of these has any; only matrices that differ are written,
 * so that "changed since" means moved to whoever asks. */

#include "systems/hierarchy/hierarchy.h"

#include <stdlib.h>
#include <string.h>

#include "components/transform.h"
#include "runtime/core/log.h"
#include "runtime/ecs/observer.h"

typedef struct hierarchy_state {
    kd_query *placed;
    kd_query *unplaced; /* have a pose but no world transform yet */
    uint64_t version;   /* of the world after the last run; 0: none */
    bool everything;    /* is to be computed: something came or went that rows of children do not tell */
    bool deeper;        /* children of what was placed in this run are to follow */
} hierarchy_state;

static kd_mat4 local_matrix(const kd_transform *pose, const kd_local_matrix *matrix)
{
    if (matrix)
        return matrix->matrix;
    return pose ? kd_mat4_from_trs(pose->position, pose->rotation, pose->scale) : KD_MAT4_IDENTITY;
}

/* World matrix of an entity's parent: that of the nearest ancestor that has one, times the poses between.
 * Returns false when no ancestor has either. */
static bool parent_world(const kd_world *w, kd_entity parent, kd_mat4 *out)
{
    bool found = false;
    *out = KD_MAT4_IDENTITY;
    for (; parent.generation; parent = kd_get_parent(w, parent)) {
        const kd_world_transform *world = kd_find(w, parent, kd_world_transform);
        const kd_transform *pose = kd_find(w, parent, kd_transform);
        const kd_local_matrix *matrix = kd_find(w, parent, kd_local_matrix);
        kd_mat4 step = world ? world->matrix : local_matrix(pose, matrix);
        *out = found ? kd_mat4_mul(&step, out) : step;
        found = found || world || pose || matrix;
        if (world)
            break;
    }
    return found;
}

static kd_mat4 place(const kd_transform *pose, const kd_local_matrix *matrix, const kd_mat4 *parent)
{
    kd_mat4 local = local_matrix(pose, matrix);
    return parent ? kd_mat4_mul(parent, &local) : local;
}

/* Whether a row's children have to follow: its matrix has changed, or is its own affair. */
static bool leads(const kd_world *w, kd_entity e, bool changed, bool posed)
{
    return (changed || !posed) && kd_first_child(w, e).generation != 0;
}

static void place_rows(hierarchy_state *state, const kd_world *w, kd_iter *it)
{
    const kd_world_transform *worlds = KD_COLUMN(it, kd_world_transform, 0);
    const kd_transform *poses = KD_COLUMN(it, kd_transform, 1);
    const kd_local_matrix *matrices = KD_COLUMN(it, kd_local_matrix, 2);
    kd_world_transform *out = NULL;
    kd_entity last = KD_NO_ENTITY;
    kd_mat4 above;
    const kd_mat4 *parent = NULL;
    for (uint32_t i = 0; i < it->count; i++) {
        kd_entity e = kd_get_parent(w, it->entities[i]);
        if (!kd_entity_equal(e, last)) { /* siblings mostly stand together */
            last = e;
            parent = parent_world(w, e, &above) ? &above : NULL;
        }
        bool posed = poses || matrices || parent; /* else it stays where it was put */
        kd_mat4 world = posed ? place(poses ? &poses[i] : NULL, matrices ? &matrices[i] : NULL, parent)
                              : worlds[i].matrix;
        bool changed = memcmp(&world, &worlds[i].matrix, sizeof world) != 0;
        state->deeper = state->deeper || leads(w, it->entities[i], changed, posed);
        if (!changed)
            continue;
        if (!out)
            out = KD_COLUMN_MUT(it, kd_world_transform, 0);
        out[i].matrix = world;
    }
}

/* Entities that came without a world transform get one with the next merge, already at its place. */
static void place_new(kd_system_context *c, hierarchy_state *state)
{
    for (kd_iter it = kd_query_iter(state->unplaced); kd_iter_next(&it);) {
        const kd_transform *poses = KD_COLUMN(&it, kd_transform, 0);
        const kd_local_matrix *matrices = KD_COLUMN(&it, kd_local_matrix, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            kd_mat4 above;
            bool has_parent = parent_world(c->world, kd_get_parent(c->world, it.entities[i]), &above);
            kd_world_transform world = {
                place(poses ? &poses[i] : NULL, matrices ? &matrices[i] : NULL, has_parent ? &above : NULL)};
            state->everything = state->everything || leads(c->world, it.entities[i], true, true);
            kd_commands_set(c->commands, it.entities[i], (kd_value){&kd_world_transform_desc, &world});
        }
    }
}

static void hierarchy_run(kd_system_context *c)
{
    hierarchy_state *state = c->user;
    kd_iter changed = kd_query_iter(state->placed);
    changed.changed_since = state->everything ? 0 : state->version;
    state->deeper = state->everything = false;
    while (kd_iter_next(&changed))
        place_rows(state, c->world, &changed);
    for (kd_iter it = kd_query_iter(state->placed);
         state->deeper && changed.changed_since && kd_iter_next(&it);)
        if (it.parents)
            place_rows(state, c->world, &it);
    place_new(c, state);
    state->version = kd_world_version(c->world);
}

/* What a child hangs from may be further up from now on. */
static void note_removal(kd_world *w, const kd_observed *what, void *user)
{
    hierarchy_state *state = user;
    (void)w;
    (void)what;
    state->everything = true;
}

static kd_status hierarchy_init(kd_system_context *c)
{
    hierarchy_state *state = c->user;
    state->placed = kd_query_make(
        c->world, &(kd_query_desc){.terms = {KD_WRITE(kd_world_transform), KD_OPTIONAL(kd_transform),
                                             KD_OPTIONAL(kd_local_matrix)},
                                   .by_depth = true,
                                   .name = "hierarchy"});
    state->unplaced =
        kd_query_make(c->world, &(kd_query_desc){.terms = {KD_ANY(kd_transform), KD_ANY(kd_local_matrix),
                                                           KD_WITHOUT(kd_world_transform)},
                                                 .by_depth = true,
                                                 .name = "hierarchy, new ones"});
    bool ready = state->placed && state->unplaced &&
                 kd_observe(c->world, &kd_world_transform_desc, KD_ON_REMOVE, note_removal, state) == KD_OK;
    return ready ? KD_OK : kd_fail(KD_NO_MEMORY, "out of memory for the hierarchy's queries");
}

static void hierarchy_fini(kd_system_context *c)
{
    hierarchy_state *state = c->user;
    kd_unobserve(c->world, &kd_world_transform_desc, note_removal, state);
    kd_query_destroy(state->placed);
    kd_query_destroy(state->unplaced);
    free(state);
}

kd_status kd_hierarchy_import(kd_schedule *s)
{
    hierarchy_state *state = calloc(1, sizeof *state);
    if (!state)
        return kd_fail(KD_NO_MEMORY, "out of memory for the hierarchy system");
    kd_status status = kd_schedule_add(s, &(kd_system_desc){
                                              .name = "hierarchy",
                                              .phase = KD_PHASE_HIERARCHY,
                                              .where = KD_ON_CPU,
                                              .components = {KD_CHANGES(kd_world_transform),
                                                             KD_USES(kd_transform), KD_USES(kd_local_matrix)},
                                              .run = hierarchy_run,
                                              .init = hierarchy_init,
                                              .fini = hierarchy_fini,
                                              .user = state,
                                          });
    if (status != KD_OK)
        free(state);
    return status;
}
