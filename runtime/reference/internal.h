#ifndef KD_REFERENCE_INTERNAL_H
#define KD_REFERENCE_INTERNAL_H

/* What the files of runtime/reference share: the scene as rays see it, and the sampling of materials and
 * lights. */

#include <embree3/rtcore.h>

#include "components/camera.h"
#include "components/mesh_instance.h"
#include "components/scene_store.h"
#include "components/sky.h"
#include "runtime/core/arena.h"
#include "runtime/ecs/query.h"
#include "runtime/jobs/jobs.h"
#include "runtime/reference/reference.h"
#include "runtime/reference/sampler.h"
#include "shaders/shared/scene.h"

#define REFERENCE_PI 3.14159265358979f

/* ---- materials ---- */

typedef struct reference_map {
    const kd_image *image; /* NULL: none */
    kd_wrap_mode wrap_s, wrap_t;
    bool nearest, srgb;
    bool late_decode; /* interpolate the codes and decode the mean, as some renderers do */
} reference_map;

typedef struct reference_surface reference_surface;

typedef struct reference_material {
    struct kd_material_params params;
    reference_map maps[5]; /* in order of KD_MAP_* */
    kd_alpha_mode alpha_mode;
    bool emits;
} reference_material;

/* Texture coordinates of a point and its vertex colour. */
typedef struct reference_attributes {
    kd_vec2 uv[2];
    kd_vec4 color;
} reference_attributes;

void reference_material_make(const kd_scene_store *store, uint32_t number, bool lambert,
                             reference_material *out);
/** Fill in all of a surface that its material says, but the normal. */
void reference_material_at(const reference_material *m, const reference_attributes *a,
                           reference_surface *out);
/** Share of rays that a base colour's alpha stops. */
float reference_opacity(const reference_material *m, float alpha);
kd_vec4 reference_base_color(const reference_material *m, const reference_attributes *a);
/** x: metallic, y: roughness. */
kd_vec2 reference_metallic_roughness(const reference_material *m, const reference_attributes *a);
/** In tangent space, not normalised; false when the material has no normal map. */
bool reference_normal_map(const reference_material *m, const reference_attributes *a, kd_vec3 *n);
kd_vec3 reference_emission(const reference_material *m, const reference_attributes *a);

/* ---- geometry ---- */

/* Triangles in the object's space: the world's, unless the object is instanced. */
typedef struct reference_mesh {
    uint32_t triangle_count, vertex_count;
    const uint32_t *indices;  /* of the store */
    const kd_vec3 *positions; /* in Embree's buffer */
    const kd_vec3 *normals;   /* of the store, or our own when posed */
    const kd_vec4 *tangents;  /* the same */
    const kd_vec2 *uv[2];     /* NULL when missing */
    const kd_vec4 *colors;    /* NULL when missing */
} reference_mesh;

typedef struct reference_object {
    reference_mesh mesh;
    uint32_t material;
    uint32_t first_emitter; /* KD_NONE: does not emit */
    bool mirrored;          /* triangles wind the other way round in the world */
    bool no_shadow;
    bool instanced;         /* mesh is in model space: positions go through `to_world` */
    kd_mat4 to_world;       /* for normals and tangents of baked meshes too; identity for skinned ones */
    kd_vec3 normal_rows[3]; /* inverse transpose, up to a positive factor */
} reference_object;

/* One triangle that shines. */
typedef struct reference_emitter {
    uint32_t object, triangle;
    float density; /* probability density of a point on it, per square metre, among all emitters */
} reference_emitter;

/* A picture round the scene, and the sums by which its bright parts are found. */
typedef struct reference_sky {
    kd_sky_map map; /* width 0: none */
    float factor;
    kd_vec3 rows[3]; /* from the world's directions to the map's */
    float *row_cdf;  /* [height] sums up to 1 */
    float *cdf;      /* [height][width] sums of each row up to 1 */
} reference_sky;

typedef struct reference_scene {
    kd_arena arena;
    RTCDevice device;
    RTCScene rays;
    RTCScene *parts; /* of instanced meshes, by store primitive; NULL where none */
    uint32_t part_count;
    reference_object *objects; /* numbered as the geometries of `rays` */
    uint32_t object_count, object_capacity;
    reference_material *materials;
    uint32_t material_count;
    reference_emitter *emitters;
    float *emitter_cdf; /* [emitter_count] sums up to 1 */
    uint32_t emitter_count;
    struct kd_light_params *lights;
    bool *light_shadow; /* casts shadows */
    uint32_t light_count;
    float lamp_distance2; /* least squared distance to a point or spot light, m^2 */
    kd_vec3 ambient;      /* radiance from everywhere */
    reference_sky sky;    /* on top of it */
    kd_view view;
    kd_vec3 bounds_min, bounds_max;
    bool lambert, any_no_shadow;
    uint64_t triangle_count;
} reference_scene;

/** Build all from the world. After a failure reference_scene_fini is still to be called. Errors as
 * kd_reference_open */
kd_status reference_scene_build(kd_world *w, bool lambert, reference_scene *out);
void reference_scene_fini(reference_scene *scene);
kd_status reference_emitters_build(reference_scene *scene);
kd_status reference_lights_build(kd_world *w, reference_scene *scene);
kd_status reference_sky_build(kd_world *w, reference_scene *scene);

/** World positions of a triangle's corners. */
void reference_triangle(const reference_object *o, uint32_t triangle, kd_vec3 out[3]);
/** Texture coordinates and colour at barycentric (u, v). */
reference_attributes reference_attributes_at(const reference_mesh *m, uint32_t triangle, float u, float v);

/* ---- posing ---- */

typedef struct reference_pose {
    const kd_vec3 *positions, *normals;
    const kd_vec4 *tangents;
} reference_pose;
/** Pose a primitive as the deform pass does, into the arena. `rows` NULL: not skinned. Errors KD_NO_MEMORY */
kd_status reference_pose_make(kd_arena *arena, const kd_primitive_desc *desc, const kd_vec4 (*rows)[3],
                              uint32_t row_count, const kd_morph_weights *weights, reference_pose *out);

/* ---- rays ---- */

typedef struct reference_ray {
    kd_vec3 origin, direction;
    float t_min, t_max;
} reference_ray;

typedef struct reference_hit {
    uint32_t object, triangle;
    float u, v, t;
    float map_u, map_v; /* where maps are read: u, v unless the hit stands for a pixel */
} reference_hit;

/** Find the nearest hit. `seen`: a ray of the camera, which passes through the backs of one-sided surfaces.
 * `random` decides whether blended surfaces stop the ray. */
bool reference_intersect(const reference_scene *scene, const reference_ray *ray, bool seen, uint32_t random,
                         reference_hit *hit);
/** Share of light that passes from the origin to t_max, by colour. `shadow`: of a light, to which some
 * objects cast no shadow. */
kd_vec3 reference_transmittance(const reference_scene *scene, const reference_ray *ray, bool shadow);
/** Give an object's geometry the filters it needs. */
void reference_filters_set(RTCGeometry geometry, const reference_scene *scene,
                           const reference_object *object);

/* ---- a point of a surface ---- */

struct reference_surface {
    kd_vec3 position;
    kd_vec3 face;     /* of the triangle, on the side of the ray */
    kd_vec3 normal;   /* for shading, normal map applied, on the side of the ray */
    kd_vec3 albedo;   /* 0 … 1 */
    kd_vec3 emission; /* towards the ray */
    kd_vec3 shown;    /* unlit: the colour */
    float metallic, roughness;
    float opacity; /* share of rays that stop here */
    float error;   /* m, how far the position may be off */
    bool unlit, lambert;
    kd_vec3 f0;                 /* what the dielectric reflects head-on */
    float f90;                  /* and at grazing view */
    float coat, coat_roughness; /* of a clear coat over all */
    float transmission;         /* share of the dielectric's light that passes through */
};

/** Read the maps of a hit where another ray of the same pixel meets the triangle's plane: the mean over a
 * pixel then has its maps filtered, and its edges not. */
void reference_hit_spread(const reference_scene *scene, const reference_ray *ray, reference_hit *hit);
void reference_surface_make(const reference_scene *scene, const reference_hit *hit, kd_vec3 direction,
                            reference_surface *out);
/** Move a point off its surface, to the side of `direction`, so far that rays do not meet the surface again.
 */
kd_vec3 reference_leave(const reference_surface *s, kd_vec3 direction);

/* ---- reflection: v and l are unit, away from the surface ---- */

typedef struct reference_bsdf {
    kd_vec3 diffuse, specular; /* each times n.l */
    float pdf;                 /* of reference_bsdf_sample choosing l, per steradian */
} reference_bsdf;
void reference_bsdf_evaluate(const reference_surface *s, kd_vec3 v, kd_vec3 l, reference_bsdf *out);
/** Share of light that a surface's coat reflects, and so keeps from what lies below. */
float reference_bsdf_coat(const reference_surface *s, float n_dot_v);
/** What passes straight through a surface, of light along a view at the angle `n_dot_v` (cosine). */
kd_vec3 reference_bsdf_tint(const reference_surface *s, float n_dot_v);
/** Choose l. u: three numbers in 0 … 1. Returns false when nothing is reflected. */
bool reference_bsdf_sample(const reference_surface *s, kd_vec3 v, const float u[3], kd_vec3 *l);
/** A frame's vector x, y, z (z along n) in the world. */
kd_vec3 reference_from_frame(kd_vec3 n, kd_vec3 local);
kd_vec3 reference_cosine(float u, float v);

/* ---- lights ---- */

typedef struct reference_light_sample {
    kd_vec3 to_light;   /* unit */
    kd_vec3 irradiance; /* on a surface facing it, over the probability of the choice; 0: none */
    float distance;     /* INFINITY for directional lights */
    bool shadow;
} reference_light_sample;
/** Choose one of the directional, point and spot lights by what it would give the surface. */
reference_light_sample reference_light_choose(const reference_scene *scene, const reference_surface *s,
                                              float u);

typedef struct reference_emitter_sample {
    kd_vec3 position, radiance;
    kd_vec3 normal; /* on the side of the receiver */
    kd_vec3 to_light;
    float distance, pdf; /* per steradian; 0: none */
    float error;
} reference_emitter_sample;
reference_emitter_sample reference_emitter_choose(const reference_scene *scene, kd_vec3 from,
                                                  const float u[3]);
/** Density per steradian by which reference_emitter_choose finds a point that was hit. */
float reference_emitter_pdf(const reference_scene *scene, const reference_hit *hit,
                            const reference_surface *at, kd_vec3 direction);

/** Radiance of the whole sky along a unit direction. */
kd_vec3 reference_sky_radiance(const reference_scene *scene, kd_vec3 direction);
/** The same of its picture alone. */
kd_vec3 reference_sky_picture(const reference_scene *scene, kd_vec3 direction);
/** Choose a direction by the picture's brightness. Returns its density per steradian; 0: none. */
float reference_sky_choose(const reference_scene *scene, float u, float v, kd_vec3 *direction);
/** Density per steradian by which reference_sky_choose finds a direction. */
float reference_sky_pdf(const reference_scene *scene, kd_vec3 direction);

/* ---- paths ---- */

typedef struct reference_sample {
    kd_vec3 direct, diffuse, specular, albedo, normal;
    float ao, depth;
    uint32_t rays;
} reference_sample;

typedef struct reference_options {
    int32_t bounces;      /* of directional, point and spot lights; negative: endless */
    int32_t area_bounces; /* of emitters and sky; with endless ones endless */
    bool centre, ambient_occlusion;
    float ao_falloff, ao_intensity, ao_distance;
    uint64_t seed;
} reference_options;

void reference_path(const reference_scene *scene, const reference_options *options,
                    const sampler_tables *tables, uint32_t x, uint32_t y, uint32_t index,
                    reference_sample *out);

/* ---- small things ---- */

static inline float reference_luminance(kd_vec3 c)
{
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}
static inline float reference_largest(kd_vec3 c)
{
    return c.x > c.y ? (c.x > c.z ? c.x : c.z) : (c.y > c.z ? c.y : c.z);
}
static inline kd_vec3 reference_mul(kd_vec3 a, kd_vec3 b)
{
    return (kd_vec3){a.x * b.x, a.y * b.y, a.z * b.z};
}
static inline kd_vec3 reference_mad(kd_vec3 a, float s, kd_vec3 b)
{
    return (kd_vec3){a.x * s + b.x, a.y * s + b.y, a.z * s + b.z};
}
static inline bool reference_is_black(kd_vec3 c)
{
    return !(c.x > 0 || c.y > 0 || c.z > 0);
}

#endif
