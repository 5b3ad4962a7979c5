#ifndef KD_SCRIPT_SCRIPT_H
#define KD_SCRIPT_SCRIPT_H

/* Scenarios: Lua 5.4 in a sandbox over one world. The script layer knows the world and its reflection only;
 * models, shapes, materials and clips are made by the host that the application hands in.
 *
 * A scenario can reach neither the system nor native code, reads no file but those that the host loads from
 * below its folder or the asset roots, and every step of it has a limit of memory, instructions and time.
 */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "runtime/core/file.h"
#include "runtime/core/math.h"
#include "runtime/core/status.h"
#include "runtime/ecs/world.h"

typedef struct kd_script kd_script;

/* ---- what a scenario asks of its host ---- */

/* kandil.scene; zero or NULL stands for what was not said. */
typedef struct kd_script_scene {
    uint32_t width, height; /* pixels */
    double fps, seconds;
    const char *gi, *view;
} kd_script_scene;

typedef struct kd_script_mesh {
    const char *shape; /* "box" …; NULL: no mesh */
    kd_vec3 size;      /* m, each positive; default 1 1 1 */
    uint32_t segments; /* 0: a good default */
} kd_script_mesh;

typedef struct kd_script_material {
    bool given;
    kd_vec4 base_color;        /* linear, default white */
    float metallic, roughness; /* default 0 and 1 */
    kd_vec3 emissive;          /* radiance, linear */
    bool double_sided, unlit;
    float ior, specular;                  /* default 1.5 and 1 */
    float clearcoat, clearcoat_roughness; /* default 0 */
    float transmission;                   /* default 0 */
} kd_script_material;

typedef struct kd_script_play {
    const char *clip; /* NULL: the first */
    bool loop;
    float speed;      /* 1 is as recorded */
    float blend_s;    /* length of the cross-fade */
    uint32_t layer;   /* 0: the pose itself; above that clips are laid over it */
    bool stop;        /* fade the layer out instead; no clip then */
    float weight;     /* of a layer, 0 to 1 */
    const char *from; /* node below which a layer moves the model; NULL: all of it */
} kd_script_play;

/* The parts of kandil.spawn that are more than component values. */
typedef struct kd_script_spawn {
    const char *name;                  /* NULL: none */
    const char *model;                 /* a path that may be read, or NULL */
    const char *model_scene, *variant; /* of the model, by name; NULL: as the file says */
    const char *sky_image;             /* a path that may be read, or NULL */
    const char (*roots)[KD_PATH_MAX];  /* [root_count] folders in which the model's own files must lie */
    uint32_t root_count;
    kd_script_mesh mesh;
    kd_script_material material;
    kd_entity parent; /* KD_NO_ENTITY: a root */
} kd_script_spawn;

/* Why a host call failed: one line, without a file name of the scenario. */
typedef struct kd_script_error {
    char text[512];
} kd_script_error;

/* Every call may be NULL except spawn; the pointers it gets are borrowed. A failing call fills `error`. */
typedef struct kd_script_host {
    void *user;
    kd_status (*scene)(void *user, const kd_script_scene *scene, kd_script_error *error);
    kd_status (*set)(void *user, const char *assignment, kd_script_error *error); /* "voxels.span=0.05" */
    /* Make an entity that has at least a transform, below the parent. */
    kd_status (*spawn)(void *user, const kd_script_spawn *spawn, kd_entity *out, kd_script_error *error);
    kd_status (*play)(void *user, kd_entity entity, const kd_script_play *play, kd_script_error *error);
    /* Find a clip of the entity's model: its number in the component "animation", and its length. */
    kd_status (*find_clip)(void *user, kd_entity entity, const char *clip, uint32_t *number, float *length_s,
                           kd_script_error *error);
    /* Copy an entity and what hangs below it. NULL: kd_instantiate does. */
    kd_status (*clone)(void *user, kd_entity entity, kd_entity parent, kd_entity *out,
                       kd_script_error *error);
    /* Tell whether scenarios may set a field: most are, but not numbers that other systems trust. NULL: all
     * are. */
    bool (*may_write)(void *user, const char *component, const char *field);
    /* Told of every file that the scenario asks for, whether it is there or not. NULL: nobody is. */
    void (*asked_for)(void *user, const char *path);
    /* Tell whether the run is to end: what runs of the scenario then returns INTERRUPTED, without a message.
     * Asked often. NULL: never. */
    bool (*stopped)(void *user);
} kd_script_host;

/* ---- what it is told of a window ---- */

typedef enum kd_script_callback {
    KD_SCRIPT_UPDATE, /* every step; the others when there is a window */
    KD_SCRIPT_ON_KEY,
    KD_SCRIPT_ON_MOUSE,
    KD_SCRIPT_ON_MOUSE_MOVE,
    KD_SCRIPT_ON_SCROLL,
    KD_SCRIPT_CALLBACK_COUNT
} kd_script_callback;

typedef struct kd_script_input {
    kd_script_callback kind;
    const char *name; /* of the key or button; static text */
    bool down;
    float x, y; /* of the pointer: 0 … 1 from the upper left; of the wheel: notches */
} kd_script_input;

/* ---- running one ---- */

typedef struct kd_script_desc {
    const char *path;
    const char *const *roots; /* [root_count] folders beside the scenario's own */
    uint32_t root_count;
    const char *const *params; /* [param_count] "NAME=value", for kandil.param */
    uint32_t param_count;
    uint64_t seed;              /* of math.random */
    size_t memory_limit;        /* bytes; 0 means 256 MiB */
    uint64_t instruction_limit; /* of a step, or of loading; 0 means 50 million */
    double time_limit_s;        /* likewise, the host's own work left out; 0 means 5 */
    kd_world *world;            /* kept; must outlive the script, its components registered */
    kd_script_host host;        /* kept */
} kd_script_desc;

/** Load a scenario and run it once from top to bottom. Strings of `desc` are copied.
 *
 *  Errors     SCRIPT for what is wrong in it, NO_MEMORY, or what reading the file gave; one message
 *             `FILE:LINE: what is wrong; what to do` is logged
 *  Threading  the thread that owns the world; nothing else may touch the world meanwhile
 */
kd_status kd_script_load(const kd_script_desc *desc, kd_script **out);

/** Run one simulation step: what is due of kandil.at, every and run, in order of time, then tweens, then
 * kandil.update.
 *  Errors as kd_script_load; after one the script must not be stepped again. */
kd_status kd_script_step(kd_script *script, double time_s, double dt_s);

/** Tell whether the scenario has set this function of `kandil`. */
bool kd_script_listens(const kd_script *script, kd_script_callback callback);
/** Keep what happened for the next step, which begins by telling the scenario; of more than 256 between two
 * steps the oldest are dropped. */
void kd_script_push_input(kd_script *script, const kd_script_input *input);

/** Files that it was read from: the scenario, then its modules. */
uint32_t kd_script_file_count(const kd_script *script);
const char *kd_script_file(const kd_script *script, uint32_t index);

/** Bytes that the scenario holds. */
size_t kd_script_bytes(const kd_script *script);

void kd_script_destroy(kd_script *script); /* NULL does nothing */

/** Write the reference of what scenarios can use, in Markdown: functions, methods, components with their
 * fields. may_write  tells which fields are to be shown as settable; NULL: all */
void kd_script_write_reference(const kd_world *w,
                               bool (*may_write)(void *user, const char *component, const char *field),
                               FILE *out);

#endif
