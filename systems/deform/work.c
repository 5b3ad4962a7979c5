/* The list of what the deform pass does, and the arrays that remember their last frame. */

#include <stdlib.h>
#include <string.h>

#include "systems/deform/internal.h"

void *deform_array_add(deform_array *a, uint32_t n)
{
    uint64_t needed = (uint64_t)a->count + n;
    if (needed > a->capacity) {
        uint64_t target = needed + needed / 2 + 16;
        void *bigger = target <= INT32_MAX ? realloc(a->items, (size_t)target * a->item_bytes) : NULL;
        if (!bigger)
            return NULL;
        a->items = bigger;
        a->capacity = (uint32_t)target;
    }
    void *out = (char *)a->items + (size_t)a->count * a->item_bytes;
    memset(out, 0, (size_t)n * a->item_bytes);
    a->count = (uint32_t)needed;
    return out;
}

void deform_array_turn(deform_array *a)
{
    deform_array last = *a;
    a->items = last.previous;
    a->capacity = last.previous_capacity;
    a->count = 0;
    a->previous = last.items;
    a->previous_capacity = last.capacity;
    a->previous_count = last.count;
}

bool deform_array_changed(const deform_array *a)
{
    return a->count != a->previous_count ||
           (a->count && memcmp(a->items, a->previous, (size_t)a->count * a->item_bytes) != 0);
}

static void release(kd_joint_palette *palette)
{
    deform_work *work = palette->internal;
    deform_array *const arrays[] = {&work->rows,    &work->items,    &work->groups,
                                    &work->weights, &work->surfaces, &work->surface_groups};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) {
        free(arrays[i]->items);
        free(arrays[i]->previous);
    }
    free(work->first_matrix);
    free(work);
    *palette = (kd_joint_palette){0};
}

deform_work *deform_work_get(kd_joint_palette *palette)
{
    if (palette && !palette->internal) {
        deform_work *work = calloc(1, sizeof *work);
        if (!work)
            return NULL;
        work->rows.item_bytes = 3 * sizeof(kd_vec4);
        work->items.item_bytes = sizeof(struct kd_deform_item);
        work->groups.item_bytes = work->weights.item_bytes = 2 * sizeof(uint32_t);
        work->surfaces.item_bytes = sizeof(struct kd_subdivide_item);
        work->surface_groups.item_bytes = 2 * sizeof(uint32_t);
        palette->internal = work;
        palette->release = release;
    }
    return palette ? palette->internal : NULL;
}

/* Targets that weigh nothing are left out: a face with fifty shapes mostly shows three. Returns how many were
 * added. */
static bool add_weights(deform_work *work, const kd_morph_weights *weights, uint32_t targets, uint32_t *added)
{
    *added = 0;
    for (uint32_t t = 0; weights && t < weights->count && t < targets; t++) {
        uint32_t *pair = weights->weights[t] != 0 ? deform_array_add(&work->weights, 1) : NULL;
        if (!pair && weights->weights[t] != 0)
            return false;
        if (pair) {
            pair[0] = t;
            memcpy(&pair[1], &weights->weights[t], sizeof pair[1]);
            ++*added;
        }
    }
    return true;
}

static bool add_groups(deform_array *groups, uint32_t item, uint32_t vertex_count)
{
    for (uint32_t v = 0; v < vertex_count; v += KD_DEFORM_GROUP) {
        uint32_t *pair = deform_array_add(groups, 1);
        if (!pair)
            return false;
        pair[0] = item;
        pair[1] = v;
    }
    return true;
}

static bool add_surface(deform_work *work, const kd_store_primitive *rest, const kd_store_primitive *own)
{
    uint32_t number = work->surfaces.count;
    struct kd_subdivide_item *item = deform_array_add(&work->surfaces, 1);
    if (!item)
        return false;
    item->range.x = rest->base_vertex;
    item->range.y = own->base_vertex;
    item->range.z = own->vertex_count;
    item->range.w = rest->first_row;
    item->cage.x = own->base_vertex + own->vertex_count;
    return add_groups(&work->surface_groups, number, own->vertex_count);
}

/* What moves is the cage, where there is one: its vertices stand behind the surface's in every stream. */
static bool add_primitive(deform_work *work, const kd_store_primitive *rest, const kd_store_primitive *own,
                          const kd_skin_instance *skin, uint32_t joints, uint32_t first_weight,
                          uint32_t weight_count, uint32_t targets)
{
    const uint32_t behind = rest->cage_count ? rest->vertex_count : 0;
    uint32_t number = work->items.count;
    struct kd_deform_item *item = deform_array_add(&work->items, 1);
    if (!item)
        return false;
    bool skinned = skin && joints && rest->first_skin_vertex != KD_NONE;
    item->range.x = rest->base_vertex + behind;
    item->range.y = own->base_vertex + behind;
    item->range.z = rest->cage_count ? rest->cage_count : own->vertex_count;
    item->range.w = skinned ? rest->first_skin_vertex + behind : KD_DEFORM_NONE;
    item->morph.x = rest->first_morph_vertex + targets * behind;
    item->morph.y =
        2 * first_weight; /* counted from the weights; they follow the groups, see deform_list_work */
    item->morph.z = rest->first_morph_vertex != KD_NONE ? weight_count : 0;
    item->skin.x = skinned ? skin->first_matrix : 0;
    item->skin.y = skinned ? joints : 0;
    bool ok = add_groups(&work->groups, number, item->range.z);
    return ok && rest->cage_count ? add_surface(work, rest, own) : ok;
}

static bool add_instance(deform_work *work, const kd_scene_store *store, const kd_mesh_instance *instance,
                         const kd_skin_instance *skin, const kd_morph_weights *weights)
{
    const kd_store_deformed *deformed = &store->deformed[instance->deformed - 1];
    const kd_store_mesh *mesh = &store->meshes[deformed->mesh];
    uint32_t joints = skin && skin->skin < store->skin_count ? store->skins[skin->skin].joint_count : 0;
    uint32_t first_weight = work->weights.count, weight_count;
    bool ok = add_weights(work, weights, mesh->morph_count, &weight_count);
    for (uint32_t i = 0; ok && i < mesh->primitive_count; i++) {
        const kd_store_primitive *rest = &store->primitives[mesh->first_primitive + i];
        const kd_store_primitive *own = &store->deformed_primitives[deformed->first_primitive + i];
        if (own->base_vertex !=
            rest->base_vertex) /* else it has no vertices of its own: it does not deform */
            ok = add_primitive(work, rest, own, skin, joints, first_weight, weight_count, mesh->morph_count);
    }
    return ok;
}

bool deform_list_work(deform_work *work, const kd_scene_store *store)
{
    bool ok = true;
    deform_array_turn(&work->items);
    deform_array_turn(&work->groups);
    deform_array_turn(&work->weights);
    deform_array_turn(&work->surfaces);
    deform_array_turn(&work->surface_groups);
    for (kd_iter it = kd_query_iter(work->instances); kd_iter_next(&it);) {
        const kd_mesh_instance *instances = KD_COLUMN(&it, kd_mesh_instance, 0);
        const kd_skin_instance *skins = KD_COLUMN(&it, kd_skin_instance, 1);
        const kd_morph_weights *weights = KD_COLUMN(&it, kd_morph_weights, 2);
        for (uint32_t i = 0; ok && i < it.count; i++)
            if (instances[i].deformed && instances[i].deformed <= store->deformed_count &&
                store->deformed[instances[i].deformed - 1].mesh == instances[i].mesh && !instances[i].hidden)
                ok = add_instance(work, store, &instances[i], skins ? &skins[i] : NULL,
                                  weights ? &weights[i] : NULL);
    }
    struct kd_deform_item *items = work->items.items;
    for (uint32_t i = 0; i < work->items.count; i++)
        items[i].morph.y += 2 * work->groups.count;
    work->work_changed |= deform_array_changed(&work->items) || deform_array_changed(&work->groups) ||
                          deform_array_changed(&work->weights) || deform_array_changed(&work->surfaces);
    return ok;
}
