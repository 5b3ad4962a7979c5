#include "runtime/app/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/film.h"
#include "components/animation.h"
#include "components/camera.h"
#include "components/light.h"
#include "components/mesh_instance.h"
#include "components/sky.h"
#include "components/transform.h"
#include "runtime/app/world_setup.h"
#include "runtime/asset/sky_image.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/ecs/query.h"
#include "runtime/ecs/reflect.h"
#include "runtime/ecs/system.h"

#define TURN_DEG_PER_S 30.0

/* ---- what was loaded ---- */

static const app_loaded *find_key(const app_scene *scene, const char *key)
{
    for (uint32_t i = 0; i < scene->loaded_count; i++)
        if (strcmp(scene->loaded[i].key, key) == 0)
            return &scene->loaded[i];
    return NULL;
}

bool app_scene_find_loaded(app_scene *scene, const char *key, uint32_t *out)
{
    const app_loaded *known = find_key(scene, key);
    const app_loaded *other = !known && scene->beside ? find_key(scene->beside, key) : NULL;
    if (known)
        *out = known->number;
    if (known || !other)
        return known != NULL;
    const kd_scene_store *store = kd_singleton(scene->beside->world, kd_scene_store);
    kd_model *model = kd_model_share((kd_model *)(uintptr_t)store->models[other->number].model);
    if (kd_scene_add_model(scene->world, model, out) != KD_OK) {
        kd_model_destroy(model);
        return false;
    }
    return app_scene_add_loaded(scene, key, *out) == KD_OK;
}

kd_status app_scene_add_loaded(app_scene *scene, const char *key, uint32_t number)
{
    if (scene->loaded_count == scene->loaded_capacity) {
        uint32_t capacity = scene->loaded_capacity ? scene->loaded_capacity * 2 : 16;
        app_loaded *grown = realloc(scene->loaded, capacity * sizeof *grown);
        if (!grown)
            return kd_fail(KD_NO_MEMORY, "out of memory");
        scene->loaded = grown;
        scene->loaded_capacity = capacity;
    }
    char *copy = strdup(key);
    if (!copy)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    scene->loaded[scene->loaded_count++] = (app_loaded){copy, number};
    return KD_OK;
}

static kd_status load_model(app_scene *scene, const char *path, const kd_model_options *options,
                            uint32_t *out)
{
    kd_model *model;
    kd_status status = kd_model_load_with(path, options, &model);
    if (status != KD_OK)
        return status;
    for (uint32_t i = 0; i < model->warning_count; i++)
        kd_log(KD_LOG_WARNING, "%s: %s", path, model->warnings[i]);
    status = kd_scene_add_model(scene->world, model, out);
    if (status != KD_OK)
        kd_model_destroy(model);
    return status;
}

kd_status app_scene_model(app_scene *scene, const char *path, const kd_model_options *wanted, uint32_t *out)
{
    kd_model_options options = *wanted;
    options.subdiv_level = (uint32_t)scene->settings.subdiv_level;
    const char *part = options.scene ? options.scene : "", *variant = options.variant ? options.variant : "";
    size_t size = strlen(path) + strlen(part) + strlen(variant) + 16;
    char *key = malloc(size);
    if (!key)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    snprintf(key, size, "%s\n%s\n%s\n%u", path, part, variant, options.subdiv_level);
    bool known = app_scene_find_loaded(scene, key, out);
    kd_status status = known ? KD_OK : load_model(scene, path, &options, out);
    if (!known && status == KD_OK)
        status = app_scene_add_loaded(scene, key, *out);
    free(key);
    return status;
}

/* Half a gigabyte of pictures. A file of a few colours is small whatever its picture's size. */
#define SKY_BYTES_MAX ((uint64_t)512 << 20)

static uint64_t sky_bytes(const kd_sky_images *images)
{
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < images->count; i++)
        bytes += (uint64_t)images->maps[i].width * images->maps[i].height * 3 * sizeof(float);
    return bytes;
}

static kd_status load_sky(kd_world *w, const char *path, uint32_t *out)
{
    kd_sky_image image;
    kd_status status = kd_sky_image_load(path, &image);
    if (status != KD_OK)
        return status;
    uint64_t own = (uint64_t)image.width * image.height * 3 * sizeof(float);
    if (sky_bytes(kd_singleton(w, kd_sky_images)) + own > SKY_BYTES_MAX) {
        kd_sky_image_fini(&image);
        return kd_fail(KD_TOO_LARGE,
                       "%s: all pictures of skies together take more than %u MiB; use fewer or smaller ones",
                       path, (unsigned)(SKY_BYTES_MAX >> 20));
    }
    *out = kd_sky_add_image(w, (kd_sky_map){image.width, image.height, image.rgb});
    kd_sky_find_sun(w, *out);
    return *out ? KD_OK : kd_fail(KD_NO_MEMORY, "%s: no memory for it; use a smaller picture", path);
}

kd_status app_scene_sky(app_scene *scene, const char *path, uint32_t *out)
{
    char key[KD_PATH_MAX + sizeof APP_SKY_PREFIX];
    snprintf(key, sizeof key, APP_SKY_PREFIX "%s", path);
    const app_loaded *known = find_key(scene, key);
    if (known) {
        *out = known->number;
        return KD_OK;
    }
    kd_status status = load_sky(scene->world, path, out);
    return status == KD_OK ? app_scene_add_loaded(scene, key, *out) : status;
}

/* ---- what may be set ---- */

bool app_may_write(const char *component, const char *field)
{
    static const char *const own[] = {"local_matrix",
                                      "world_transform",
                                      "mesh_instance",
                                      "skin_instance",
                                      "morph_weights",
                                      "animation",
                                      "view",
                                      "free_camera",
                                      "frame",
                                      "film",
                                      "film_layers",
                                      "motion",
                                      "gbuffer",
                                      "lighting",
                                      "gi_targets",
                                      "picture",
                                      "tree",
                                      "svo",
                                      "voxel_scene",
                                      "animation_layers",
                                      NULL};
    static const char *const fields[] = {"animation.time_s",        "animation.speed",
                                         "animation.loop",          "animation.paused",
                                         "morph_weights.weights",   "mesh_instance.hidden",
                                         "mesh_instance.no_shadow", "mesh_instance.no_voxels",
                                         "animation_layers.time_s", "animation_layers.speed",
                                         "animation_layers.weight", "animation_layers.target",
                                         "animation_layers.fade_s", NULL};
    size_t length = strlen(component);
    for (size_t i = 0; fields[i]; i++)
        if (strncmp(fields[i], component, length) == 0 && fields[i][length] == '.' &&
            strcmp(fields[i] + length + 1, field) == 0)
            return true;
    return app_find_word(own, component) < 0;
}

/* Apply NAME.component.field=VALUE. */
static kd_status set_entity_field(kd_world *w, const char *assignment)
{
    kd_entity entity;
    kd_field_ref ref;
    size_t length = strcspn(assignment, "=");
    char *path = strndup(assignment, length);
    if (!path)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = kd_entity_field_resolve(w, path, &entity, &ref);
    if (status == KD_OK && !app_may_write(ref.desc->name, ref.field->name))
        status = kd_fail(KD_USAGE, "--set %s: this field is the runtime's own; it cannot be set", path);
    else if (status == KD_OK)
        status = kd_field_write_text(w, entity, &ref, assignment + length + 1);
    free(path);
    return status == KD_OK || status == KD_NO_MEMORY ? status : KD_USAGE;
}

/* ---- loading ---- */

/* The command line is applied before loading, so that framing knows size and settings, and after it, since it
 * has the last word over a scenario; entities exist only then. */
static kd_status apply_options(app_scene *scene, const app_options *o, bool loaded)
{
    kd_status status = KD_OK;
    if (o->width) {
        scene->width = o->width;
        scene->height = o->height;
    }
    scene->fps = o->fps > 0 ? o->fps : scene->fps;
    scene->gi = o->gi >= 0 ? (uint32_t)o->gi : scene->gi;
    scene->view = o->view >= 0 ? (uint32_t)o->view : scene->view;
    for (uint32_t i = 0; i < o->set_count && status == KD_OK; i++) {
        if (app_is_param(o->sets[i])) {
            if (!kd_path_has_extension(o->subject, ".lua"))
                status = kd_fail(KD_USAGE, "--set %s: only scenarios have parameters; give a .lua file",
                                 o->sets[i]);
        } else if (!app_is_entity_field(o->sets[i]))
            status = kd_settings_set(&scene->settings, o->sets[i]);
        else if (loaded)
            status = set_entity_field(scene->world, o->sets[i]);
    }
    return status;
}

static app_scene begin(kd_world *world)
{
    return (app_scene){.world = world,
                       .width = 640,
                       .height = 360,
                       .fps = 30,
                       .seconds = -1,
                       .settings = kd_settings_defaults()};
}

static kd_status fill(app_scene *scene, const app_options *options)
{
    kd_status status = apply_options(scene, options, false);
    if (status != KD_OK)
        return status;
    if (kd_path_has_extension(options->subject, ".lua"))
        status = app_scene_load_script(scene, options);
    else if (kd_path_has_extension(options->subject, ".gltf") ||
             kd_path_has_extension(options->subject, ".glb"))
        status = app_scene_load_model(scene, options);
    else
        status =
            kd_fail(KD_USAGE, "%s: unknown kind of scene; give a .lua, .gltf or .glb file", options->subject);
    if (status == KD_OK)
        status = apply_options(scene, options, true);
    return status;
}

kd_status app_scene_load(app_scene *scene, kd_world *world, const app_options *options,
                         const app_scene *beside)
{
    *scene = begin(world);
    scene->beside = beside;
    app_register_components(world, options->extension);
    kd_status status = fill(scene, options);
    scene->beside = NULL;
    return status;
}

static kd_status destroy_all(kd_world *w)
{
    kd_query *all = kd_query_make(w, &(kd_query_desc){.terms = {KD_OPTIONAL(kd_transform)}, .name = "scene"});
    uint32_t count = kd_entity_count(w), found = 0;
    kd_entity *entities = calloc(count + 1u, sizeof *entities);
    if (all && entities) {
        for (kd_iter it = kd_query_iter(all); kd_iter_next(&it);)
            for (uint32_t i = 0; i < it.count && found < count; i++)
                entities[found++] = it.entities[i];
        for (uint32_t i = 0; i < found; i++)
            kd_destroy(w, entities[i]);
    }
    free(entities);
    if (all)
        kd_query_destroy(all);
    return kd_entity_count(w) ? kd_fail(KD_NO_MEMORY, "out of memory") : KD_OK;
}

kd_status app_scene_renew(app_scene *scene, const app_options *options)
{
    const app_scene before = *scene;
    kd_schedule_clock *clock = kd_singleton(scene->world, kd_schedule_clock);
    kd_script_destroy(before.script);
    *scene = begin(before.world);
    scene->loaded = before.loaded;
    scene->loaded_count = before.loaded_count;
    scene->loaded_capacity = before.loaded_capacity;
    clock->time_s = 0;
    clock->frame = 0;
    kd_status status = destroy_all(scene->world);
    kd_scene_restore_materials(scene->world);
    return status == KD_OK ? fill(scene, options) : status;
}

uint64_t app_scene_frames(const app_scene *scene, const app_options *o)
{
    double seconds = o->seconds >= 0 ? o->seconds : scene->seconds >= 0 ? scene->seconds : 4;
    if (o->frames >= 0)
        return (uint64_t)o->frames;
    if (o->seconds < 0 && !scene->script) { /* a bare model: a film's or sequence's worth, else one picture */
        for (uint32_t i = 0; i < o->output_count; i++)
            if (o->outputs[i].every_frame)
                return 48;
        return 1;
    }
    return (uint64_t)llround(seconds * scene->fps);
}

/* ---- stepping ---- */

static void turn(const app_scene *scene, double time_s)
{
    kd_transform *t = kd_find_mut(scene->world, scene->turntable, kd_transform);
    double half = fmod(TURN_DEG_PER_S * time_s, 360.0) * 0.5 * 3.14159265358979323846 / 180.0;
    if (t)
        t->rotation = (kd_quat){0, (float)sin(half), 0, (float)cos(half)};
}

void app_scene_show(const app_scene *scene, uint64_t index)
{
    kd_frame *frame = kd_singleton(scene->world, kd_frame);
    uint32_t scale = kd_film_scale(kd_singleton(scene->world, kd_film));
    frame->index = index;
    frame->time_s = (double)index / scene->fps;
    frame->dt_s = (float)(1 / scene->fps);
    frame->width = scene->width * scale;
    frame->height = scene->height * scale;
    frame->gi = scene->gi;
    frame->view = scene->view;
    frame->settings = scene->settings;
}

kd_status app_scene_step(app_scene *scene, uint64_t index)
{
    double time_s = (double)index / scene->fps;
    scene->started = true;
    app_scene_show(scene, index);
    if (scene->turntable.generation)
        turn(scene, time_s);
    return scene->script ? kd_script_step(scene->script, time_s, 1 / scene->fps) : KD_OK;
}

void app_scene_fini(app_scene *scene)
{
    kd_script_destroy(scene->script);
    for (uint32_t i = 0; i < scene->loaded_count; i++)
        free(scene->loaded[i].key);
    free(scene->loaded);
    *scene = (app_scene){0};
}
