#ifndef KD_TESTS_SCRIPT_FIXTURE_H
#define KD_TESTS_SCRIPT_FIXTURE_H

/* A world with a few components and a host that makes plain entities, for tests of the scenario layer alone.
 * Included once, by the test's only source. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "runtime/core/log.h"
#include "runtime/script/script.h"

typedef struct fixture_transform {
    kd_vec3 position;
    kd_quat rotation;
    kd_vec3 scale;
} fixture_transform;
static const fixture_transform transform_default = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
static const kd_field transform_fields[] = {
    KD_FIELD(fixture_transform, position, KD_VEC3, "m", "place"),
    KD_FIELD(fixture_transform, rotation, KD_QUAT, NULL, "turn"),
    KD_FIELD(fixture_transform, scale, KD_VEC3, NULL, "size"),
};
static const kd_component_desc fixture_transform_desc = {.name = "transform",
                                                         .size = (uint32_t)sizeof(fixture_transform),
                                                         .align = (uint32_t) _Alignof(fixture_transform),
                                                         .fields = transform_fields,
                                                         .field_count = 3,
                                                         .default_value = &transform_default};

typedef struct fixture_light {
    uint32_t type;
    kd_vec3 color;
    float intensity, outer_cone;
    uint8_t no_shadow;
} fixture_light;
static const char *const fixture_light_types[] = {"directional", "point", "spot", NULL};
static const fixture_light light_default = {.color = {1, 1, 1}, .intensity = 3, .outer_cone = 0.785398163f};
static const kd_field light_fields[] = {
    KD_FIELD_ENUM(fixture_light, type, fixture_light_types, "kind"),
    KD_FIELD(fixture_light, color, KD_COLOR, NULL, "colour"),
    KD_FIELD_RANGE(fixture_light, intensity, KD_F32, "cd", 0, 1e6, "strength"),
    KD_FIELD_RANGE(fixture_light, outer_cone, KD_F32, "rad", 0, 1.5707964, "half angle"),
    KD_FIELD(fixture_light, no_shadow, KD_BOOL, NULL, "shines through"),
};
static const kd_component_desc fixture_light_desc = {.name = "light",
                                                     .size = (uint32_t)sizeof(fixture_light),
                                                     .align = (uint32_t) _Alignof(fixture_light),
                                                     .fields = light_fields,
                                                     .field_count = 5,
                                                     .default_value = &light_default};

/* What the host alone makes: everything it spawns has one, unless it is named "bare". */
typedef struct fixture_part {
    uint32_t store; /* a number that scenarios may not set */
    uint8_t hidden;
} fixture_part;
static const kd_field part_fields[] = {
    KD_FIELD(fixture_part, store, KD_U32, NULL, "number in a store"),
    KD_FIELD(fixture_part, hidden, KD_BOOL, NULL, "not shown"),
};
static const kd_component_desc fixture_part_desc = {.name = "part",
                                                    .size = (uint32_t)sizeof(fixture_part),
                                                    .align = (uint32_t) _Alignof(fixture_part),
                                                    .fields = part_fields,
                                                    .field_count = 2};

/* What the runtime's own component of this name has of use to a scenario: clip 1 is "walk", 1 s long. */
typedef struct fixture_animation {
    uint32_t clip;
    float time_s, speed;
    uint8_t loop;
} fixture_animation;
static const kd_field animation_fields[] = {
    KD_FIELD(fixture_animation, clip, KD_U32, NULL, "clip"),
    KD_FIELD(fixture_animation, time_s, KD_F32, "s", "time in it"),
    KD_FIELD(fixture_animation, speed, KD_F32, NULL, "speed"),
    KD_FIELD(fixture_animation, loop, KD_BOOL, NULL, "again and again"),
};
static const kd_component_desc fixture_animation_desc = {.name = "animation",
                                                         .size = (uint32_t)sizeof(fixture_animation),
                                                         .align = (uint32_t) _Alignof(fixture_animation),
                                                         .fields = animation_fields,
                                                         .field_count = 4};

static const char *const *fixture_params; /* for the next load */
static uint32_t fixture_param_count;

static char fixture_message[2048];          /* the last error */
static char fixture_said[2048];             /* the last line printed by the scenario */
static bool (*fixture_stopped)(void *user); /* NULL: nobody stops it */
static int fixture_errors, fixture_infos;
static double fixture_time_limit_s; /* for the next load; 0: the usual */
static int fixture_spawns;
static char fixture_folder[64];
static kd_script_spawn fixture_spawned;
static char fixture_model[4096], fixture_played[64];

static inline void fixture_sink(void *user, kd_log_level level, const char *text)
{
    (void)user;
    snprintf(level == KD_LOG_ERROR ? fixture_message : fixture_said, sizeof fixture_message, "%s", text);
    fixture_errors += level == KD_LOG_ERROR;
    fixture_infos += level == KD_LOG_INFO;
}

static inline kd_status fixture_spawn(void *user, const kd_script_spawn *spawn, kd_entity *out,
                                      kd_script_error *error)
{
    kd_world *w = user;
    fixture_spawned = *spawn;
    fixture_spawns++;
    if (spawn->model && strstr(spawn->model, "slow"))
        nanosleep(&(struct timespec){.tv_sec = 1, .tv_nsec = 200000000}, NULL);
    if (spawn->model && strstr(spawn->model, "tired"))
        nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
    snprintf(fixture_model, sizeof fixture_model, "%s", spawn->model ? spawn->model : "");
    if (spawn->model && (strstr(spawn->model, "broken") || strstr(spawn->model, "tired"))) {
        snprintf(error->text, sizeof error->text, "%s: is broken; repair it", spawn->model);
        return KD_BAD_FORMAT;
    }
    bool bare = spawn->name && strcmp(spawn->name, "bare") == 0;
    *out = kd_spawn_values(w, (const kd_value[]){{&fixture_transform_desc, NULL}, {&fixture_part_desc, NULL}},
                           bare ? 1 : 2);
    kd_set_name(w, *out, spawn->name);
    return spawn->parent.generation ? kd_set_parent(w, *out, spawn->parent) : KD_OK;
}

static inline kd_status fixture_play(void *user, kd_entity entity, const kd_script_play *play,
                                     kd_script_error *error)
{
    (void)user;
    (void)entity;
    (void)error;
    snprintf(fixture_played, sizeof fixture_played, "%s %d %g %g", play->clip ? play->clip : "-", play->loop,
             (double)play->speed, (double)play->blend_s);
    size_t used = strlen(fixture_played);
    if (play->layer)
        snprintf(fixture_played + used, sizeof fixture_played - used, " layer %u %g %s", play->layer,
                 (double)play->weight,
                 play->stop   ? "stop"
                 : play->from ? play->from
                              : "-");
    return KD_OK;
}

static inline kd_status fixture_find_clip(void *user, kd_entity entity, const char *clip, uint32_t *number,
                                          float *length_s, kd_script_error *error)
{
    (void)user;
    (void)entity;
    *number = 1;
    *length_s = 1;
    if (strcmp(clip, "walk") == 0)
        return KD_OK;
    snprintf(error->text, sizeof error->text, "no clip '%s'; it has walk", clip);
    return KD_NOT_FOUND;
}

static inline bool fixture_may_write(void *user, const char *component, const char *field)
{
    (void)user;
    return strcmp(component, "part") != 0 || strcmp(field, "store") != 0;
}

static inline kd_world *fixture_world(void)
{
    kd_world *w = kd_world_make();
    kd_component_ensure(w, &fixture_transform_desc);
    kd_component_ensure(w, &fixture_light_desc);
    kd_component_ensure(w, &fixture_part_desc);
    kd_component_ensure(w, &fixture_animation_desc);
    return w;
}

static inline void fixture_write(const char *name, const void *data, size_t size)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", fixture_folder, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0)
        abort();
}

static inline int fixture_open(void **state)
{
    (void)state;
    strcpy(fixture_folder, "/tmp/kandil-script-XXXXXX");
    kd_log_set_sink(fixture_sink, NULL);
    return mkdtemp(fixture_folder) ? 0 : -1;
}

static inline int fixture_close(void **state)
{
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", fixture_folder);
    return system(command);
}

/* Load a scenario from text, with limits that a test can wait for. */
static inline kd_status fixture_load(kd_world *w, const char *text, kd_script **out)
{
    char path[128];
    fixture_write("scene.lua", text, strlen(text));
    snprintf(path, sizeof path, "%s/scene.lua", fixture_folder);
    fixture_message[0] = fixture_said[0] = '\0';
    fixture_errors = 0;
    return kd_script_load(&(kd_script_desc){.path = path,
                                            .params = fixture_params,
                                            .param_count = fixture_param_count,
                                            .seed = 42,
                                            .memory_limit = (size_t)32 << 20,
                                            .instruction_limit = 2000000,
                                            .time_limit_s = fixture_time_limit_s,
                                            .world = w,
                                            .host = {.user = w,
                                                     .spawn = fixture_spawn,
                                                     .play = fixture_play,
                                                     .find_clip = fixture_find_clip,
                                                     .may_write = fixture_may_write,
                                                     .stopped = fixture_stopped}},
                          out);
}

#endif
