#ifndef KD_APP_SCENE_H
#define KD_APP_SCENE_H

/* What is to be rendered and how: the world filled from a scenario or a model, and the figures that the
 * scenario, the command line or a default gave. */

#include "components/frame.h"
#include "runtime/app/options.h"
#include "runtime/ecs/world.h"
#include "runtime/script/script.h"
#include "systems/scene/scene.h"

/* What the world holds already: a model or shape in the scene store, or the picture of a sky. */
typedef struct app_loaded {
    char *key;       /* its path, scene, variant and level, a line each; what a shape is made of; or of a
                        sky APP_SKY_PREFIX and its path */
    uint32_t number; /* in the scene store, or as kd_sky.image */
} app_loaded;
#define APP_SKY_PREFIX "sky:"

typedef struct app_scene {
    kd_world *world;
    uint32_t width, height;
    double fps, seconds; /* seconds negative: not said */
    uint32_t gi, view;
    kd_settings settings;
    kd_script *script;   /* NULL for a bare model */
    kd_entity turntable; /* turned about +Y every step; KD_NO_ENTITY: nothing is */
    bool started;        /* kandil.scene comes too late */
    app_loaded *loaded;
    uint32_t loaded_count, loaded_capacity;
    int32_t entities_max;     /* what the command line allows: a scenario may lower it */
    uint64_t shape_triangles; /* of all shapes that its scenario has made */
    void (*asked_for)(void *user, const char *path); /* as in its options */
    void *asked_for_user;
    const struct app_scene *beside; /* while it loads: another scene, whose models may be shared; or NULL */
} app_scene;

/** Fill the world from the file that the options name, then let the command line have the last word.
 *  beside  a scene from the same files, whose models are shared instead of read; or NULL
 *  Errors with one message */
kd_status app_scene_load(app_scene *scene, kd_world *world, const app_options *options,
                         const app_scene *beside);

/** Fill the world anew from the same kind of file: every entity goes, and what was registered stays, to be
 * used again. The schedule's clock begins anew too. Errors with one message; it holds a part of the scene
 * then */
kd_status app_scene_renew(app_scene *scene, const app_options *options);

/** Bring the world to simulation step `index`: scenario, turntable, and what the systems know of the frame.
 */
kd_status app_scene_step(app_scene *scene, uint64_t index);

/** Tell the systems about frame `index`, and what is to be shown: the world stays as it is. */
void app_scene_show(const app_scene *scene, uint64_t index);

/** Frames that the command line and the scenario ask for. */
uint64_t app_scene_frames(const app_scene *scene, const app_options *options);

void app_scene_fini(app_scene *scene);

/* ---- for the two ways to fill it ---- */

/** Frame, light and turn a bare model. */
kd_status app_scene_load_model(app_scene *scene, const app_options *options);

/** Load a scenario, or run its functions for the first time. */
kd_status app_scene_load_script(app_scene *scene, const app_options *options);

/** Register a model file with the store, once a path, scene and variant (by name, NULL: as the file says). */
kd_status app_scene_model(app_scene *scene, const char *path, const kd_model_options *options, uint32_t *out);

/** Read the picture of a sky, once a path. Returns its number as kd_sky.image. Errors as kd_sky_image_load,
 * TOO_LARGE for more than half a gigabyte of them */
kd_status app_scene_sky(app_scene *scene, const char *path, uint32_t *out);

/** Find what was registered under a key, or is by the scene beside, whose model is then shared. */
bool app_scene_find_loaded(app_scene *scene, const char *key, uint32_t *out);
/** Remember what was registered under a key. */
kd_status app_scene_add_loaded(app_scene *scene, const char *key, uint32_t number);

/** Tell whether scenarios and --set may set a field: not those that number entries of the scene store. */
bool app_may_write(const char *component, const char *field);

#endif
