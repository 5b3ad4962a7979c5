/* One sample of one pixel: a path from the camera that looks for light at each of its corners.
 *
 * Lights without extent are asked by shadow rays. Triangles that shine are found by points on them and by the
 * path itself, which share the work by the power heuristic; so is the picture of a sky, by its bright parts.
 * Source  Veach 1997, Robust Monte Carlo Methods, 9.2 (multiple importance sampling), 10.4 (Russian roulette)
 */

#include <math.h>

#include "runtime/reference/internal.h"

enum { ROULETTE_FROM = 3, DEEPEST = 4096 }; /* corners every path may have, and that none exceeds */

typedef struct walk {
    const reference_scene *scene;
    const reference_options *options;
    sampler sampler;
    reference_sample *out;
    kd_vec3 diffuse,
        specular; /* what the first surface's two ways of reflecting pass on of light found now */
    uint32_t random;
    int32_t depth; /* corners behind us */
} walk;

/* ---- camera ---- */

static reference_ray camera_ray(const kd_view *view, float x, float y)
{
    const float *m = view->view.m, *p = view->projection.m;
    kd_vec3 right = {m[0], m[4], m[8]}, up = {m[1], m[5], m[9]};
    float sx = (2 * x / (float)view->width - 1) / p[0], sy = (1 - 2 * y / (float)view->height) / p[5];
    kd_vec3 aside = reference_mad(right, sx, kd_vec3_scale(up, sy));
    if (p[11] == 0) /* orthographic */
        return (reference_ray){kd_vec3_add(view->position_ws, aside), view->forward_ws, view->z_near,
                               view->z_far};
    kd_vec3 d = kd_vec3_add(view->forward_ws, aside);
    float length = kd_vec3_length(d);
    return (reference_ray){view->position_ws, kd_vec3_scale(d, 1 / length), view->z_near * length,
                           view->z_far * length};
}

/* ---- what light adds to ---- */

static void add_found(walk *w, kd_vec3 light)
{
    w->out->diffuse = kd_vec3_add(w->out->diffuse, reference_mul(w->diffuse, light));
    w->out->specular = kd_vec3_add(w->out->specular, reference_mul(w->specular, light));
}

/* Light that arrives at this corner and is reflected by f. */
static void add_reflected(walk *w, const reference_bsdf *f, kd_vec3 light)
{
    if (w->depth > 0) {
        add_found(w, reference_mul(kd_vec3_add(f->diffuse, f->specular), light));
        return;
    }
    w->out->diffuse = kd_vec3_add(w->out->diffuse, reference_mul(f->diffuse, light));
    w->out->specular = kd_vec3_add(w->out->specular, reference_mul(f->specular, light));
}

/* ---- light that is looked for ---- */

static void gather_light(walk *w, const reference_surface *s, kd_vec3 v, float u)
{
    if (!w->scene->light_count)
        return;
    reference_light_sample l = reference_light_choose(w->scene, s, u);
    reference_bsdf f;
    reference_bsdf_evaluate(s, v, l.to_light, &f);
    kd_vec3 both = kd_vec3_add(f.diffuse, f.specular);
    if (reference_is_black(l.irradiance) || reference_is_black(both))
        return;
    if (l.shadow) {
        /* A source inside a bulb's surface shines: what is as near to it as the lamp's size casts no shadow.
         */
        float end = l.distance < INFINITY ? l.distance - sqrtf(w->scene->lamp_distance2) : INFINITY;
        reference_ray ray = {reference_leave(s, l.to_light), l.to_light, 0, end};
        w->out->rays++;
        if (end > 0)
            l.irradiance = reference_mul(l.irradiance, reference_transmittance(w->scene, &ray, true));
    }
    if (w->depth == 0)
        w->out->direct = kd_vec3_add(w->out->direct, reference_mul(both, l.irradiance));
    else
        add_found(w, reference_mul(both, l.irradiance));
}

/* The weight of one of two ways to find the same light; their densities may be too large to be squared. */
static float power_heuristic(float pdf, float other)
{
    float r = other / pdf;
    return pdf > 0 ? 1 / (1 + r * r) : 0;
}

static void gather_emitter(walk *w, const reference_surface *s, kd_vec3 v, const float u[3])
{
    reference_emitter_sample e = reference_emitter_choose(w->scene, s->position, u);
    reference_bsdf f;
    if (!(e.pdf > 0))
        return;
    reference_bsdf_evaluate(s, v, e.to_light, &f);
    if (reference_is_black(f.diffuse) && reference_is_black(f.specular))
        return;
    kd_vec3 from = reference_leave(s, e.to_light), to = reference_mad(e.normal, e.error, e.position);
    reference_ray ray = {from, kd_vec3_sub(to, from), 0, 1};
    w->out->rays++;
    kd_vec3 light = reference_mul(e.radiance, reference_transmittance(w->scene, &ray, false));
    add_reflected(w, &f, kd_vec3_scale(light, power_heuristic(e.pdf, f.pdf) / e.pdf));
}

static void gather_sky(walk *w, const reference_surface *s, kd_vec3 v)
{
    float u[4];
    kd_vec3 to_light;
    reference_bsdf f;
    sampler_next(&w->sampler, u);
    float pdf = reference_sky_choose(w->scene, u[0], u[1], &to_light);
    if (!(pdf > 0))
        return;
    reference_bsdf_evaluate(s, v, to_light, &f);
    if (reference_is_black(f.diffuse) && reference_is_black(f.specular))
        return;
    reference_ray ray = {reference_leave(s, to_light), to_light, 0, INFINITY};
    w->out->rays++;
    kd_vec3 light = reference_mul(reference_sky_picture(w->scene, to_light),
                                  reference_transmittance(w->scene, &ray, false));
    add_reflected(w, &f, kd_vec3_scale(light, power_heuristic(pdf, f.pdf) / pdf));
}

/* ---- one corner to the next ---- */

/* Choose where the path goes on. Returns false when it ends. */
static bool scatter(walk *w, const reference_surface *s, kd_vec3 v, const float u[3], kd_vec3 *l, float *pdf)
{
    reference_bsdf f;
    if (!reference_bsdf_sample(s, v, u, l))
        return false;
    reference_bsdf_evaluate(s, v, *l, &f);
    if (!(f.pdf > 0))
        return false;
    *pdf = f.pdf;
    kd_vec3 diffuse = kd_vec3_scale(f.diffuse, 1 / f.pdf), specular = kd_vec3_scale(f.specular, 1 / f.pdf);
    if (w->depth == 0) {
        w->diffuse = diffuse;
        w->specular = specular;
    } else {
        kd_vec3 both = kd_vec3_add(diffuse, specular);
        w->diffuse = reference_mul(w->diffuse, both);
        w->specular = reference_mul(w->specular, both);
    }
    return reference_largest(kd_vec3_add(w->diffuse, w->specular)) > 0;
}

static bool survives(walk *w, float u)
{
    if (w->depth < ROULETTE_FROM)
        return true;
    float chance = fminf(reference_largest(kd_vec3_add(w->diffuse, w->specular)), 0.95f);
    if (u >= chance || w->depth >= DEEPEST)
        return false;
    w->diffuse = kd_vec3_scale(w->diffuse, 1 / chance);
    w->specular = kd_vec3_scale(w->specular, 1 / chance);
    return true;
}

/* Tell whether light that is found from here has bounced no more often than it may. */
static bool within(const walk *w, int32_t bounces)
{
    return w->options->bounces < 0 || w->depth <= bounces;
}

/* The uniform sky is found by the path alone, its picture by choice as well. */
static void find_sky(walk *w, kd_vec3 l, float pdf)
{
    float weight = power_heuristic(pdf, reference_sky_pdf(w->scene, l));
    add_found(w, kd_vec3_add(w->scene->ambient, kd_vec3_scale(reference_sky_picture(w->scene, l), weight)));
}

/* The nearest surface that does not let the ray pass straight through. What a surface with transmission lets
 * through is chosen by chance, as blended surfaces are; `weight` makes up for the tint and the choice. The
 * ray moves on to the last surface. Returns whether there is one. */
static bool meet(walk *w, reference_ray *ray, bool seen, uint32_t random, kd_vec3 *weight, reference_hit *hit,
                 reference_surface *s)
{
    float behind = 0; /* metres of what the ray has passed */
    for (uint32_t passed = 0; passed < DEEPEST; passed++) {
        w->out->rays++;
        if (!reference_intersect(w->scene, ray, seen, sampler_hash(random, passed), hit))
            return false;
        reference_surface_make(w->scene, hit, ray->direction, s);
        float t = hit->t;
        hit->t += behind;
        if (s->transmission <= 0)
            return true;
        kd_vec3 tint = reference_bsdf_tint(s, -kd_vec3_dot(s->normal, ray->direction));
        float chance = reference_largest(tint),
              draw = (float)(sampler_hash(~random, passed) >> 8) / 16777216.0f;
        if (draw >= chance) {
            *weight = kd_vec3_scale(*weight, 1 / (1 - chance));
            return true;
        }
        *weight = kd_vec3_scale(reference_mul(*weight, tint), 1 / chance);
        behind += t;
        ray->t_max -= t;
        ray->t_min = 0;
        ray->origin = reference_leave(s, ray->direction);
    }
    return false;
}

/* What the way out of a corner meets: the sky, or a surface that may shine. Returns whether there is one. */
static bool arrive(walk *w, reference_surface *s, kd_vec3 l, float pdf)
{
    bool area = within(w, w->options->area_bounces);
    reference_ray ray = {reference_leave(s, l), l, 0, INFINITY};
    reference_hit hit;
    kd_vec3 weight = {1, 1, 1};
    bool met = meet(w, &ray, false, sampler_hash(w->random, (uint32_t)w->depth), &weight, &hit, s);
    w->diffuse = reference_mul(w->diffuse, weight);
    w->specular = reference_mul(w->specular, weight);
    if (!met) {
        if (area)
            find_sky(w, l, pdf);
        return false;
    }
    if (area && !reference_is_black(s->emission))
        add_found(
            w, kd_vec3_scale(s->emission, power_heuristic(pdf, reference_emitter_pdf(w->scene, &hit, s, l))));
    return true;
}

static void gather_area(walk *w, const reference_surface *s, kd_vec3 v, const float u[3])
{
    gather_emitter(w, s, v, u);
    if (w->scene->sky.map.width > 0)
        gather_sky(w, s, v);
}

/* Walk from a surface until the light's last bounce. */
static void follow(walk *w, reference_surface *s, kd_vec3 v)
{
    for (w->depth = 0; within(w, w->options->bounces); w->depth++) {
        float u[4], way[4], pdf;
        kd_vec3 l;
        sampler_next(&w->sampler, u);
        sampler_next(&w->sampler, way);
        gather_light(w, s, v, u[3]);
        if (within(w, w->options->area_bounces))
            gather_area(w, s, v, u);
        else if (w->depth == w->options->bounces)
            return;
        if (!scatter(w, s, v, way, &l, &pdf) || !arrive(w, s, l, pdf) || !survives(w, way[3]))
            return;
        v = kd_vec3_scale(l, -1);
    }
}

/* Share of the cosine-weighted hemisphere that is open, occlusion fading as the renderer's cones fade it. */
static float openness(walk *w, const reference_surface *s)
{
    const reference_options *o = w->options;
    float u[4];
    reference_hit hit;
    sampler_next(&w->sampler, u);
    kd_vec3 d = reference_from_frame(s->normal, reference_cosine(u[0], u[1]));
    reference_ray ray = {reference_leave(s, s->face), d, 0, o->ao_distance};
    w->out->rays++;
    bool closed = kd_vec3_dot(d, s->face) <= 0;
    if (!closed && !reference_intersect(w->scene, &ray, false, w->random, &hit))
        return 1;
    return 1 - 1 / (1 + o->ao_falloff * (closed ? 0 : hit.t));
}

void reference_path(const reference_scene *scene, const reference_options *options,
                    const sampler_tables *tables, uint32_t x, uint32_t y, uint32_t index,
                    reference_sample *out)
{
    walk w = {.scene = scene,
              .options = options,
              .sampler = sampler_make(tables, x, y, index, options->seed),
              .out = out};
    float u[4];
    reference_hit hit;
    reference_surface s;
    kd_vec3 weight = {1, 1, 1};
    *out = (reference_sample){.ao = 1};
    sampler_next(&w.sampler, u);
    w.random = sampler_number(&w.sampler);
    reference_ray ray = camera_ray(&scene->view, (float)x + (options->centre ? 0.5f : u[0]),
                                   (float)y + (options->centre ? 0.5f : u[1]));
    if (!meet(&w, &ray, true, w.random ^ 0x5bd1e995u, &weight, &hit, &s)) {
        out->direct = reference_mul(weight, reference_sky_radiance(scene, ray.direction));
        out->ao = 0; /* as the renderer shows what is not there */
        return;
    }
    if (options->centre) {
        reference_ray beside = camera_ray(&scene->view, (float)x + u[0], (float)y + u[1]);
        reference_hit_spread(scene, &beside, &hit);
        reference_surface_make(scene, &hit, ray.direction, &s);
    }
    out->albedo = s.unlit ? s.shown : s.albedo;
    out->normal = reference_mad(s.normal, 0.5f, (kd_vec3){0.5f, 0.5f, 0.5f});
    out->depth = hit.t * kd_vec3_dot(ray.direction, scene->view.forward_ws);
    out->direct = s.unlit ? s.shown : s.emission;
    if (options->ambient_occlusion)
        out->ao = openness(&w, &s);
    if (!s.unlit)
        follow(&w, &s, kd_vec3_scale(ray.direction, -1));
    out->direct = reference_mul(out->direct, weight);
    out->diffuse = reference_mul(out->diffuse, weight);
    out->specular = reference_mul(out->specular, weight);
}
