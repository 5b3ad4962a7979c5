/* Light that is looked for: directional, point and spot lights one by one, triangles that shine by area. */

#include "components/light.h"

#include <math.h>

#include "components/transform.h"
#include "runtime/core/log.h"
#include "runtime/reference/internal.h"

static kd_status no_memory(void)
{
    return kd_fail(KD_NO_MEMORY, "reference: out of memory for the lights; use a smaller scene");
}

/* ---- lights without extent ---- */

static void add_lights(kd_query *query, reference_scene *s)
{
    for (kd_iter it = kd_query_iter(query); kd_iter_next(&it);) {
        const kd_light *lights = KD_COLUMN(&it, kd_light, 0);
        const kd_world_transform *worlds = KD_COLUMN(&it, kd_world_transform, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            s->light_shadow[s->light_count] = !lights[i].no_shadow;
            s->lights[s->light_count++] = kd_light_params_make(&lights[i], &worlds[i].matrix);
        }
    }
}

kd_status reference_lights_build(kd_world *w, reference_scene *s)
{
    kd_query *query =
        kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(kd_light), KD_READ(kd_world_transform)},
                                          .name = "reference lights"});
    if (!query)
        return no_memory();
    uint32_t count = kd_query_count(query);
    s->lights = KD_ARENA_NEW(&s->arena, struct kd_light_params, count + 1);
    s->light_shadow = KD_ARENA_NEW(&s->arena, bool, count + 1);
    bool ok = s->lights && s->light_shadow;
    if (ok)
        add_lights(query, s);
    kd_query_destroy(query);
    float lamp = kd_lamp_size(kd_vec3_length(kd_vec3_sub(s->bounds_max, s->bounds_min)));
    s->lamp_distance2 = fmaxf(lamp * lamp, 1e-20f);
    return ok ? KD_OK : no_memory();
}

static float range_window(float d2, float range)
{
    float r = d2 / (range * range);
    return range > 0 ? fminf(fmaxf(1 - r * r, 0), 1) : 1;
}

/* light_sample of shaders/include/lights.glsl. Source  KHR_lights_punctual */
static reference_light_sample light_at(const reference_scene *scene, uint32_t i, kd_vec3 p)
{
    const struct kd_light_params *light = &scene->lights[i];
    kd_vec3 axis = {light->direction_ws.x, light->direction_ws.y, light->direction_ws.z};
    kd_vec3 color = {light->color.x, light->color.y, light->color.z};
    if (light->direction_ws.w == (float)KD_DIRECTIONAL)
        return (reference_light_sample){kd_vec3_scale(axis, -1), color, INFINITY, scene->light_shadow[i]};
    kd_vec3 d = {light->position_ws.x - p.x, light->position_ws.y - p.y, light->position_ws.z - p.z};
    float d2 = fmaxf(kd_vec3_dot(d, d), scene->lamp_distance2);
    kd_vec3 to_light = kd_vec3_scale(d, 1 / sqrtf(d2));
    float e = range_window(d2, light->position_ws.w) / d2;
    if (light->direction_ws.w == (float)KD_SPOT) {
        float cone = fminf(fmaxf(-kd_vec3_dot(axis, to_light) * light->color.w + light->shadow.w, 0), 1);
        e *= cone * cone;
    }
    return (reference_light_sample){to_light, kd_vec3_scale(color, e), sqrtf(kd_vec3_dot(d, d)),
                                    scene->light_shadow[i]};
}

/* A reservoir of one: each light replaces the one kept with the probability of its share so far; u is
 * stretched after each choice and serves them all. A single light is always taken, and so has no noise. */
reference_light_sample reference_light_choose(const reference_scene *scene, const reference_surface *s,
                                              float u)
{
    reference_light_sample kept = {.irradiance = {0, 0, 0}};
    float sum = 0, kept_weight = 0;
    for (uint32_t i = 0; i < scene->light_count; i++) {
        reference_light_sample l = light_at(scene, i, s->position);
        float cosine = kd_vec3_dot(s->normal, l.to_light);
        float weight = cosine > 0 && kd_vec3_dot(s->face, l.to_light) > 0
                           ? reference_luminance(l.irradiance) * cosine
                           : 0;
        if (!(weight > 0))
            continue;
        sum += weight;
        float share = weight / sum;
        if (u < share) {
            kept = l;
            kept_weight = weight;
            u = u / share;
        } else {
            u = (u - share) / (1 - share);
        }
    }
    if (kept_weight > 0)
        kept.irradiance = kd_vec3_scale(kept.irradiance, sum / kept_weight);
    return kept;
}

/* ---- emitters ---- */

static float area_of(const reference_object *o, uint32_t triangle)
{
    kd_vec3 p[3];
    reference_triangle(o, triangle, p);
    kd_vec3 c = kd_vec3_cross(kd_vec3_sub(p[1], p[0]), kd_vec3_sub(p[2], p[0]));
    float area = 0.5f * kd_vec3_length(c);
    return area < INFINITY ? area : 0; /* and NaN */
}

/* Mean brightness by points spread over the triangle. A part that they miss is found by reflected rays alone.
 */
static float brightness(const reference_scene *scene, const reference_object *o, uint32_t triangle)
{
    const reference_material *m = &scene->materials[o->material];
    if (!m->maps[3].image) {
        reference_attributes a = {.color = {1, 1, 1, 1}};
        return reference_luminance(reference_emission(m, &a));
    }
    float sum = 0;
    const int edge = 8;
    for (int i = 0; i < edge; i++)
        for (int j = 0; j < edge - i; j++) {
            float u = ((float)i + 1.0f / 3) / (float)edge, v = ((float)j + 1.0f / 3) / (float)edge;
            reference_attributes a = reference_attributes_at(&o->mesh, triangle, u, v);
            sum += reference_luminance(reference_emission(m, &a));
        }
    return sum / (float)(edge * (edge + 1) / 2);
}

static uint32_t count_emitters(const reference_scene *s)
{
    uint64_t count = 0;
    for (uint32_t i = 0; i < s->object_count; i++)
        count += s->materials[s->objects[i].material].emits ? s->objects[i].mesh.triangle_count : 0;
    return count < UINT32_MAX / 2 ? (uint32_t)count : UINT32_MAX / 2;
}

/* Weights are area times brightness, in double: a sum of a million small ones keeps them. */
static void weigh_emitters(reference_scene *s)
{
    double total = 0, sum = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->object_count; i++) {
        reference_object *o = &s->objects[i];
        if (!s->materials[o->material].emits || count + (uint64_t)o->mesh.triangle_count > s->emitter_count)
            continue;
        o->first_emitter = count;
        for (uint32_t t = 0; t < o->mesh.triangle_count; t++, count++) {
            s->emitters[count] = (reference_emitter){i, t, brightness(s, o, t)};
            total += (double)s->emitters[count].density * (double)area_of(o, t);
        }
    }
    s->emitter_count = total > 0 ? count : 0;
    for (uint32_t i = 0; i < count; i++) {
        reference_emitter *e = &s->emitters[i];
        sum +=
            total > 0 ? (double)e->density * (double)area_of(&s->objects[e->object], e->triangle) / total : 0;
        s->emitter_cdf[i] = (float)sum;
        e->density = total > 0 ? (float)((double)e->density / total) : 0;
    }
}

kd_status reference_emitters_build(reference_scene *s)
{
    s->emitter_count = count_emitters(s);
    s->emitters = KD_ARENA_NEW(&s->arena, reference_emitter, s->emitter_count + 1);
    s->emitter_cdf = KD_ARENA_NEW(&s->arena, float, s->emitter_count + 1);
    if (!s->emitters || !s->emitter_cdf)
        return no_memory();
    weigh_emitters(s);
    return KD_OK;
}

static uint32_t find_emitter(const reference_scene *s, float u)
{
    uint32_t low = 0, high = s->emitter_count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (s->emitter_cdf[middle] > u)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

reference_emitter_sample reference_emitter_choose(const reference_scene *scene, kd_vec3 from,
                                                  const float u[3])
{
    reference_emitter_sample out = {.pdf = 0};
    if (!scene->emitter_count)
        return out;
    const reference_emitter *e = &scene->emitters[find_emitter(scene, u[0])];
    float root = sqrtf(u[1]), b0 = 1 - root, b1 = root * (1 - u[2]);
    reference_hit hit = {e->object, e->triangle, b1, root - b1, 0, b1, root - b1};
    kd_vec3 p[3];
    reference_triangle(&scene->objects[e->object], e->triangle, p);
    kd_vec3 point = reference_mad(p[0], b0, reference_mad(p[1], b1, kd_vec3_scale(p[2], root - b1)));
    kd_vec3 d = kd_vec3_sub(point, from);
    float d2 = kd_vec3_dot(d, d);
    if (!(d2 > 0) || !(e->density > 0))
        return out;
    reference_surface at;
    out.distance = sqrtf(d2);
    out.to_light = kd_vec3_scale(d, 1 / out.distance);
    reference_surface_make(scene, &hit, out.to_light, &at);
    float cosine = -kd_vec3_dot(at.face, out.to_light);
    if (cosine <= 1e-6f || reference_is_black(at.emission))
        return out;
    out.position = at.position;
    out.radiance = kd_vec3_scale(at.emission, at.opacity);
    out.normal = at.face;
    out.error = at.error;
    out.pdf = e->density * d2 / cosine;
    return out;
}

float reference_emitter_pdf(const reference_scene *scene, const reference_hit *hit,
                            const reference_surface *at, kd_vec3 direction)
{
    const reference_object *o = &scene->objects[hit->object];
    float cosine = -kd_vec3_dot(at->face, direction);
    if (o->first_emitter == KD_NONE || !scene->emitter_count || cosine <= 1e-6f)
        return 0;
    return scene->emitters[o->first_emitter + hit->triangle].density * hit->t * hit->t / cosine;
}
