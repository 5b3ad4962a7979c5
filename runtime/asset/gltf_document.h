#ifndef KD_ASSET_GLTF_DOCUMENT_H
#define KD_ASSET_GLTF_DOCUMENT_H

/* What a glTF file's JSON says, as plain C rows and unchecked: an index is an int that may point anywhere
 * (-1: not there), a count is what the file claims. Everything lives in one arena. Only gltf_shim.cpp fills
 * it. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "runtime/asset/gltf_scan.h"
#include "runtime/core/arena.h"
#include "runtime/core/status.h"

enum { GLTF_BYTE = 5120, GLTF_UBYTE, GLTF_SHORT, GLTF_USHORT, GLTF_INT, GLTF_UINT, GLTF_FLOAT };
enum { GLTF_POINTS, GLTF_LINES, GLTF_LINE_LOOP, GLTF_LINE_STRIP, GLTF_TRIANGLES, GLTF_STRIP, GLTF_FAN };

typedef struct gltf_ints {
    const int *at;
    size_t count;
} gltf_ints;
typedef struct gltf_reals {
    const double *at;
    size_t count;
} gltf_reals;
typedef struct gltf_strings {
    const char *const *at;
    size_t count;
} gltf_strings;

typedef struct gltf_buffer {
    const char *uri; /* NULL: the GLB's binary chunk */
    uint64_t byte_length;
    const uint8_t *bytes; /* filled by gltf_load_buffers */
} gltf_buffer;

typedef struct gltf_image {
    const char *name, *uri, *mime; /* uri NULL: in a view */
    int view;
} gltf_image;

/* EXT_meshopt_compression: the view's bytes come from these, in another buffer perhaps. */
typedef struct gltf_packed {
    int buffer;
    uint64_t offset, length, stride, count;
    const char *mode, *filter;
} gltf_packed;
typedef struct gltf_view {
    int buffer;
    uint64_t offset, length, stride; /* stride 0: tight */
    const gltf_packed *packed;       /* NULL: the bytes lie in the buffer as they are */
    const uint8_t *unpacked;         /* [length] filled by gltf_unpack_views */
} gltf_view;

typedef struct gltf_accessor {
    int view;
    uint64_t offset, count;
    int component; /* GLTF_BYTE … */
    int width;     /* components an element: 1-4, 9, 16 */
    bool matrix, normalized, sparse;
    int64_t sparse_count, sparse_index_offset, sparse_value_offset;
    int sparse_index_view, sparse_index_component, sparse_value_view;
} gltf_accessor;

typedef struct gltf_attribute {
    const char *name;
    int accessor;
} gltf_attribute;
typedef struct gltf_attributes {
    const gltf_attribute *at;
    size_t count;
} gltf_attributes;
/* A subdivision cage from `extras`, with USD's names. */
typedef struct gltf_cage {
    const char *scheme, *boundary, *uv_rule; /* NULL: missing */
    gltf_ints face_sizes, corners, creases, crease_lengths, sharp_corners, uv_corners;
    gltf_reals crease_sharpness, corner_sharpness, uv;
    int64_t level; /* 0: missing */
} gltf_cage;
typedef struct gltf_primitive {
    gltf_attributes attributes;
    const gltf_attributes *targets;
    size_t target_count;
    int material, indices, mode;
    const gltf_cage *cage;  /* NULL: none */
    int draco;              /* KHR_draco_mesh_compression: view of its bytes; -1: none */
    gltf_attributes unique; /* names, and Draco's own ids instead of accessors */
    const int
        *variant_of; /* KHR_materials_variants: [variant_count of the document] material or -1; NULL: none */
} gltf_primitive;
typedef struct gltf_mesh {
    const char *name;
    const gltf_primitive *primitives;
    size_t primitive_count;
    gltf_reals weights;
} gltf_mesh;

typedef struct gltf_texture_use {
    int texture, uv_set;
    double strength; /* normal scale, occlusion strength */
    double offset[2], scale[2], rotation;
} gltf_texture_use;
typedef struct gltf_material {
    const char *name, *alpha_mode;
    double base_color[4], emissive[3], metallic, roughness, alpha_cutoff, emissive_strength;
    gltf_texture_use base_color_map, metallic_roughness_map, normal_map, occlusion_map, emissive_map;
    bool double_sided, unlit;
    /* further ways to reflect, and the textures (or -1) that their factors are multiplied by */
    double glossiness; /* of the archived extension; below 0: the material has none */
    int glossiness_texture;
    double ior, specular, specular_color[3], clearcoat, clearcoat_roughness, transmission;
    int specular_texture, specular_color_texture, clearcoat_texture, clearcoat_roughness_texture,
        clearcoat_normal_texture, transmission_texture;
} gltf_material;
typedef struct gltf_texture {
    int sampler, source;
} gltf_texture;
typedef struct gltf_sampler {
    int mag_filter, min_filter, wrap_s, wrap_t;
} gltf_sampler;

typedef struct gltf_node {
    const char *name;
    int mesh, skin, camera, light;
    gltf_ints children;
    gltf_reals matrix, translation, rotation, scale, weights;
    bool hidden;               /* KHR_node_visibility */
    gltf_attributes instances; /* EXT_mesh_gpu_instancing */
} gltf_node;
typedef struct gltf_skin {
    const char *name;
    gltf_ints joints;
    int inverse_bind;
} gltf_skin;
typedef struct gltf_camera {
    const char *name;
    bool orthographic;
    double fov_y, aspect, x_mag, y_mag, z_near, z_far;
} gltf_camera;
typedef struct gltf_light {
    const char *name, *type;
    gltf_reals color;
    double intensity, range, inner_cone, outer_cone;
} gltf_light;

typedef struct gltf_channel {
    int sampler, node;
    const char *path;
} gltf_channel;
typedef struct gltf_curve {
    int input, output;
    const char *interpolation;
} gltf_curve;
typedef struct gltf_clip {
    const char *name;
    const gltf_channel *channels;
    const gltf_curve *curves;
    size_t channel_count, curve_count;
} gltf_clip;

typedef struct gltf_document {
    const char *version, *min_version, *generator;
    gltf_strings extensions_used, extensions_required;
    gltf_buffer *buffers;
    gltf_image *images;
    gltf_view *views;
    gltf_accessor *accessors;
    gltf_mesh *meshes;
    gltf_material *materials;
    gltf_texture *textures;
    gltf_sampler *samplers;
    gltf_node *nodes;
    gltf_skin *skins;
    gltf_camera *cameras;
    gltf_light *lights;
    gltf_clip *clips;
    gltf_ints *scenes; /* root nodes */
    gltf_strings scene_names, variants;
    size_t buffer_count, image_count, view_count, accessor_count, mesh_count, material_count, texture_count,
        sampler_count, node_count, skin_count, camera_count, light_count, clip_count, scene_count;
    int default_scene;
} gltf_document;

/** Turn scanned JSON text into rows.
 *
 *  text   the scanned text: its `buffers` and `images` are blanked, their source stands in the scan
 *  error  what is wrong, in words, when the status is not KD_OK; no message is logged. out's
 *         extensions_required are there even then, unless they are what is wrong
 */
kd_status gltf_parse(const char *text, size_t size, const gltf_scan *scan, kd_arena *arena,
                     gltf_document *out, char *error, size_t error_size);

#ifdef __cplusplus
}
#endif

#endif
