/* One draw of the list: its object, arguments and box. What comes out as it was is not sent to the GPU again.
 */

#include <math.h>
#include <string.h>

#include "components/deform.h"
#include "components/transform.h"
#include "systems/scene/internal.h"

static float determinant(const kd_vec4 r[3])
{
    return r[0].x * (r[1].y * r[2].z - r[1].z * r[2].y) - r[0].y * (r[1].x * r[2].z - r[1].z * r[2].x) +
           r[0].z * (r[1].x * r[2].y - r[1].y * r[2].x);
}

static const kd_vec4 (*skin_rows(const kd_joint_palette *palette, const kd_scene_store *store,
                                 const kd_skin_instance *skin, uint32_t *count))[3]
{
    *count = 0;
    if (!skin || !palette->rows || skin->skin >= store->skin_count)
        return NULL;
    uint32_t joints = store->skins[skin->skin].joint_count;
    if (skin->first_matrix > palette->count || joints > palette->count - skin->first_matrix)
        return NULL;
    *count = joints;
    return joints ? palette->rows + skin->first_matrix : NULL;
}

uint32_t scene_item_material(const kd_scene_store *store, const scene_item *item)
{
    uint32_t own = store->primitives[item->primitive].material;
    uint32_t number = item->instance->material ? item->instance->material - 1 : own;
    return number < store->material_count ? number : 0;
}

void scene_item_finish(const scene_collector *c, scene_item *item)
{
    kd_vec4 rows[3];
    uint32_t count;
    const kd_vec4(*palette)[3] = item->deformed ? skin_rows(c->palette, c->store, item->skin, &count) : NULL;
    scene_matrix_rows(item->world, rows);
    item->mirrored = determinant(palette ? palette[0] : (const kd_vec4 *)rows) < 0;
    uint32_t material = scene_item_material(c->store, item);
    uint64_t mode = (uint64_t)c->store->materials[material].desc.alpha_mode;
    item->order = mode << 33 | (uint64_t)material << 1 | item->mirrored;
    item->entity_order = (uint64_t)item->entity.index << 32 | item->part;
}

/* Rows of the inverse transpose; of a singular matrix the cofactors, which still point the right way. */
static void normal_matrix(const kd_mat4 *m, struct kd_object *object)
{
    const kd_vec3 x = {m->m[0], m->m[1], m->m[2]}, y = {m->m[4], m->m[5], m->m[6]},
                  z = {m->m[8], m->m[9], m->m[10]};
    const kd_vec3 columns[3] = {kd_vec3_cross(y, z), kd_vec3_cross(z, x), kd_vec3_cross(x, y)};
    float det = kd_vec3_dot(x, columns[0]);
    float scale = fabsf(det) > 1e-30f ? 1 / det : 1;
    for (int r = 0; r < 3; r++) {
        const float row[3] = {(&columns[0].x)[r], (&columns[1].x)[r], (&columns[2].x)[r]};
        object->normal_ws[r].x = row[0] * scale;
        object->normal_ws[r].y = row[1] * scale;
        object->normal_ws[r].z = row[2] * scale;
        object->normal_ws[r].w = 0;
    }
}

static void emit_object(struct kd_object *object, const scene_item *item, bool skinned, bool moved,
                        uint32_t material)
{
    const kd_mat4 model = skinned ? KD_MAT4_IDENTITY : *item->world;
    memcpy(object->model_ws.m, model.m, sizeof model.m);
    normal_matrix(&model, object);
    object->info.x = material;
    object->info.y = (item->instance->no_shadow ? KD_OBJECT_NO_SHADOW : 0) |
                     (item->mirrored ? KD_OBJECT_MIRRORED : 0) |
                     (moved || item->deformed ? KD_OBJECT_MOVES : 0);
    object->info.z = item->entity.index;
    object->info.w = 0;
}

/* Deformed vertices stand elsewhere than those of the mesh at rest. */
static const kd_store_primitive *drawn_primitive(const kd_scene_store *store, const scene_item *item,
                                                 uint32_t *number)
{
    const kd_store_mesh *mesh = &store->meshes[item->instance->mesh];
    *number = item->primitive;
    if (!item->deformed)
        return &store->primitives[*number];
    *number = store->deformed[item->instance->deformed - 1].first_primitive +
              (item->primitive - mesh->first_primitive);
    return &store->deformed_primitives[*number];
}

static bool finite_box(const scene_box *box)
{
    return isfinite(box->min.x + box->min.y + box->min.z + box->max.x + box->max.y + box->max.z);
}

/* In the tree of boxes: written where it lies before the tree is built, entered where it stands. */
static void place_draw(scene_draws *d, uint32_t number, const scene_box *box, bool still)
{
    const kd_box b = {box->min, box->max};
    if (!d->standing) {
        d->tree.boxes[number] = b;
        d->tree.still[number] = still;
    } else if (still != d->tree.still[number] || memcmp(&b, &d->tree.boxes[number], sizeof b) != 0) {
        kd_box_tree_set(&d->tree, number, b, still);
    }
}

void scene_emit_draw(const scene_collector *c, const scene_item *item, uint32_t number)
{
    const kd_scene_store *store = c->store;
    scene_draws *d = c->draws;
    uint32_t count = 0, primitive;
    bool skinned =
        item->deformed && item->skin && store->primitives[item->primitive].first_skin_vertex != KD_NONE;
    const kd_vec4(*rows)[3] = skinned ? skin_rows(c->palette, store, item->skin, &count) : NULL;
    scene_box box = scene_primitive_bounds(store->internal, store, item->primitive, item->world, rows, count,
                                           item->deformed ? item->weights : NULL);
    const kd_store_primitive *p = drawn_primitive(store, item, &primitive);
    bool moved = d->shown[item->entity.index].moved;
    const kd_draw_indexed args = {.index_count = p->index_count,
                                  .instance_count = 1,
                                  .first_index = p->first_index,
                                  .base_vertex = (int32_t)p->base_vertex,
                                  .base_instance = number};
    struct kd_object object;
    emit_object(&object, item, skinned, moved, scene_item_material(store, item));
    if (!d->standing || memcmp(&object, &d->objects[number], sizeof object) != 0 ||
        memcmp(&args, &d->args[number], sizeof args) != 0)
        scene_mark_dirty(d, number);
    d->objects[number] = object;
    d->args[number] = args;
    d->draws[number] = (kd_draw){.args = args,
                                 .entity = item->entity,
                                 .primitive = primitive,
                                 .deformed = item->deformed,
                                 .moved = moved,
                                 .bounds_min_ws = box.min,
                                 .bounds_max_ws = box.max};
    place_draw(d, number, &box, !moved && !item->deformed && !item->instance->no_voxels && finite_box(&box));
}
