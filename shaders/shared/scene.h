#ifndef KD_SHADERS_SCENE_H
#define KD_SHADERS_SCENE_H

#include "shaders/shared/layout.h"

/* Vertex streams, shared by drawing, deforming and voxelizing.
 *   geometry stream, 8 words: position f32x3 | normal snorm16x4 (2 words, w 0) | tangent snorm16x4 (2 words, w ±1) | 0
 *   attribute stream, 6 words: uv0 f32x2 | uv1 f32x2 | colour unorm8x4 (linear) | 0
 *   skin stream, 4 words: joints u16x4 (2 words) | weights unorm16x4 (2 words)
 *   morph stream, 6 words a vertex and target: position delta f32x3 | normal delta f32x3 */
#define KD_GEOMETRY_WORDS 8
#define KD_ATTRIBUTE_WORDS 6
#define KD_SKIN_WORDS 4
#define KD_MORPH_WORDS 6

/* vertex attribute locations */
#define KD_LOC_POSITION 0
#define KD_LOC_NORMAL 1
#define KD_LOC_TANGENT 2
#define KD_LOC_UV0 3
#define KD_LOC_UV1 4
#define KD_LOC_COLOR 5
#define KD_LOC_OBJECT 6 /* u32 per instance: index into kd_objects, reached through base_instance */
#define KD_LOC_PREVIOUS 7 /* position a frame ago, of kd_motion */

/* One drawn primitive of one entity. */
struct kd_object {
    mat4 model_ws;        /* model to world; identity for skinned objects, whose vertices are deformed into world space */
    /* ---- 64 */
    vec4 normal_ws[3];    /* rows of the inverse transpose of the upper 3x3; w unused */
    /* ---- 112 */
    uvec4 info;           /* x: material, y: flags KD_OBJECT_*, z: entity index, w: 0 */
    /* ---- 128 */
};
KD_LAYOUT_CHECK(kd_object, 128)
#define KD_OBJECT_NO_SHADOW 1u
#define KD_OBJECT_MIRRORED 2u /* negative determinant: front faces turn over */
#define KD_OBJECT_MOVES 4u    /* deforms, or has moved */

struct kd_material_params {
    vec4 base_color;      /* linear, a: opacity */
    /* ---- 16 */
    vec4 emissive;        /* rgb: radiance, linear; a: alpha cutoff, negative when there is no mask */
    /* ---- 32 */
    vec4 surface;         /* x metallic, y roughness, z normal scale, w 1 when unlit */
    /* ---- 48 */
    uvec4 maps;           /* bits KD_MAP_* in x; y: bits of maps that read uv1; z: 1 when double sided; w: 1 when opacity is 1 */
    /* ---- 64 */
    vec4 uv_transform[10]; /* two rows (a b tx 0 / c d ty 0) for each of the five maps, in order of KD_MAP_* */
    /* ---- 224 */
    vec4 specular;        /* rgb: what a dielectric reflects head-on, a: at grazing view */
    vec4 lobes;           /* x clear coat, y its roughness, z transmission, w 0 */
    /* ---- 256 */
};
KD_LAYOUT_CHECK(kd_material_params, 256)
#define KD_MAP_BASE_COLOR 1u
#define KD_MAP_METALLIC_ROUGHNESS 2u
#define KD_MAP_NORMAL 4u
#define KD_MAP_EMISSIVE 8u
#define KD_MAP_OCCLUSION 16u

/* The camera of this frame, uniform block KD_BIND_VIEW. */
struct kd_view_params {
    mat4 view;
    mat4 projection;
    mat4 view_projection;
    mat4 inverse_view_projection;
    /* ---- 256 */
    vec4 position_ws;  /* w: z_near */
    vec4 forward_ws;   /* w: z_far */
    uvec4 size;        /* xy: pixels, z: frame index, w: 0 */
    vec4 lens;         /* x: tan(fov_y/2), y: aspect, z: exposure factor, w: 0 */
    /* ---- 320 */
};
KD_LAYOUT_CHECK(kd_view_params, 320)

#define KD_MAX_LIGHTS 260
#define KD_MAX_SHADOW_CASCADES 4
#define KD_MAX_DIRECTIONAL_SHADOWS 4
#define KD_MAX_SPOT_SHADOWS 48
struct kd_light_params {
    vec4 position_ws;   /* w: range, 0 no limit */
    vec4 direction_ws;  /* travels along; w: 0 directional, 1 point, 2 spot */
    vec4 color;         /* rgb: colour * intensity (lx or cd), w: angular scale of spots */
    vec4 shadow;        /* x: first shadow matrix or -1, y: matrices, z: layer of the first, w: angular offset of spots */
    /* ---- 64 */
};
KD_LAYOUT_CHECK(kd_light_params, 64)

/* A point light's shadow takes six spot layers (its cube faces in GL order). */
struct kd_lights_params {
    uvec4 count;        /* x: lights, y: shadow cascades of directional lights, z: edge of directional shadow maps in pixels, w: of spot maps */
    /* ---- 16 */
    KD_STRUCT kd_light_params light[KD_MAX_LIGHTS];
    /* ---- 16656 */
    mat4 shadow_matrix[KD_MAX_SHADOW_CASCADES * KD_MAX_DIRECTIONAL_SHADOWS + KD_MAX_SPOT_SHADOWS]; /* world to [0,1]^3; directional ones first */
    /* ---- 20752 */
    vec4 kinds;         /* x: directional lights: they come first in `light`, y: smallest squared distance to a lamp [m^2]; zw 0 */
    vec4 cascade_texel_ws[KD_MAX_SHADOW_CASCADES * KD_MAX_DIRECTIONAL_SHADOWS]; /* x: edge of a texel in metres, y: half depth range in metres */
    /* ---- 21024 */
};
KD_LAYOUT_CHECK(kd_lights_params, 21024)

#include "shaders/shared/layout_end.h"

#endif
