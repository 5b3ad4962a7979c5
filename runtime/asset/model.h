#ifndef KD_ASSET_MODEL_H
#define KD_ASSET_MODEL_H

/* A model as plain description: what a glTF file says, checked. Everything an index refers to exists; every
 * number is finite; the node graph is a forest. Owned by one arena: kd_model_destroy frees all. glTF axes (+Y
 * up, metres). */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/file.h"
#include "runtime/core/math.h"
#include "runtime/core/status.h"

#define KD_NONE UINT32_MAX /* "no index" */

typedef struct kd_image {
    const char *name;
    uint32_t width, height;
    const uint8_t *rgba; /* width*height*4, row 0 on top */
} kd_image;

typedef enum kd_wrap_mode { KD_WRAP_REPEAT, KD_WRAP_CLAMP, KD_WRAP_MIRROR } kd_wrap_mode;
typedef struct kd_texture_ref {
    uint32_t image;  /* or KD_NONE */
    uint32_t uv_set; /* 0 or 1 */
    kd_wrap_mode wrap_s, wrap_t;
    bool nearest;
    kd_vec2 offset, scale; /* KHR_texture_transform: uv' = offset + R(rotation) * (scale * uv) */
    float rotation;
} kd_texture_ref;

typedef enum kd_alpha_mode { KD_ALPHA_OPAQUE, KD_ALPHA_MASK, KD_ALPHA_BLEND } kd_alpha_mode;
typedef struct kd_material_desc {
    const char *name;
    kd_vec4 base_color;            /* linear */
    kd_texture_ref base_color_map; /* sRGB */
    float metallic, roughness;
    kd_texture_ref metallic_roughness_map; /* linear; G roughness, B metallic */
    kd_texture_ref normal_map;
    float normal_scale;
    kd_texture_ref occlusion_map;
    float occlusion_strength;
    kd_vec3 emissive;            /* linear, times KHR_materials_emissive_strength */
    kd_texture_ref emissive_map; /* sRGB */
    kd_alpha_mode alpha_mode;
    float alpha_cutoff;
    bool double_sided;
    bool unlit;
    float ior;                            /* of dielectrics, 1 or more; 0 reflects everything */
    float specular;                       /* of dielectrics: share of the reflection that is there, 0 to 1 */
    kd_vec3 specular_color;               /* linear, times their reflection head-on */
    float clearcoat, clearcoat_roughness; /* share covered by a coat of varnish of ior 1.5 */
    float transmission; /* share of what enters a dielectric that leaves on its other side, tinted, instead of
                           being scattered back; alpha_mode is KD_ALPHA_BLEND where it is not 0 */
    bool glows_in_clips; /* a clip of the model moves its emission */
    bool alpha_ignored;  /* the base colour's alpha says nothing: of transmissive materials that are opaque */
} kd_material_desc;

/** Does it send out light, now or while a clip plays? */
static inline bool kd_material_glows(const kd_material_desc *m)
{
    return m->glows_in_clips || m->emissive.x > 0 || m->emissive.y > 0 || m->emissive.z > 0;
}

/* Triangles only: strips and fans are unrolled, points and lines dropped with a warning. Indices always
 * there. */
typedef struct kd_primitive_desc {
    uint32_t material; /* or KD_NONE: the default material */
    uint32_t vertex_count, index_count;
    const uint32_t *indices;     /* [index_count], each < vertex_count, index_count % 3 == 0 */
    const kd_vec3 *positions;    /* [vertex_count] */
    const kd_vec3 *normals;      /* unit length; made when the file has none (flat, as glTF asks) */
    const kd_vec4 *tangents;     /* xyz unit, w ±1; made (per triangle uv, orthonormalised) when missing */
    const kd_vec2 *uv0, *uv1;    /* NULL when missing */
    const kd_vec4 *colors;       /* linear, NULL when missing */
    const uint16_t (*joints)[4]; /* NULL when not skinned */
    const kd_vec4 *weights;      /* the four largest, sum 1 */
    uint32_t morph_count;        /* same for all primitives of a mesh */
    const kd_vec3 *const *morph_positions; /* [morph_count][vertex_count] deltas, each may be NULL */
    const kd_vec3 *const *morph_normals;
    kd_vec3 bounds_min, bounds_max;           /* of positions */
    const struct kd_subdivision *subdivision; /* NULL: these triangles are all there is */
} kd_primitive_desc;

/* A primitive with a cage is the cage's limit surface at rest: joints and morph deltas of its vertices are
 * those of the cage, blended. Where it deforms, the cage is posed and the rows give the surface: position =
 * sum of weight * cage position, and likewise its derivatives along u and v. */
typedef struct kd_stencil {
    uint32_t vertex; /* of the cage */
    float weight, du, dv;
} kd_stencil;
typedef struct kd_stencil_row {
    uint32_t first, count;      /* entries; their vertices rise */
    float tangent_u, tangent_v; /* the tangent runs along tangent_u * d/du + tangent_v * d/dv */
} kd_stencil_row;
typedef struct kd_subdivision {
    uint32_t level; /* sides of cage faces are cut into 2^level */
    uint32_t stencil_count;
    const kd_stencil_row *rows;    /* [vertex_count of the surface] */
    const kd_stencil *stencils;    /* [stencil_count] */
    const kd_primitive_desc *cage; /* its triangles are the faces, cut up; `subdivision` is NULL */
} kd_subdivision;

typedef struct kd_mesh_desc {
    const char *name;
    uint32_t primitive_count;
    const kd_primitive_desc *primitives;
    uint32_t morph_count;
    const float *morph_weights; /* [morph_count] defaults */
} kd_mesh_desc;

typedef struct kd_skin_desc {
    const char *name;
    uint32_t joint_count;
    const uint32_t *joints;      /* nodes */
    const kd_mat4 *inverse_bind; /* [joint_count] */
} kd_skin_desc;

typedef enum kd_light_type { KD_LIGHT_DIRECTIONAL, KD_LIGHT_POINT, KD_LIGHT_SPOT } kd_light_type;
/* Not kd_light_desc: that is the reflection of component kd_light. */
typedef struct kd_model_light {
    const char *name;
    kd_light_type type;
    kd_vec3 color;                /* linear */
    float intensity;              /* lx for directional, cd for point and spot */
    float range;                  /* m; 0: no limit */
    float inner_cone, outer_cone; /* rad, half angles */
} kd_model_light;

typedef struct kd_model_camera {
    const char *name;
    bool orthographic;
    float fov_y;         /* rad */
    float aspect;        /* 0: the window's */
    float x_mag, y_mag;  /* orthographic half extents, m */
    float z_near, z_far; /* z_far 0: infinite */
} kd_model_camera;

typedef struct kd_node_desc {
    const char *name; /* never NULL */
    uint32_t parent;  /* KD_NONE for roots; parents come before children in the array */
    kd_vec3 translation;
    kd_quat rotation;
    kd_vec3 scale;   /* a matrix with shear is split off: see `matrix` */
    bool has_matrix; /* the node's matrix cannot be written as TRS: use `matrix` (not animated) */
    kd_mat4 matrix;
    uint32_t mesh, skin, camera, light; /* KD_NONE or index */
    uint32_t morph_count;
    const float *morph_weights; /* [morph_count], or NULL: the mesh's defaults */
} kd_node_desc;

typedef enum kd_channel_path {
    KD_PATH_TRANSLATION,
    KD_PATH_ROTATION,
    KD_PATH_SCALE,
    KD_PATH_WEIGHTS,
    KD_PATH_PROPERTY /* see kd_property_channel */
} kd_channel_path;
typedef enum kd_interpolation {
    KD_INTERPOLATE_LINEAR,
    KD_INTERPOLATE_STEP,
    KD_INTERPOLATE_CUBIC
} kd_interpolation;
typedef struct kd_channel_desc {
    uint32_t node;
    kd_channel_path path;
    kd_interpolation interpolation;
    uint32_t key_count;
    uint32_t width;     /* floats a value: 3, 4, or the number of morph targets */
    const float *times; /* [key_count] s, strictly rising */
    const float
        *values; /* [key_count * width], cubic: [key_count * 3 * width] (in-tangent, value, out-tangent) */
} kd_channel_desc;
/* What a clip moves besides nodes (KHR_animation_pointer). */
typedef enum kd_property {
    KD_PROPERTY_BASE_COLOR, /* of a material: 4 floats */
    KD_PROPERTY_METALLIC,
    KD_PROPERTY_ROUGHNESS,
    KD_PROPERTY_EMISSIVE,          /* 3 floats: radiance, the factor times the strength at rest */
    KD_PROPERTY_EMISSIVE_STRENGTH, /* as a share of that at rest */
    KD_PROPERTY_LIGHT_COLOR,       /* 3 floats */
    KD_PROPERTY_LIGHT_INTENSITY,
    KD_PROPERTY_LIGHT_RANGE,
    KD_PROPERTY_LIGHT_INNER_CONE,
    KD_PROPERTY_LIGHT_OUTER_CONE,
    KD_PROPERTY_CAMERA_FOV_Y,
    KD_PROPERTY_CAMERA_Y_MAG
} kd_property;
typedef struct kd_property_channel {
    kd_property property;
    uint32_t target;       /* material, light or camera of the model */
    kd_channel_desc curve; /* its node is KD_NONE */
} kd_property_channel;
typedef struct kd_clip_desc {
    const char *name;
    float duration; /* s */
    uint32_t channel_count;
    const kd_channel_desc *channels;
    uint32_t property_count;
    const kd_property_channel *properties; /* ascending by target, then by property; each once */
} kd_clip_desc;

typedef struct kd_model {
    const char *path;
    uint32_t image_count, material_count, mesh_count, skin_count, light_count, camera_count, node_count,
        clip_count;
    const kd_image *images;
    const kd_material_desc *materials;
    const kd_mesh_desc *meshes;
    const kd_skin_desc *skins;
    const kd_model_light *lights;
    const kd_model_camera *cameras;
    const kd_node_desc *nodes; /* of the default scene (the first when none is named, all nodes without
                                 scenes), then joints that stand outside it; parents first */
    const kd_clip_desc *clips;
    uint32_t warning_count;
    const char *const *warnings;        /* optional extensions not supported, dropped points and lines, … */
    const char *const *extensions_used; /* NULL-terminated */
    uint32_t file_count;
    const char *const *files;    /* paths of what was read beside the model's own file */
    const char *const *scenes;   /* names, NULL-terminated; "scene 0" where there is none */
    const char *const *variants; /* of materials (KHR_materials_variants), NULL-terminated */
    uint32_t scene;              /* the one that was loaded; KD_NONE: the file names no scenes */
    const char *generator;
    uint64_t triangle_count;        /* over node instances */
    kd_vec3 bounds_min, bounds_max; /* rest pose, model space */
    void *internal;
} kd_model;

/** Load and check a .gltf or .glb file. On failure one message is logged as `FILE: what is wrong (where);
 * what to do`. Errors KD_NOT_FOUND, KD_NO_PERMISSION, KD_IO, KD_BAD_FORMAT, KD_UNSUPPORTED (a required
 * extension, named), KD_TOO_LARGE, KD_NO_MEMORY. */
kd_status kd_model_load(const char *path, kd_model **out);

typedef struct kd_model_options {
    uint32_t subdiv_level;       /* of all cages; 0: each file's own, else KD_SUBDIV_LEVEL */
    const char *scene, *variant; /* by name; NULL: the file's default scene, the materials as they stand */
    const char (*roots)[KD_PATH_MAX]; /* [root_count] folders in which its files must lie, links resolved */
    uint32_t root_count;              /* 0: anywhere */
    bool without_triangles;           /* a file with nothing to draw is no error: it is only listed */
} kd_model_options;
#define KD_SUBDIV_LEVEL     3u
#define KD_SUBDIV_LEVEL_MAX 6u
/** Load with options; errors as above. */
kd_status kd_model_load_with(const char *path, const kd_model_options *options, kd_model **out);

/** Evaluate a limit surface for cage positions. normals  [vertex_count] unit; where the surface has none,
 * left as they are. tangents  [vertex_count] xyz only; may be NULL */
void kd_subdivision_evaluate(const kd_subdivision *s, uint32_t vertex_count, const kd_vec3 *cage,
                             kd_vec3 *positions, kd_vec3 *normals, kd_vec4 *tangents);
/** Let go of a model; it goes when the last of those who share it has. */
void kd_model_destroy(kd_model *model);
/** Have a further holder of a model, who destroys it too. Threading: holders share one thread. Returns model
 */
kd_model *kd_model_share(kd_model *model);

/** Tell whether a glTF extension is read, in whole or in the part that this renderer can show. */
bool kd_model_reads_extension(const char *name);

/* ---- primitives made in memory: unit-sized, centred at the origin, with uv, normals and tangents ---- */
typedef enum kd_shape {
    KD_SHAPE_BOX,
    KD_SHAPE_SPHERE,
    KD_SHAPE_PLANE,
    KD_SHAPE_CYLINDER,
    KD_SHAPE_TORUS
} kd_shape;
/** Make a model of one node, one mesh and one material. box: edge lengths `size`; sphere, cylinder: diameter
 * size.x, height size.y; plane: size.x by size.z facing +Y; torus: outer diameter size.x, tube diameter
 * size.y. segments 0: a good default. */
kd_status kd_model_make_shape(kd_shape shape, kd_vec3 size, uint32_t segments,
                              const kd_material_desc *material, kd_model **out);

/** The material that glTF gives to primitives without one. */
kd_material_desc kd_material_default(void);

#endif
