#ifndef KD_CORE_SETTINGS_H
#define KD_CORE_SETTINGS_H

/* The settings behind `--set KEY=VALUE` and `kandil help settings`: one table gives the struct and its rows,
 * so that the two cannot differ. "voxels.span" is the member voxels_span. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "runtime/core/status.h"

#define KD_BINDING_LIST(X)    X(NEAREST, "nearest") X(GEODESIC, "geodesic")
#define KD_SVO_LAYERS_LIST(X) X(TWO, "two") X(ONE, "one")
#define KD_SVO_BUILD_LIST(X)  X(ORDERFREE, "orderfree") X(ATOMIC, "atomic") X(LEVELS, "levels")
#define KD_BOUNCES_LIST(X)    X(NONE, "0") X(ONE, "1") X(TWO, "2") X(INF, "inf")
#define KD_LEAK_LIST(X)       X(DEFAULT, "default") X(STRICT, "strict")
#define KD_CONES_LIST(X)      X(TRILINEAR, "trilinear") X(QUADRILINEAR, "quadrilinear") X(PAPER, "paper")
#define KD_TONEMAP_LIST(X)    X(ACES, "aces") X(REINHARD, "reinhard") X(LINEAR, "linear")
#define KD_TILES_LIST(X)      X(AUTO, "auto") X(ON, "on") X(OFF, "off")
#define KD_CHANNEL_LIST(X)                                                                                   \
    X(AUTO, "auto")                                                                                          \
    X(RADIANCE, "radiance")                                                                                  \
    X(ALBEDO, "albedo") X(NORMAL, "normal") X(OPACITY, "opacity") X(CASCADE, "cascade")

typedef enum kd_binding {
#define KD_BINDING_ENUM(name, text) KD_BINDING_##name,
    KD_BINDING_LIST(KD_BINDING_ENUM)
#undef KD_BINDING_ENUM
} kd_binding;

typedef enum kd_svo_layers {
#define KD_SVO_LAYERS_ENUM(name, text) KD_SVO_LAYERS_##name,
    KD_SVO_LAYERS_LIST(KD_SVO_LAYERS_ENUM)
#undef KD_SVO_LAYERS_ENUM
} kd_svo_layers;

typedef enum kd_svo_build {
#define KD_SVO_BUILD_ENUM(name, text) KD_SVO_BUILD_##name,
    KD_SVO_BUILD_LIST(KD_SVO_BUILD_ENUM)
#undef KD_SVO_BUILD_ENUM
} kd_svo_build;

typedef enum kd_bounces {
#define KD_BOUNCES_ENUM(name, text) KD_BOUNCES_##name,
    KD_BOUNCES_LIST(KD_BOUNCES_ENUM)
#undef KD_BOUNCES_ENUM
} kd_bounces;

typedef enum kd_leak {
#define KD_LEAK_ENUM(name, text) KD_LEAK_##name,
    KD_LEAK_LIST(KD_LEAK_ENUM)
#undef KD_LEAK_ENUM
} kd_leak;

typedef enum kd_cones_interpolation {
#define KD_CONES_ENUM(name, text) KD_CONES_##name,
    KD_CONES_LIST(KD_CONES_ENUM)
#undef KD_CONES_ENUM
} kd_cones_interpolation;

typedef enum kd_tonemap {
#define KD_TONEMAP_ENUM(name, text) KD_TONEMAP_##name,
    KD_TONEMAP_LIST(KD_TONEMAP_ENUM)
#undef KD_TONEMAP_ENUM
} kd_tonemap;

typedef enum kd_light_tiles {
#define KD_TILES_ENUM(name, text) KD_TILES_##name,
    KD_TILES_LIST(KD_TILES_ENUM)
#undef KD_TILES_ENUM
} kd_light_tiles;

typedef enum kd_view_channel {
#define KD_CHANNEL_ENUM(name, text) KD_CHANNEL_##name,
    KD_CHANNEL_LIST(KD_CHANNEL_ENUM)
#undef KD_CHANNEL_ENUM
} kd_view_channel;

typedef enum kd_setting_type {
    KD_SETTING_BOOL,
    KD_SETTING_I32,
    KD_SETTING_F32,
    KD_SETTING_ENUM
} kd_setting_type;

/* X(type, group, name, default, min, max, words, unit, doc). `words` is NULL, the words of an ENUM (its value
 * is their index), or the only values an I32 may have. */
#define KD_SETTINGS_LIST(X)                                                                                  \
    X(F32, voxels, span, 0.02f, 1e-4, 100, NULL, "m", "edge of a voxel of the finest cascade")               \
    X(I32, voxels, resolution, 128, 128, 1024, resolution_words, "voxels",                                   \
      "voxels a cascade has along an axis")                                                                  \
    X(I32, voxels, cascades, 3, 1, 4, NULL, NULL, "nested cascades; each doubles the span")                  \
    X(I32, voxels, separating, 6, 6, 26, separating_words, NULL,                                             \
      "what no path through free cells crosses: by faces (thin; rigid meshes in the finest cascade) or at "  \
      "all")                                                                                                 \
    X(BOOL, voxels, fill, false, 0, 1, NULL, NULL, "fill closed meshes")                                     \
    X(ENUM, voxels, binding, KD_BINDING_NEAREST, 0, 1, binding_words, NULL,                                  \
      "skinned voxels move as the nearest surface does, or by the way to the bones through the body")        \
    X(BOOL, voxels, cache, true, 0, 1, NULL, NULL, "keep voxels on disk for the next start")                 \
    X(I32, subdiv, level, 0, 0, 6, NULL, NULL,                                                               \
      "sides of cage faces are cut into 2^level; 0: as the model says, else 3")                              \
    X(ENUM, svo, layers, KD_SVO_LAYERS_TWO, 0, 1, layers_words, NULL,                                        \
      "keep static voxels apart, or rebuild all")                                                            \
    X(ENUM, svo, build, KD_SVO_BUILD_ORDERFREE, 0, 2, build_words, NULL,                                     \
      "how the octree is made; atomic and levels rebuild all in every frame")                                \
    X(I32, svo, memory, 0, 0, 65536, NULL, "MiB",                                                            \
      "most memory of one array of the octree; 0: what the driver binds")                                    \
    X(I32, cones, count, 6, 3, 16, NULL, NULL, "diffuse cones a pixel")                                      \
    X(F32, cones, aperture_deg, 60, 10, 120, NULL, "deg", "full opening angle of a diffuse cone")            \
    X(F32, cones, far, 1.0f, 0.1, 1, NULL, NULL,                                                             \
      "width of a diffuse cone far from its start, of its opening there; 1: a plain cone")                   \
    X(F32, cones, step, 0.5f, 0.1, 2, NULL, "diameters", "step along a cone")                                \
    X(ENUM, cones, interpolation, KD_CONES_TRILINEAR, 0, 2, interpolation_words, NULL,                       \
      "in a level of the octree, between two as well, or by one march that takes the cones in turn")         \
    X(F32, cones, max_distance, 0, 0, 1e6, NULL, "m", "end of a cone; 0: the whole tree")                    \
    X(I32, cones, resolution, 2, 1, 4, NULL, "pixels", "trace every n-th pixel of both axes")                \
    X(F32, cones, refine, 0.2f, 0, 1, NULL, NULL,                                                            \
      "trace at twice the spacing where neighbours differ by less; 0: nowhere")                              \
    X(I32, cones, reuse, 2, 0, 4, NULL, "frames",                                                            \
      "trace each pixel every so many frames where light holds; 0: in all")                                  \
    X(F32, cones, start, 1.5f, 0, 16, NULL, "voxels", "distance from the surface at which a cone starts")    \
    X(F32, cones, intensity, 1, 0, 100, NULL, NULL, "factor on indirect light; 1 is physical")               \
    X(BOOL, cones, counters, false, 0, 1, NULL, NULL, "count the samples of every cone, for --stats")        \
    X(F32, ao, falloff, 1, 0, 1000, NULL, "1/m", "how fast occlusion fades with distance")                   \
    X(F32, ao, intensity, 1, 0, 10, NULL, NULL, "strength of ambient occlusion")                             \
    X(BOOL, specular, cones, true, 0, 1, NULL, NULL, "trace a reflection cone by roughness")                 \
    X(F32, light, ambient, 0, 0, 1e6, NULL, "W/(sr m^2)", "radiance of a white sky")                         \
    X(BOOL, light, sky_sun, true, 0, 1, NULL, NULL,                                                          \
      "the sun in a sky's picture shines as a directional light, with shadows")                              \
    X(I32, light, shadow_size, 2048, 64, 8192, NULL, "texels",                                               \
      "edge of a directional shadow map; local lights have a half or a quarter")                             \
    X(I32, light, shadow_cascades, 3, 1, 4, NULL, NULL, "shadow maps of a directional light")                \
    X(F32, light, shadow_distance, 40, 0.1, 1e5, NULL, "m",                                                  \
      "distance up to which directional shadows reach")                                                      \
    X(ENUM, light, bounces, KD_BOUNCES_INF, 0, 3, bounces_words, NULL,                                       \
      "times that light of lamps is reflected before it is seen indirectly")                                 \
    X(ENUM, light, tiles, KD_TILES_AUTO, 0, 2, tiles_words, NULL,                                            \
      "each tile of the picture is lit by the local lights that reach it, or by all; auto: where many are")  \
    X(ENUM, light, leak, KD_LEAK_DEFAULT, 0, 1, leak_words, NULL,                                            \
      "strict: next to no light through walls one voxel thick, for darker bounces of thin things")           \
    X(F32, view, exposure_ev, 0, -20, 20, NULL, "EV", "exposure; one more doubles the brightness")           \
    X(BOOL, view, auto_exposure, false, 0, 1, NULL, NULL, "choose the exposure from the picture")            \
    X(ENUM, view, tonemap, KD_TONEMAP_ACES, 0, 2, tonemap_words, NULL,                                       \
      "curve from scene light to the screen")                                                                \
    X(BOOL, view, steady, true,  0, 1, NULL, NULL,                                                           \
      "mix the picture with those before while the camera moves: smoother edges, less flicker")              \
    X(I32, view, level, -1, -1, 15, NULL, NULL,                                                              \
      "level that views of voxels and of the tree show, each twice as coarse; -1 and 0: the finest")         \
    X(ENUM, view, channel, KD_CHANNEL_AUTO, 0, 5, channel_words, NULL,                                       \
      "what these views show of a voxel; auto: albedo of caches and pages, radiance of the tree")            \
    X(I32, view, cost_scale, 256, 1, 9999, NULL, "samples", "what --view cost shows in the hottest colour")  \
    X(I32, film, supersample, 1, 1, 8, NULL, "pixels",                                                       \
      "render n x n pixels for each of the picture and take the mean of their light")                        \
    X(I32, film, subframes, 1, 1, 256, NULL, NULL,                                                           \
      "moments a frame is the mean of while the shutter is open; 1: no motion blur")                         \
    X(F32, film, shutter_deg, 180, 0, 360, NULL, "deg",                                                      \
      "how long the shutter is open before a frame's time; 360: a whole step")                               \
    X(BOOL, film, layers, false, 0, 1, NULL, NULL,                                                           \
      "write the parts of the light, albedo, normal, depth and motion into .exr too")                        \
    X(I32, film, png_depth, 8, 8, 16, depth_words, "bits", "bits a channel of .png")                         \
    X(I32, script, entities, 250000, 1, 16777216, NULL, NULL,                                                \
      "entities that a world may have when its scenario makes more")                                         \
    X(BOOL, debug, access, false, 0, 1, NULL, NULL,                                                          \
      "stop when a system touches components that it does not declare")                                      \
    X(I32, debug, shuffle, 0, 0, 99999, NULL, NULL,                                                          \
      "seed of a shuffled, legal order of systems; 0: their own")

#define KD_SETTING_C_BOOL bool
#define KD_SETTING_C_I32  int32_t
#define KD_SETTING_C_F32  float
#define KD_SETTING_C_ENUM int32_t

typedef struct kd_settings {
#define KD_SETTING_MEMBER(type, group, name, default_, min, max, words, unit, doc)                           \
    KD_SETTING_C_##type group##_##name;
    KD_SETTINGS_LIST(KD_SETTING_MEMBER)
#undef KD_SETTING_MEMBER
} kd_settings;

typedef struct kd_setting_row {
    const char *key; /* "voxels.span" */
    kd_setting_type type;
    uint32_t offset; /* in kd_settings */
    double default_value, min, max;
    const char *const *words; /* NULL-terminated, or NULL: see the list */
    const char *unit;         /* NULL when it has none */
    const char *doc;
} kd_setting_row;

/** Get the settings as they are when nothing was said. */
kd_settings kd_settings_defaults(void);

/** Set one from "key=value". Errors USAGE with a message that names the key and what is allowed; nothing
 * changes then */
kd_status kd_settings_set(kd_settings *settings, const char *assignment);

/** Get every row, in order of the list. Returns static memory. */
const kd_setting_row *kd_settings_rows(size_t *count);
/** Find a row by its key (key_length bytes). Returns NULL when there is none. */
const kd_setting_row *kd_settings_find(const char *key, size_t key_length);
/** Read a value as a number (an ENUM as its index). */
double kd_settings_value(const kd_settings *settings, const kd_setting_row *row);
/** Write a value as `--set` would take it, and return `out`. 32 bytes are enough. */
const char *kd_settings_format(const kd_settings *settings, const kd_setting_row *row, char *out,
                               size_t out_size);

#endif
