#ifndef KD_SHADERS_RESOLVE_H
#define KD_SHADERS_RESOLVE_H

#include "shaders/shared/layout.h"

/* What the picture shows: the numbers of kd_view_mode. */
#define KD_SHOW_FINAL    0u
#define KD_SHOW_DIRECT   1u
#define KD_SHOW_INDIRECT 2u
#define KD_SHOW_AO       3u
#define KD_SHOW_SPECULAR 4u
#define KD_SHOW_ALBEDO   5u
#define KD_SHOW_NORMAL   6u
#define KD_SHOW_DEPTH    7u
#define KD_SHOW_LIGHT    8u
#define KD_SHOW_COUNT    9 /* what the resolve pass shows; the tone map knows another */
#define KD_SHOW_COST     9u

/* The numbers of kd_tonemap. */
#define KD_CURVE_ACES     0u
#define KD_CURVE_REINHARD 1u
#define KD_CURVE_LINEAR   2u

/* Edge in pixels of the squares of the picture whose local lights are marked. */
#define KD_TILE_EDGE 16u

/* Uniform block KD_BIND_PASS of the passes that make the picture. */
struct kd_resolve_params {
    uvec4 mode; /* x: KD_SHOW_* by which the tone map treats the picture, y: KD_CURVE_*, z: 1 when the GI
                   targets hold light (of costs: samples of the hottest colour), w: groups of luminance */
    /* ---- 16 */
    vec4 gathered; /* x: unit of the light in the GI targets; yzw 0 */
    /* ---- 32 */
};
KD_LAYOUT_CHECK(kd_resolve_params, 32)

/* Uniform block KD_BIND_PASS of shaders/resolve/steady.comp. */
struct kd_steady_params {
    uvec4 mode;  /* as above */
    /* ---- 16 */
    vec4 share;  /* x: of the picture before in this one; yzw 0 */
    /* ---- 32 */
    mat4 before; /* view projection of the frame before */
    /* ---- 96 */
};
KD_LAYOUT_CHECK(kd_steady_params, 96)

#include "shaders/shared/layout_end.h"

#endif
