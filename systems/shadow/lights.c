/* The CPU side of light: gathers lights and camera into the blocks that shaders read, gives every shadow
 * caster its layers, and culls for each. Directional lights come first in the block, then points and spots,
 * each in query order. */

#include "systems/shadow/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/log.h"

enum { LARGE_SPOTS = 4 };

/* Nothing nearer casts a shadow: of what its light reaches, but no more than what the camera cuts off, so
 * that one thing far away takes no shadows from a room. Floats tell 2 cm from each other at 100 m then. */
static const float SPOT_NEAR = 1.0f / 2048, SPOT_LEAST_NEAR = 1e-5f; /* depths tell no more apart */
static const float SPOT_MAX_TANGENT = 8; /* 83 degrees: wider cones keep an unshadowed rim */

static struct kd_gl_vec4 row(kd_vec3 v, float w)
{
    return (struct kd_gl_vec4){v.x, v.y, v.z, w};
}

static struct kd_gl_mat4 gl_mat4(const kd_mat4 *m)
{
    struct kd_gl_mat4 out;
    memcpy(out.m, m->m, sizeof out.m);
    return out;
}

static void warn_once(bool *warned, const char *text, unsigned limit)
{
    if (!*warned)
        kd_log(KD_LOG_WARNING, text, limit);
    *warned = true;
}

/* Where the near plane can stand without cutting anything drawn: a camera's own may be a few centimetres off
 * a scene a kilometre away, whose depths would then be metres apart. A power of two: it stands still while
 * the camera moves. */
static float useful_near(const kd_view *view, const shadow_bounds *b)
{
    kd_vec3 f = view->forward_ws, half = kd_vec3_scale(kd_vec3_sub(b->high, b->low), 0.5f);
    kd_vec3 to_middle = kd_vec3_sub(kd_vec3_add(b->low, half), view->position_ws);
    float reach = fabsf(f.x) * half.x + fabsf(f.y) * half.y + fabsf(f.z) * half.z;
    float nearest = kd_vec3_dot(to_middle, f) - reach * 1.01f;
    if (b->empty || !(nearest > view->z_near) || nearest >= view->z_far)
        return view->z_near;
    return fmaxf(exp2f(floorf(log2f(nearest * 0.99f))), view->z_near);
}

/* What shaders see of the camera; the near plane of a perspective moves up to what is drawn. */
static kd_view refine_view(const kd_view *given, const shadow_bounds *bounds)
{
    kd_view view = *given;
    bool perspective = view.projection.m[11] < 0;
    float n = perspective ? useful_near(&view, bounds) : view.z_near, f = view.z_far;
    if (!(n > view.z_near))
        return view;
    view.z_near = n;
    view.projection.m[10] = (f + n) / (n - f);
    view.projection.m[14] = 2 * f * n / (n - f);
    view.view_projection = kd_mat4_mul(&view.projection, &view.view);
    view.inverse_view_projection = kd_mat4_inverse(&view.view_projection);
    return view;
}

static void fill_view(shadow_state *s, const kd_view *given, const kd_frame *frame,
                      const shadow_bounds *bounds)
{
    kd_view refined = refine_view(given, bounds);
    const kd_view *view = &refined;
    float aspect = view->height > 0 ? (float)view->width / (float)view->height : 1;
    s->view = (struct kd_view_params){
        .view = gl_mat4(&view->view),
        .projection = gl_mat4(&view->projection),
        .view_projection = gl_mat4(&view->view_projection),
        .inverse_view_projection = gl_mat4(&view->inverse_view_projection),
        .position_ws = row(view->position_ws, view->z_near),
        .forward_ws = row(view->forward_ws, view->z_far),
        .size = {frame->width, frame->height, (uint32_t)frame->index, 0},
        .lens = {view->tan_half_fov_y, aspect, exp2f(frame->settings.view_exposure_ev), 0},
    };
}

static void add_layer(shadow_state *s, const kd_mat4 *matrix, uint32_t index, bool directional,
                      uint32_t layer)
{
    s->layers[s->layer_count++] =
        (shadow_layer){.matrix = *matrix, .directional = directional, .layer = layer};
    s->lights.shadow_matrix[index] = gl_mat4(matrix);
}

static void add_directional_shadow(shadow_state *s, struct kd_light_params *p, const kd_view *view,
                                   const kd_frame *frame, const shadow_bounds *bounds)
{
    uint32_t count = (uint32_t)frame->settings.light_shadow_cascades;
    if (s->directional_layers / count == SHADOW_MAX_DIRECTIONAL) {
        warn_once(&s->warned_directional,
                  "lights: only %u directional lights cast shadows; set no_shadow on the others",
                  SHADOW_MAX_DIRECTIONAL);
        return;
    }
    shadow_cascade cascades[KD_MAX_SHADOW_CASCADES];
    kd_vec3 direction = {p->direction_ws.x, p->direction_ws.y, p->direction_ws.z};
    shadow_cascades_make(cascades, count, direction, view->position_ws, bounds,
                         frame->settings.light_shadow_distance, s->directional_edge);
    p->shadow =
        (struct kd_gl_vec4){(float)s->directional_layers, (float)count, (float)s->directional_layers, 0};
    for (uint32_t i = 0; i < count; i++, s->directional_layers++) {
        s->lights.cascade_texel_ws[s->directional_layers] =
            (struct kd_gl_vec4){cascades[i].texel_ws, cascades[i].half_depth, 0, 0};
        add_layer(s, &cascades[i].matrix, s->directional_layers, true, s->directional_layers);
    }
}

/* A spot's cone, or the six faces of a point light's cube, a little wider than asked for: the filter's
 * margin. */
static void add_local_shadow(shadow_state *s, struct kd_light_params *p, const kd_light *light,
                             const kd_view *view, const shadow_bounds *bounds)
{
    uint32_t count = light->type == KD_POINT ? 6 : 1;
    if (s->spot_layers + count > KD_MAX_SPOT_SHADOWS) {
        warn_once(&s->warned_layers,
                  "lights: only %u shadow maps for spot (1 each) and point lights (6 each); "
                  "set no_shadow on some",
                  KD_MAX_SPOT_SHADOWS);
        return;
    }
    kd_vec3 position = {p->position_ws.x, p->position_ws.y, p->position_ws.z};
    kd_vec3 forward = {p->direction_ws.x, p->direction_ws.y, p->direction_ws.z};
    float farthest = shadow_farthest(bounds, position) * 1.01f;
    float z_far = light->range > 0 ? fminf(light->range, farthest) : farthest;
    float z_near = view->z_near > 0 ? fminf(z_far * SPOT_NEAR, view->z_near) : z_far * SPOT_NEAR;
    z_near = fmaxf(z_near, z_far * SPOT_LEAST_NEAR);
    float tangent = light->type == KD_POINT    ? 1
                    : light->outer_cone < 1.5f ? tanf(light->outer_cone)
                                               : SPOT_MAX_TANGENT;
    tangent = fminf(fmaxf(tangent, 1e-3f), SPOT_MAX_TANGENT) * (1 + 6 / (float)s->spot_edge);
    uint32_t index = SHADOW_DIRECTIONAL_MATRICES + s->spot_layers;
    p->shadow = (struct kd_gl_vec4){(float)index, (float)count, (float)s->spot_layers, p->shadow.w};
    for (uint32_t i = 0; i < count; i++, s->spot_layers++) {
        kd_vec3 axis = light->type == KD_POINT ? shadow_cube_axis(i) : forward;
        kd_mat4 matrix = shadow_spot_matrix(position, axis, tangent, z_near, z_far);
        add_layer(s, &matrix, index + i, false, s->spot_layers);
    }
}

static void add_light(shadow_state *s, const kd_light *light, const kd_mat4 *world, const kd_view *view,
                      const kd_frame *frame, const shadow_bounds *bounds)
{
    if (s->lights.count.x == KD_MAX_LIGHTS) {
        warn_once(&s->warned_lights, "lights: only the first %u lights shine; remove some", KD_MAX_LIGHTS);
        return;
    }
    struct kd_light_params *p = &s->lights.light[s->lights.count.x++];
    *p = kd_light_params_make(light, world);
    if (light->no_shadow || bounds->empty)
        return;
    if (light->type == KD_DIRECTIONAL)
        add_directional_shadow(s, p, view, frame, bounds);
    else
        add_local_shadow(s, p, light, view, bounds);
}

static void add_lights(shadow_state *s, bool directional, const kd_view *view, const kd_frame *frame,
                       const shadow_bounds *bounds)
{
    for (kd_iter it = kd_query_iter(s->query); kd_iter_next(&it);) {
        const kd_light *lights = KD_COLUMN(&it, kd_light, 0);
        const kd_world_transform *worlds = KD_COLUMN(&it, kd_world_transform, 1);
        for (uint32_t i = 0; i < it.count; i++)
            if ((lights[i].type == KD_DIRECTIONAL) == directional)
                add_light(s, &lights[i], &worlds[i].matrix, view, frame, bounds);
    }
}

/* The sun of a sky's picture comes first: it cannot be told to cast no shadow, and without one it would shine
 * through walls. */
static void add_sky_sun(shadow_state *s, kd_world *w, const kd_view *view, const kd_frame *frame,
                        const shadow_bounds *bounds)
{
    kd_light light;
    kd_mat4 world;
    if (kd_sky_sun_light(w, s->skies, &light, &world))
        add_light(s, &light, &world, view, frame, bounds);
}

static uint32_t count_ranged(const shadow_state *s, uint32_t first)
{
    uint32_t count = 0;
    for (uint32_t i = first; i < s->lights.count.x; i++)
        count += s->lights.light[i].position_ws.w > 0;
    return count;
}

/* Layers that local lights ask for, granted or not. */
static uint32_t count_local_layers(const shadow_state *s)
{
    uint32_t count = 0;
    for (kd_iter it = kd_query_iter(s->query); kd_iter_next(&it);) {
        const kd_light *lights = KD_COLUMN(&it, kd_light, 0);
        for (uint32_t i = 0; i < it.count; i++)
            if (!lights[i].no_shadow && lights[i].type != KD_DIRECTIONAL)
                count += lights[i].type == KD_POINT ? 6 : 1;
    }
    return count;
}

/* A few spots get maps of half the edge; a cube or many spots share what that would cost. */
static void begin_lights(shadow_state *s, const kd_frame *frame)
{
    const kd_settings *settings = &frame->settings;
    uint32_t edge = (uint32_t)settings->light_shadow_size;
    s->layer_count = s->directional_layers = s->spot_layers = 0;
    s->directional_edge = edge;
    s->spot_edge = count_local_layers(s) <= LARGE_SPOTS ? edge / 2 : edge / 4;
    s->lights.count =
        (struct kd_gl_uvec4){0, (uint32_t)settings->light_shadow_cascades, s->directional_edge, s->spot_edge};
}

void shadow_lights_run(kd_system_context *context)
{
    kd_world *w = context->world;
    kd_lighting *lighting = kd_singleton(w, kd_lighting);
    const kd_draw_list *list = kd_singleton(w, kd_draw_list);
    const kd_frame *frame = kd_singleton(w, kd_frame);
    const kd_view *view = kd_singleton(w, kd_view);
    shadow_state *s = lighting->internal;
    shadow_bounds bounds = {list->bounds_min_ws, list->bounds_max_ws, list->draw_count == 0};
    begin_lights(s, frame);
    fill_view(s, view, frame, &bounds);
    add_sky_sun(s, w, view, frame, &bounds);
    add_lights(s, true, view, frame, &bounds);
    lighting->directional_count = s->lights.count.x;
    float lamp = kd_lamp_size(kd_vec3_length(kd_vec3_sub(bounds.high, bounds.low)));
    s->lights.kinds = (struct kd_gl_vec4){(float)s->lights.count.x, fmaxf(lamp * lamp, 1e-20f), 0, 0};
    add_lights(s, false, view, frame, &bounds);
    lighting->light_count = s->lights.count.x;
    lighting->ranged_count = count_ranged(s, lighting->directional_count);
    if (shadow_cull(s, w, list, kd_singleton(w, kd_scene_store)) == KD_OK)
        return;
    kd_fail(KD_NO_MEMORY, "lights: no memory for the shadows of %u draws; use fewer lights",
            list->draw_count);
    for (uint32_t i = 0; i < lighting->light_count; i++)
        s->lights.light[i].shadow.x = -1;
}

kd_status shadow_lights_init(kd_system_context *context)
{
    shadow_state *s = calloc(1, sizeof *s);
    if (s == NULL)
        return kd_fail(KD_NO_MEMORY, "lights: no memory for their state; free some");
    s->query = kd_query_make(
        context->world,
        &(kd_query_desc){.terms = {KD_READ(kd_light), KD_READ(kd_world_transform)}, .name = "lights"});
    s->skies = kd_query_make(
        context->world,
        &(kd_query_desc){.terms = {KD_READ(kd_sky), KD_READ(kd_world_transform)}, .name = "lights.skies"});
    if (s->query == NULL || s->skies == NULL) {
        kd_query_destroy(s->query);
        kd_query_destroy(s->skies);
        free(s);
        return kd_fail(KD_NO_MEMORY, "lights: no memory for their queries; free some");
    }
    kd_singleton(context->world, kd_lighting)->internal = s;
    return KD_OK;
}

void shadow_lights_fini(kd_system_context *context)
{
    kd_lighting *lighting = kd_singleton(context->world, kd_lighting);
    shadow_state *s = lighting->internal;
    if (s == NULL)
        return;
    kd_query_destroy(s->query);
    kd_query_destroy(s->skies);
    free(s->args.items);
    free(s->runs.items);
    free(s->casters.items);
    free(s->draws.items);
    free(s->visible.items);
    free(s->poses);
    for (uint32_t i = 0; i < SHADOW_MAX_LAYERS; i++)
        free(s->kept[i].casters.items);
    free(s);
    lighting->internal = NULL;
}
