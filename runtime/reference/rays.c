/* Rays against the scene. Filters decide what a ray passes through: masked holes, blended surfaces by chance
 * or by their share, backs of one-sided surfaces for the camera, objects that cast no shadow for lights. */

#include <math.h>

#include "runtime/reference/internal.h"

/* Embree hands it back to the filters. */
typedef struct ray_context {
    struct RTCIntersectContext base;
    const reference_scene *scene;
    uint32_t random;
    kd_vec3 transmittance;
    bool shadow;
} ray_context;

static ray_context context_make(const reference_scene *scene)
{
    ray_context c = {.scene = scene, .transmittance = {1, 1, 1}};
    rtcInitIntersectContext(&c.base);
    return c;
}

static uint32_t object_of(const struct RTCFilterFunctionNArguments *args)
{
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    return hit->instID[0] != RTC_INVALID_GEOMETRY_ID ? hit->instID[0] : hit->geomID;
}

static float opacity_at(const reference_scene *scene, uint32_t object, const struct RTCHit *hit)
{
    const reference_object *o = &scene->objects[object];
    const reference_material *m = &scene->materials[o->material];
    if (m->alpha_mode == KD_ALPHA_OPAQUE)
        return 1;
    reference_attributes a = reference_attributes_at(&o->mesh, hit->primID, hit->u, hit->v);
    return reference_opacity(m, reference_base_color(m, &a).w);
}

/* A blended surface stops the share `opacity` of rays. The choice hangs on the ray and the triangle alone,
 * since triangles are asked in any order. */
static void stop_by_opacity(const struct RTCFilterFunctionNArguments *args)
{
    const ray_context *c = (const ray_context *)(const void *)args->context;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    uint32_t object = object_of(args);
    float opacity = opacity_at(c->scene, object, hit);
    uint32_t random = sampler_hash(c->random, sampler_hash(object, hit->primID));
    if ((float)(random >> 8) * (1.0f / 16777216.0f) >= opacity)
        args->valid[0] = 0;
}

/* What a surface lets through: all of what its opacity does not stop, and the tint of what it does. */
static kd_vec3 passing(const reference_scene *scene, uint32_t object,
                       const struct RTCFilterFunctionNArguments *args)
{
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    const struct RTCRay *ray = (const struct RTCRay *)args->ray;
    const reference_object *o = &scene->objects[object];
    const reference_material *m = &scene->materials[o->material];
    if (m->params.lobes.z <= 0) {
        float open = 1 - opacity_at(scene, object, hit);
        return (kd_vec3){open, open, open};
    }
    reference_attributes a = reference_attributes_at(&o->mesh, hit->primID, hit->u, hit->v);
    reference_surface s;
    reference_material_at(m, &a, &s);
    kd_vec3 n = {hit->Ng_x, hit->Ng_y, hit->Ng_z}, d = {ray->dir_x, ray->dir_y, ray->dir_z};
    float cosine = fabsf(kd_vec3_dot(n, d)) / fmaxf(kd_vec3_length(n) * kd_vec3_length(d), 1e-30f);
    kd_vec3 tint = kd_vec3_scale(reference_bsdf_tint(&s, cosine), s.opacity);
    return (kd_vec3){1 - s.opacity + tint.x, 1 - s.opacity + tint.y, 1 - s.opacity + tint.z};
}

static void dim_by_opacity(const struct RTCFilterFunctionNArguments *args)
{
    ray_context *c = (ray_context *)(void *)args->context;
    uint32_t object = object_of(args);
    if (c->shadow && c->scene->objects[object].no_shadow) {
        args->valid[0] = 0;
        return;
    }
    c->transmittance = reference_mul(c->transmittance, passing(c->scene, object, args));
    if (!reference_is_black(c->transmittance))
        args->valid[0] = 0;
}

/* Camera rays see no backs. Embree's normal is that of the triangle in its own space, as is the ray it shows
 * here. */
static void see_fronts(const struct RTCFilterFunctionNArguments *args)
{
    const ray_context *c = (const ray_context *)(const void *)args->context;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    const struct RTCRay *ray = (const struct RTCRay *)args->ray;
    const reference_object *o = &c->scene->objects[object_of(args)];
    if (c->scene->materials[o->material].params.maps.z || c->scene->lambert)
        return;
    float d = hit->Ng_x * ray->dir_x + hit->Ng_y * ray->dir_y + hit->Ng_z * ray->dir_z;
    /* In the object's own space the winding is what the file says; baked meshes are mirrored with their
     * vertices. */
    bool turned = o->mirrored && !o->instanced;
    if (turned ? d < 0 : d > 0)
        args->valid[0] = 0;
}

static void pass_no_shadow(const struct RTCFilterFunctionNArguments *args)
{
    const ray_context *c = (const ray_context *)(const void *)args->context;
    if (c->scene->objects[object_of(args)].no_shadow)
        args->valid[0] = 0;
}

/* An instanced mesh may stand in several materials: it asks always. */
void reference_filters_set(RTCGeometry geometry, const reference_scene *scene, const reference_object *object)
{
    if (object && scene->materials[object->material].alpha_mode == KD_ALPHA_OPAQUE)
        return;
    rtcSetGeometryIntersectFilterFunction(geometry, stop_by_opacity);
    rtcSetGeometryOccludedFilterFunction(geometry, dim_by_opacity);
}

static struct RTCRay ray_make(const reference_ray *r)
{
    return (struct RTCRay){.org_x = r->origin.x,
                           .org_y = r->origin.y,
                           .org_z = r->origin.z,
                           .tnear = r->t_min,
                           .dir_x = r->direction.x,
                           .dir_y = r->direction.y,
                           .dir_z = r->direction.z,
                           .tfar = r->t_max,
                           .mask = UINT32_MAX};
}

bool reference_intersect(const reference_scene *scene, const reference_ray *r, bool seen, uint32_t random,
                         reference_hit *hit)
{
    ray_context c = context_make(scene);
    struct RTCRayHit q = {.ray = ray_make(r)};
    c.random = random;
    c.base.filter = seen ? see_fronts : NULL;
    q.hit.geomID = q.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene->rays, &c.base, &q);
    if (q.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    *hit =
        (reference_hit){.object = q.hit.instID[0] != RTC_INVALID_GEOMETRY_ID ? q.hit.instID[0] : q.hit.geomID,
                        .triangle = q.hit.primID,
                        .u = q.hit.u,
                        .v = q.hit.v,
                        .t = q.ray.tfar,
                        .map_u = q.hit.u,
                        .map_v = q.hit.v};
    return true;
}

kd_vec3 reference_transmittance(const reference_scene *scene, const reference_ray *r, bool shadow)
{
    ray_context c = context_make(scene);
    struct RTCRay q = ray_make(r);
    c.shadow = shadow && scene->any_no_shadow;
    c.base.filter = c.shadow ? pass_no_shadow : NULL;
    rtcOccluded1(scene->rays, &c.base, &q);
    return q.tfar < 0 ? (kd_vec3){0, 0, 0} : c.transmittance; /* Embree marks what is occluded by -infinity */
}
