/* System joint_palette: joint_world * inverse_bind of every skin in use, and the list of what is to be
 * deformed. */

#include <stdlib.h>
#include <string.h>

#include "components/transform.h"
#include "runtime/core/log.h"
#include "systems/deform/internal.h"

static void put_rows(const kd_mat4 *m, kd_vec4 rows[3])
{
    for (int r = 0; r < 3; r++)
        rows[r] = (kd_vec4){m->m[r], m->m[4 + r], m->m[8 + r], m->m[12 + r]};
}

/* A joint whose entity is gone keeps the identity: its vertices stay at the rest pose rather than collapse.
 */
static void put_matrices(kd_world *w, const kd_scene_store *store, const kd_store_skin *skin,
                         uint32_t first_joint, kd_vec4 (*rows)[3])
{
    for (uint32_t j = 0; j < skin->joint_count; j++) {
        const kd_world_transform *joint =
            kd_find(w, store->joint_entities[first_joint + j], kd_world_transform);
        kd_mat4 m = joint ? kd_mat4_mul(&joint->matrix, &skin->inverse_bind[j]) : KD_MAT4_IDENTITY;
        put_rows(&m, rows[j]);
    }
}

/* Room for the numbers by first joint, cleared for this frame. */
static bool clear_first_matrices(deform_work *work, uint32_t joints)
{
    if (joints > work->first_matrix_capacity) {
        uint32_t *bigger = realloc(work->first_matrix, (size_t)joints * sizeof *bigger);
        if (!bigger)
            return false;
        work->first_matrix = bigger;
        work->first_matrix_capacity = joints;
    }
    if (joints)
        memset(work->first_matrix, 0, joints * sizeof *work->first_matrix);
    return true;
}

/* Number of the instance's first matrix; UINT32_MAX when memory is out or the instance is not one of the
 * store's. */
static uint32_t place_skin(kd_world *w, deform_work *work, const kd_scene_store *store,
                           const kd_skin_instance *instance)
{
    uint32_t first = instance->first_joint;
    if (instance->skin >= store->skin_count || first >= store->joint_entity_count ||
        store->skins[instance->skin].joint_count > store->joint_entity_count - first)
        return UINT32_MAX;
    if (!work->first_matrix[first]) {
        uint32_t number = work->rows.count;
        kd_vec4(*rows)[3] = deform_array_add(&work->rows, store->skins[instance->skin].joint_count);
        if (!rows)
            return UINT32_MAX;
        put_matrices(w, store, &store->skins[instance->skin], first, rows);
        work->first_matrix[first] = number + 1;
    }
    return work->first_matrix[first] - 1;
}

static bool place_skins(kd_world *w, deform_work *work, const kd_scene_store *store)
{
    bool ok = clear_first_matrices(work, store->joint_entity_count);
    deform_array_turn(&work->rows);
    for (kd_iter it = kd_query_iter(work->skins); ok && kd_iter_next(&it);) {
        const kd_skin_instance *skins = KD_COLUMN(&it, kd_skin_instance, 0);
        for (uint32_t i = 0; i < it.count; i++) {
            uint32_t number = place_skin(w, work, store, &skins[i]);
            if (number != UINT32_MAX && number != skins[i].first_matrix)
                KD_COLUMN_MUT(&it, kd_skin_instance, 0)[i].first_matrix = number;
        }
    }
    work->rows_changed |= deform_array_changed(&work->rows);
    return ok;
}

static void joint_palette_run(kd_system_context *c)
{
    kd_joint_palette *palette = kd_singleton(c->world, kd_joint_palette);
    const kd_scene_store *store = kd_singleton(c->world, kd_scene_store);
    deform_work *work = deform_work_get(palette);
    if (!work)
        return;
    if (!place_skins(c->world, work, store) || !deform_list_work(work, store))
        kd_log(KD_LOG_ERROR, "out of memory for the joints of this frame; some meshes keep their last shape");
    palette->count = work->rows.count;
    palette->rows = (const kd_vec4(*)[3])work->rows.items;
}

static kd_status joint_palette_init(kd_system_context *c)
{
    deform_work *work = deform_work_get(kd_singleton(c->world, kd_joint_palette));
    if (!work)
        return kd_fail(KD_NO_MEMORY, "out of memory for the joint palette");
    work->skins = kd_query_make(
        c->world, &(kd_query_desc){.terms = {KD_WRITE(kd_skin_instance)}, .name = "joint_palette"});
    work->instances = kd_query_make(
        c->world, &(kd_query_desc){.terms = {KD_READ(kd_mesh_instance), KD_OPTIONAL(kd_skin_instance),
                                             KD_OPTIONAL(kd_morph_weights)},
                                   .name = "deform"});
    return work->skins && work->instances ? KD_OK
                                          : kd_fail(KD_NO_MEMORY, "out of memory for the deform queries");
}

static void joint_palette_fini(kd_system_context *c)
{
    deform_work *work = deform_work_get(kd_singleton(c->world, kd_joint_palette));
    if (!work)
        return;
    kd_query_destroy(work->skins);
    kd_query_destroy(work->instances);
    work->skins = work->instances = NULL;
}

kd_status deform_register_joint_palette(kd_schedule *s)
{
    return kd_schedule_add(s, &(kd_system_desc){
                                  .name = "joint_palette",
                                  .phase = KD_PHASE_DEFORM,
                                  .where = KD_ON_CPU,
                                  .components = {KD_CHANGES(kd_joint_palette), KD_CHANGES(kd_skin_instance),
                                                 KD_USES(kd_world_transform), KD_USES(kd_scene_store),
                                                 KD_USES(kd_mesh_instance), KD_USES(kd_morph_weights)},
                                  .no_commands = true,
                                  .run = joint_palette_run,
                                  .init = joint_palette_init,
                                  .fini = joint_palette_fini,
                              });
}
