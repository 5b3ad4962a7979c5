#include "systems/animation/properties.h"

#include <string.h>

#include "components/camera.h"
#include "components/light.h"
#include "systems/animation/sample.h"

static const kd_property_channel *find(const kd_clip_desc *clip, kd_property property, uint32_t target)
{
    uint32_t low = 0, high = clip ? clip->property_count : 0;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        const kd_property_channel *c = &clip->properties[middle];
        if (c->target == target && c->property == property)
            return c;
        if (c->target < target || (c->target == target && c->property < property))
            low = middle + 1;
        else
            high = middle;
    }
    return NULL;
}

static void put3(float *out, kd_vec3 v)
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

/* The value that the file gives it. */
static void rest(const kd_model *m, kd_property property, uint32_t target, float out[4])
{
    bool of_light = property >= KD_PROPERTY_LIGHT_COLOR && property <= KD_PROPERTY_LIGHT_OUTER_CONE,
         of_camera = property >= KD_PROPERTY_CAMERA_FOV_Y;
    const kd_material_desc *material = of_light || of_camera ? NULL : &m->materials[target];
    const kd_model_light *light = of_light ? &m->lights[target] : NULL;
    switch (property) {
    case KD_PROPERTY_BASE_COLOR: memcpy(out, &material->base_color, 4 * sizeof *out); break;
    case KD_PROPERTY_METALLIC: out[0] = material->metallic; break;
    case KD_PROPERTY_ROUGHNESS: out[0] = material->roughness; break;
    case KD_PROPERTY_EMISSIVE: put3(out, material->emissive); break;
    case KD_PROPERTY_EMISSIVE_STRENGTH: out[0] = 1; break;
    case KD_PROPERTY_LIGHT_COLOR: put3(out, light->color); break;
    case KD_PROPERTY_LIGHT_INTENSITY: out[0] = light->intensity; break;
    case KD_PROPERTY_LIGHT_RANGE: out[0] = light->range; break;
    case KD_PROPERTY_LIGHT_INNER_CONE: out[0] = light->inner_cone; break;
    case KD_PROPERTY_LIGHT_OUTER_CONE: out[0] = light->outer_cone; break;
    case KD_PROPERTY_CAMERA_FOV_Y: out[0] = m->cameras[target].fov_y; break;
    case KD_PROPERTY_CAMERA_Y_MAG: out[0] = m->cameras[target].y_mag; break;
    }
}

/* ---- writing: what is outside of its range is brought back, as when it is loaded ---- */

static float within(float value, float low, float high)
{
    return value > low ? value < high ? value : high : low;
}

static kd_vec3 positive3(const float v[4])
{
    return (kd_vec3){within(v[0], 0, 1e9f), within(v[1], 0, 1e9f), within(v[2], 0, 1e9f)};
}

static void write_material(kd_material_desc *m, const kd_material_desc *resting, kd_property property,
                           bool with_factor, const float v[4])
{
    float share = within(v[0], 0, 1e9f);
    if (property == KD_PROPERTY_BASE_COLOR)
        m->base_color =
            (kd_vec4){within(v[0], 0, 1), within(v[1], 0, 1), within(v[2], 0, 1), within(v[3], 0, 1)};
    else if (property == KD_PROPERTY_METALLIC)
        m->metallic = within(v[0], 0, 1);
    else if (property == KD_PROPERTY_ROUGHNESS)
        m->roughness = within(v[0], 0, 1);
    else if (property == KD_PROPERTY_EMISSIVE)
        m->emissive = positive3(v);
    else
        m->emissive = kd_vec3_scale(with_factor ? m->emissive : resting->emissive, share);
}

static void write_light(kd_world *w, kd_entity e, kd_property property, const float v[4])
{
    static const float half_turn = 3.14159265f;
    const kd_light *old = kd_find(w, e, kd_light);
    if (!old)
        return;
    kd_light light = *old;
    if (property == KD_PROPERTY_LIGHT_COLOR)
        light.color = positive3(v);
    else if (property == KD_PROPERTY_LIGHT_INTENSITY)
        light.intensity = within(v[0], 0, 1e9f);
    else if (property == KD_PROPERTY_LIGHT_RANGE)
        light.range = within(v[0], 0, 1e9f);
    else if (property == KD_PROPERTY_LIGHT_INNER_CONE)
        light.inner_cone = within(v[0], 0, half_turn / 2);
    else
        light.outer_cone = within(v[0], 0, half_turn / 2);
    if (memcmp(&light, old, sizeof light) != 0) /* an equal value must not count as a change */
        *kd_find_mut(w, e, kd_light) = light;
}

static void write_camera(kd_world *w, kd_entity e, kd_property property, const float v[4])
{
    const kd_camera *old = kd_find(w, e, kd_camera);
    if (!old)
        return;
    kd_camera camera = *old;
    if (property == KD_PROPERTY_CAMERA_FOV_Y)
        camera.fov_y = within(v[0], 0.01f, 3.1f);
    else
        camera.y_mag = within(v[0], 1e-4f, 1e9f);
    if (memcmp(&camera, old, sizeof camera) != 0)
        *kd_find_mut(w, e, kd_camera) = camera;
}

static void write_value(kd_world *w, kd_scene_store *store, const kd_store_model *model,
                        const kd_entity *entities, const kd_property_channel *c, bool with_factor,
                        const float v[4])
{
    const kd_model *m = model->model;
    if (c->property < KD_PROPERTY_LIGHT_COLOR) {
        write_material(&store->materials[model->first_material + c->target].desc, &m->materials[c->target],
                       c->property, with_factor, v);
        return;
    }
    for (uint32_t i = 0; i < m->node_count; i++)
        if (c->property >= KD_PROPERTY_CAMERA_FOV_Y && m->nodes[i].camera == c->target)
            write_camera(w, entities[i], c->property, v);
        else if (c->property < KD_PROPERTY_CAMERA_FOV_Y && m->nodes[i].light == c->target)
            write_light(w, entities[i], c->property, v);
}

/* ---- moments ---- */

static void value_at(const kd_model *m, const kd_property_channel *like, const kd_property_channel *channel,
                     float time_s, float out[4])
{
    rest(m, like->property, like->target, out);
    if (channel)
        animation_sample(&channel->curve, time_s, out, 4);
}

static void write_one(kd_world *w, kd_scene_store *store, const kd_store_model *model,
                      const kd_entity *entities, const animation_moment *at, const kd_property_channel *c)
{
    float now[4] = {0}, before[4] = {0};
    bool blends = at->previous && at->previous_weight > 0;
    value_at(model->model, c, find(at->clip, c->property, c->target), at->time_s, now);
    if (blends)
        value_at(model->model, c, find(at->previous, c->property, c->target), at->previous_time_s, before);
    for (int i = 0; blends && i < 4; i++)
        now[i] += (before[i] - now[i]) * at->previous_weight;
    bool with_factor = find(at->clip, KD_PROPERTY_EMISSIVE, c->target) ||
                       find(at->previous, KD_PROPERTY_EMISSIVE, c->target);
    write_value(w, store, model, entities, c, with_factor, now);
}

/* Strengths come last: they take what factors have left. */
static void write_clip(kd_world *w, kd_scene_store *store, const kd_store_model *model,
                       const kd_entity *entities, const animation_moment *at, const kd_clip_desc *clip,
                       bool strengths)
{
    for (uint32_t i = 0; clip && i < clip->property_count; i++) {
        const kd_property_channel *c = &clip->properties[i];
        bool again = clip != at->clip && find(at->clip, c->property, c->target);
        if (!again && (c->property == KD_PROPERTY_EMISSIVE_STRENGTH) == strengths)
            write_one(w, store, model, entities, at, c);
    }
}

void animation_write_properties(kd_world *w, kd_scene_store *store, const kd_store_model *model,
                                const kd_entity *entities, const animation_moment *moment)
{
    for (int strengths = 0; strengths < 2; strengths++) {
        write_clip(w, store, model, entities, moment, moment->clip, strengths);
        write_clip(w, store, model, entities, moment, moment->previous, strengths);
    }
}
