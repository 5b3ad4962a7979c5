/* Where an entity stands as another sees it: by the poses that the scenario has set, up the hierarchy, since
 * the world transforms are those of the step before. */
#include "runtime/script/internal.h"

#include <math.h>
#include <string.h>

static void read_named(const kd_component_desc *desc, const char *name, const char *value, void *out,
                       size_t size)
{
    const kd_field *field = script_find_field(desc, name);
    if (field && field->size == size)
        memcpy(out, value + field->offset, size);
}

/* As the hierarchy has it: a local matrix replaces the pose. */
static kd_mat4 local_matrix(const kd_world *w, kd_entity e)
{
    kd_component_id matrix_id = kd_component_find(w, "local_matrix");
    kd_component_id pose_id = kd_component_find(w, "transform");
    const char *matrix = matrix_id ? kd_find_id(w, e, matrix_id) : NULL;
    const char *pose = pose_id ? kd_find_id(w, e, pose_id) : NULL;
    kd_mat4 out = KD_MAT4_IDENTITY;
    kd_vec3 position = {0, 0, 0}, scale = {1, 1, 1};
    kd_quat rotation = {0, 0, 0, 1};
    if (matrix) {
        read_named(kd_component_info(w, matrix_id), "matrix", matrix, &out, sizeof out);
    } else if (pose) {
        const kd_component_desc *desc = kd_component_info(w, pose_id);
        read_named(desc, "position", pose, &position, sizeof position);
        read_named(desc, "rotation", pose, &rotation, sizeof rotation);
        read_named(desc, "scale", pose, &scale, sizeof scale);
        out = kd_mat4_from_trs(position, rotation, scale);
    }
    return out;
}

static kd_mat4 world_matrix(const kd_world *w, kd_entity e)
{
    kd_mat4 out = KD_MAT4_IDENTITY;
    for (; e.generation; e = kd_get_parent(w, e)) {
        kd_mat4 above = local_matrix(w, e);
        out = kd_mat4_mul(&above, &out);
    }
    return out;
}

/* Usually the way up from the target leads past the parent, and nothing has to be inverted. */
bool script_place_below(const kd_world *w, kd_entity target, kd_entity parent, kd_vec3 *out)
{
    kd_vec3 place = {0, 0, 0};
    kd_entity up = target;
    for (; up.generation && !kd_entity_equal(up, parent); up = kd_get_parent(w, up)) {
        kd_mat4 local = local_matrix(w, up);
        place = kd_mat4_point(&local, place);
    }
    if (!kd_entity_equal(up, parent)) {
        kd_mat4 world = world_matrix(w, parent), inverse = kd_mat4_inverse(&world);
        place = kd_mat4_point(&inverse, place);
    }
    if (!isfinite(place.x) || !isfinite(place.y) || !isfinite(place.z))
        return false;
    *out = place;
    return true;
}
