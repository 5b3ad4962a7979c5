/* From a hit to the surface there, as shaders/deferred/geometry.frag finds it. */

#include <math.h>

#include "runtime/reference/internal.h"

static kd_vec3 blend3(kd_vec3 a, kd_vec3 b, kd_vec3 c, float u, float v)
{
    float w = 1 - u - v;
    return (kd_vec3){w * a.x + u * b.x + v * c.x, w * a.y + u * b.y + v * c.y, w * a.z + u * b.z + v * c.z};
}

void reference_triangle(const reference_object *o, uint32_t triangle, kd_vec3 out[3])
{
    const uint32_t *i = o->mesh.indices + (size_t)triangle * 3;
    for (int k = 0; k < 3; k++)
        out[k] =
            o->instanced ? kd_mat4_point(&o->to_world, o->mesh.positions[i[k]]) : o->mesh.positions[i[k]];
}

reference_attributes reference_attributes_at(const reference_mesh *m, uint32_t triangle, float u, float v)
{
    const uint32_t *i = m->indices + (size_t)triangle * 3;
    float w = 1 - u - v;
    reference_attributes a = {.color = {1, 1, 1, 1}};
    for (int k = 0; k < 2; k++) {
        const kd_vec2 *uv = m->uv[k];
        if (uv)
            a.uv[k] = (kd_vec2){w * uv[i[0]].x + u * uv[i[1]].x + v * uv[i[2]].x,
                                w * uv[i[0]].y + u * uv[i[1]].y + v * uv[i[2]].y};
    }
    if (m->colors) {
        const kd_vec4 *c0 = &m->colors[i[0]], *c1 = &m->colors[i[1]], *c2 = &m->colors[i[2]];
        a.color = (kd_vec4){w * c0->x + u * c1->x + v * c2->x, w * c0->y + u * c1->y + v * c2->y,
                            w * c0->z + u * c1->z + v * c2->z, w * c0->w + u * c1->w + v * c2->w};
    }
    return a;
}

static kd_vec3 to_world_normal(const reference_object *o, kd_vec3 n)
{
    return (kd_vec3){kd_vec3_dot(o->normal_rows[0], n), kd_vec3_dot(o->normal_rows[1], n),
                     kd_vec3_dot(o->normal_rows[2], n)};
}

/* Scaled by the largest component first: cofactors of a small model would vanish when squared. */
static kd_vec3 unit(kd_vec3 v, kd_vec3 fallback)
{
    float largest = fmaxf(fabsf(v.x), fmaxf(fabsf(v.y), fabsf(v.z)));
    return largest > 1e-30f && largest < INFINITY ? kd_vec3_normalize(kd_vec3_scale(v, 1 / largest), fallback)
                                                  : fallback;
}

static kd_vec3 vertex_normal(const reference_object *o, const reference_hit *h, kd_vec3 face)
{
    const uint32_t *i = o->mesh.indices + (size_t)h->triangle * 3;
    kd_vec3 n[3];
    for (int k = 0; k < 3; k++)
        n[k] = unit(to_world_normal(o, o->mesh.normals[i[k]]), face);
    return unit(blend3(n[0], n[1], n[2], h->u, h->v), face);
}

/* The tangent is made orthogonal again: interpolation and shear bend it. */
static kd_vec3 mapped_normal(const reference_object *o, const reference_hit *h, const reference_material *m,
                             const reference_attributes *a, kd_vec3 n)
{
    kd_vec3 map;
    if (!reference_normal_map(m, a, &map) || !o->mesh.tangents)
        return n;
    const uint32_t *i = o->mesh.indices + (size_t)h->triangle * 3;
    const kd_vec4 *t = o->mesh.tangents;
    kd_vec3 along[3];
    for (int k = 0; k < 3; k++)
        along[k] = kd_mat4_direction(&o->to_world, (kd_vec3){t[i[k]].x, t[i[k]].y, t[i[k]].z});
    kd_vec3 tangent = blend3(along[0], along[1], along[2], h->u, h->v);
    tangent = kd_vec3_sub(tangent, kd_vec3_scale(n, kd_vec3_dot(n, tangent)));
    float length2 = kd_vec3_dot(tangent, tangent), side = t[i[0]].w * (o->mirrored ? -1.0f : 1.0f);
    if (length2 < 1e-12f)
        return n;
    tangent = kd_vec3_scale(tangent, 1 / sqrtf(length2));
    kd_vec3 bitangent = kd_vec3_scale(kd_vec3_cross(n, tangent), side * map.y);
    kd_vec3 bent = reference_mad(tangent, map.x, reference_mad(n, fmaxf(map.z, 1e-3f), bitangent));
    return unit(bent, n);
}

static float extent(kd_vec3 p)
{
    return fmaxf(fabsf(p.x), fmaxf(fabsf(p.y), fabsf(p.z)));
}

/* How far rounding may put the point off its triangle: some units in the last place of the numbers it is made
 * of, which of an instance are those of the model's space too. */
static float rounding(const reference_object *o, const kd_vec3 p[3])
{
    float size = fmaxf(extent(p[0]), fmaxf(extent(p[1]), extent(p[2])));
    if (o->instanced)
        size += extent((kd_vec3){o->to_world.m[12], o->to_world.m[13], o->to_world.m[14]});
    return 2e-6f * size;
}

static void set_material(const reference_scene *scene, const reference_hit *h, bool front,
                         reference_surface *out)
{
    const reference_object *o = &scene->objects[h->object];
    const reference_material *m = &scene->materials[o->material];
    reference_attributes a = reference_attributes_at(&o->mesh, h->triangle, h->map_u, h->map_v);
    reference_material_at(m, &a, out);
    out->lambert = scene->lambert;
    bool shines = m->emits && (front || m->params.maps.z || scene->lambert);
    out->emission = shines ? reference_emission(m, &a) : (kd_vec3){0, 0, 0};
    if (!scene->lambert)
        out->normal = mapped_normal(o, h, m, &a, out->normal);
}

/* Source  Moeller and Trumbore 1997, Fast, Minimum Storage Ray/Triangle Intersection */
void reference_hit_spread(const reference_scene *scene, const reference_ray *ray, reference_hit *hit)
{
    kd_vec3 p[3];
    reference_triangle(&scene->objects[hit->object], hit->triangle, p);
    kd_vec3 e1 = kd_vec3_sub(p[1], p[0]), e2 = kd_vec3_sub(p[2], p[0]), s = kd_vec3_sub(ray->origin, p[0]);
    kd_vec3 h = kd_vec3_cross(ray->direction, e2), q = kd_vec3_cross(s, e1);
    float scale = 1 / kd_vec3_dot(e1, h), u = kd_vec3_dot(s, h) * scale,
          v = kd_vec3_dot(ray->direction, q) * scale, t = kd_vec3_dot(e2, q) * scale;
    if (t > 0.5f * hit->t && t < 2 * hit->t) { /* beyond, the pixel reaches the horizon; NaN fails too */
        hit->map_u = u;
        hit->map_v = v;
    }
}

void reference_surface_make(const reference_scene *scene, const reference_hit *h, kd_vec3 direction,
                            reference_surface *out)
{
    const reference_object *o = &scene->objects[h->object];
    kd_vec3 p[3];
    reference_triangle(o, h->triangle, p);
    kd_vec3 cross = kd_vec3_cross(kd_vec3_sub(p[1], p[0]), kd_vec3_sub(p[2], p[0]));
    kd_vec3 face = unit(o->mirrored ? kd_vec3_scale(cross, -1) : cross, kd_vec3_scale(direction, -1));
    bool front = kd_vec3_dot(face, direction) <= 0;
    float side = front ? 1.0f : -1.0f;
    out->position = blend3(p[0], p[1], p[2], h->u, h->v);
    out->normal = vertex_normal(o, h, face);
    out->error = rounding(o, p);
    set_material(scene, h, front, out);
    out->normal = kd_vec3_scale(out->normal, side);
    if (out->coat > 0)
        out->emission =
            kd_vec3_scale(out->emission, 1 - reference_bsdf_coat(out, -kd_vec3_dot(out->normal, direction)));
    out->face = kd_vec3_scale(face, side);
}

kd_vec3 reference_leave(const reference_surface *s, kd_vec3 direction)
{
    float side = kd_vec3_dot(s->face, direction) < 0 ? -1.0f : 1.0f;
    return reference_mad(s->face, side * s->error, s->position);
}
