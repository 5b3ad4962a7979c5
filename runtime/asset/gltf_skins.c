/* Skins, cameras and lights: short lists that nodes point at. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"

#define PI_F 3.14159265f

/* ---- skins ---- */

static kd_status load_inverse_bind(gltf_loader *l, size_t index, kd_skin_desc *out)
{
    const gltf_skin *s = &l->doc.skins[index];
    char where[64];
    snprintf(where, sizeof where, "skins[%zu].inverseBindMatrices", index);
    kd_mat4 *matrices;
    kd_status status = gltf_alloc(l, &l->kept, out->joint_count, sizeof *matrices, &matrices);
    if (status)
        return status;
    out->inverse_bind = matrices;
    for (uint32_t i = 0; i < out->joint_count; i++)
        matrices[i] = KD_MAT4_IDENTITY;
    if (s->inverse_bind == -1)
        return KD_OK;
    gltf_span span;
    status = gltf_span_of(l, s->inverse_bind, where, &span);
    if (status)
        return status;
    if (span.component != GLTF_FLOAT || span.width != 16)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "not float matrices of 4 by 4 (%s, accessor %d); export the model again", where,
                         s->inverse_bind);
    if (span.count < out->joint_count)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "%u matrices for %u joints (%s, accessor %d); export the model again", span.count,
                         out->joint_count, where, s->inverse_bind);
    return gltf_read_floats(l, &span, NULL, out->joint_count, (float *)matrices, 16, where);
}

static kd_status load_skin(gltf_loader *l, size_t index, kd_skin_desc *out)
{
    const gltf_skin *s = &l->doc.skins[index];
    out->name = gltf_name(l, s->name, "skin", index);
    if (s->joints.count < 1 || s->joints.count > GLTF_JOINTS_MAX)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "%zu joints, not 1 to %u (skins[%zu].joints); export the model again",
                         s->joints.count, GLTF_JOINTS_MAX, index);
    uint32_t *joints;
    kd_status status = gltf_alloc(l, &l->kept, s->joints.count, sizeof *joints, &joints);
    if (status)
        return status;
    for (size_t i = 0; i < s->joints.count; i++) {
        int joint = s->joints.at[i];
        if (joint < 0 || (size_t)joint >= l->doc.node_count)
            return gltf_fail(l, KD_BAD_FORMAT,
                             "there is no node %d (skins[%zu].joints[%zu]); export the model again", joint,
                             index, i);
        joints[i] = l->node_of[joint];
    }
    out->joints = joints;
    out->joint_count = (uint32_t)s->joints.count;
    return load_inverse_bind(l, index, out);
}

/* A skin that no drawn node wears may name joints outside the model: the first node stands in, for nothing
 * reads it. */
static void ground_idle_joints(const kd_skin_desc *skin)
{
    uint32_t *joints = (uint32_t *)skin->joints; /* made by load_skin, const for readers */
    for (uint32_t i = 0; i < skin->joint_count; i++)
        if (joints[i] == KD_NONE)
            joints[i] = 0;
}

kd_status gltf_load_skins(gltf_loader *l)
{
    kd_skin_desc *skins;
    kd_status status = gltf_alloc(l, &l->kept, l->doc.skin_count, sizeof *skins, &skins);
    for (size_t i = 0; !status && i < l->doc.skin_count; i++) {
        status = load_skin(l, i, &skins[i]);
        if (!status)
            ground_idle_joints(&skins[i]);
    }
    l->model->skins = skins;
    l->model->skin_count = (uint32_t)l->doc.skin_count;
    return status;
}

/* ---- cameras ---- */

static kd_status load_camera(gltf_loader *l, size_t index, kd_model_camera *out)
{
    const gltf_camera *c = &l->doc.cameras[index];
    double from[6] = {c->fov_y, c->aspect, c->x_mag, c->y_mag, c->z_near, c->z_far};
    float v[6];
    if (!gltf_floats(from, 6, v))
        return gltf_fail(l, KD_BAD_FORMAT, "a number is not finite (cameras[%zu]); export the model again",
                         index);
    out->name = gltf_name(l, c->name, "camera", index);
    out->orthographic = c->orthographic;
    out->fov_y = v[0];
    out->aspect = v[1];
    out->x_mag = fabsf(v[2]);
    out->y_mag = fabsf(v[3]);
    out->z_near = v[4];
    out->z_far = v[5];
    if (out->orthographic && (out->x_mag == 0 || out->y_mag == 0 || v[4] < 0 || v[5] <= v[4]))
        return gltf_fail(
            l, KD_BAD_FORMAT,
            "magnifications must not be 0, and 0 <= znear < zfar (cameras[%zu].orthographic); correct them",
            index);
    if (!out->orthographic &&
        (v[0] <= 0 || v[0] >= PI_F || v[1] < 0 || v[4] <= 0 || v[5] < 0 || (v[5] > 0 && v[5] <= v[4])))
        return gltf_fail(
            l, KD_BAD_FORMAT,
            "yfov must lie between 0 and pi, and 0 < znear < zfar (cameras[%zu].perspective); correct them",
            index);
    return KD_OK;
}

kd_status gltf_load_cameras(gltf_loader *l)
{
    kd_model_camera *cameras;
    kd_status status = gltf_alloc(l, &l->kept, l->doc.camera_count, sizeof *cameras, &cameras);
    for (size_t i = 0; !status && i < l->doc.camera_count; i++)
        status = load_camera(l, i, &cameras[i]);
    l->model->cameras = cameras;
    l->model->camera_count = (uint32_t)l->doc.camera_count;
    return status;
}

/* ---- lights (KHR_lights_punctual) ---- */

static kd_status light_type(gltf_loader *l, size_t index, kd_light_type *out)
{
    const char *type = l->doc.lights[index].type;
    if (strcmp(type, "directional") == 0)
        *out = KD_LIGHT_DIRECTIONAL;
    else if (strcmp(type, "point") == 0)
        *out = KD_LIGHT_POINT;
    else if (strcmp(type, "spot") == 0)
        *out = KD_LIGHT_SPOT;
    else
        return gltf_fail(
            l, KD_BAD_FORMAT,
            "'%.40s' is no light type (KHR_lights_punctual.lights[%zu]); use directional, point or spot",
            type, index);
    return KD_OK;
}

static kd_status load_light(gltf_loader *l, size_t index, kd_model_light *out)
{
    const gltf_light *light = &l->doc.lights[index];
    float color[3] = {1, 1, 1}, v[4];
    double from[4] = {light->intensity, light->range, light->inner_cone, light->outer_cone};
    if (!gltf_floats(from, 4, v) || (light->color.count && light->color.count != 3) ||
        !gltf_floats(light->color.at, light->color.count, color) || v[0] < 0 ||
        fminf(fminf(color[0], color[1]), color[2]) < 0)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "colour and intensity must be finite and not negative "
                         "(KHR_lights_punctual.lights[%zu]); correct them",
                         index);
    out->name = gltf_name(l, light->name, "light", index);
    out->color = (kd_vec3){color[0], color[1], color[2]};
    out->intensity = v[0];
    out->range = fmaxf(v[1], 0);
    out->inner_cone = v[2];
    out->outer_cone = v[3];
    kd_status status = light_type(l, index, &out->type);
    if (!status && out->type == KD_LIGHT_SPOT && !(v[2] >= 0 && v[2] < v[3] && v[3] <= PI_F / 2 + 1e-5f))
        status = gltf_fail(
            l, KD_BAD_FORMAT,
            "cones must be 0 <= inner < outer <= pi/2 (KHR_lights_punctual.lights[%zu].spot); correct them",
            index);
    return status;
}

kd_status gltf_load_lights(gltf_loader *l)
{
    kd_model_light *lights;
    kd_status status = gltf_alloc(l, &l->kept, l->doc.light_count, sizeof *lights, &lights);
    for (size_t i = 0; !status && i < l->doc.light_count; i++)
        status = load_light(l, i, &lights[i]);
    l->model->lights = lights;
    l->model->light_count = (uint32_t)l->doc.light_count;
    return status;
}
