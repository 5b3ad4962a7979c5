/* The host of a scenario: makes models, shapes and materials when kandil.spawn asks for them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/animation.h"
#include "components/mesh_instance.h"
#include "components/sky.h"
#include "components/transform.h"
#include "runtime/app/console.h"
#include "runtime/app/interrupt.h"
#include "runtime/app/scene.h"
#include "runtime/core/log.h"

/* ---- limits: a few lines can ask for millions, which no frame would ever show ---- */

static bool stopped(void *user)
{
    (void)user;
    return app_interrupted();
}

/* Tell whether `more` entities may come. Who interrupts is answered between two of them too. */
static kd_status check_room(const app_scene *scene, uint64_t more)
{
    uint64_t limit = (uint64_t)scene->settings.script_entities;
    if (app_interrupted())
        return kd_fail(KD_INTERRUPTED, "interrupted");
    if (kd_entity_count(scene->world) + more <= limit)
        return KD_OK;
    return kd_fail(
        KD_TOO_LARGE,
        "more than %llu entities would be in the scene; make fewer, or say --set script.entities=…",
        (unsigned long long)limit);
}

/* Count an entity and what hangs below it, to `most` at most. */
static uint64_t count_below(const kd_world *w, kd_entity top, uint64_t most)
{
    uint64_t count = 1;
    kd_entity at = top;
    while (count < most) {
        kd_entity next = kd_first_child(w, at);
        while (!next.generation && at.index != top.index) {
            next = kd_next_sibling(w, at);
            at = next.generation ? at : kd_get_parent(w, at);
        }
        if (!next.generation)
            break;
        at = next;
        count++;
    }
    return count;
}

/* ---- host calls: what fails below logs its reason, which is caught and given to the scenario ---- */

static kd_status set_scene(void *user, const kd_script_scene *said, kd_script_error *error)
{
    app_scene *scene = user;
    int gi = said->gi ? app_find_word(app_gi_words, said->gi) : (int)scene->gi;
    int view = said->view ? app_find_word(app_view_words, said->view) : (int)scene->view;
    if (scene->started)
        snprintf(error->text, sizeof error->text, "comes too late; call it while the scenario loads");
    else if (gi < 0)
        snprintf(error->text, sizeof error->text, "gi cannot be '%.64s'; choose cones or none", said->gi);
    else if (view < 0)
        snprintf(error->text, sizeof error->text, "view cannot be '%.64s'; `kandil help run` lists the views",
                 said->view);
    if (error->text[0])
        return KD_SCRIPT;
    if (said->width) {
        scene->width = said->width;
        scene->height = said->height;
    }
    scene->fps = said->fps > 0 ? said->fps : scene->fps;
    scene->seconds = said->seconds > 0 ? said->seconds : scene->seconds;
    scene->gi = (uint32_t)gi;
    scene->view = (uint32_t)view;
    return KD_OK;
}

static kd_status set_setting(void *user, const char *assignment, kd_script_error *error)
{
    app_scene *scene = user;
    app_console_capture(error->text, sizeof error->text);
    int32_t entities = scene->settings.script_entities;
    kd_status status = kd_settings_set(&scene->settings, assignment);
    if (scene->settings.script_entities > entities && scene->settings.script_entities > scene->entities_max) {
        scene->settings.script_entities = entities;
        status = kd_fail(KD_OUT_OF_RANGE,
                         "script.entities may be lowered here, but not raised above %d; say --set "
                         "script.entities=… on the command line",
                         (int)scene->entities_max);
    }
    app_console_capture(NULL, 0);
    return status;
}

static kd_material_desc material_of(const kd_script_material *said)
{
    kd_material_desc m = kd_material_default();
    m.base_color = said->base_color;
    m.alpha_mode = said->base_color.w < 1 || said->transmission > 0 ? KD_ALPHA_BLEND : KD_ALPHA_OPAQUE;
    m.metallic = said->metallic;
    m.roughness = said->roughness;
    m.emissive = said->emissive;
    m.double_sided = said->double_sided;
    m.unlit = said->unlit;
    m.ior = said->ior;
    m.specular = said->specular;
    m.clearcoat = said->clearcoat;
    m.clearcoat_roughness = said->clearcoat_roughness;
    m.transmission = said->unlit ? 0 : said->transmission;
    return m;
}

static kd_shape shape_of(const char *word)
{
    static const char *const words[] = {"box", "sphere", "plane", "cylinder", "torus", NULL};
    static const kd_shape shapes[] = {KD_SHAPE_BOX, KD_SHAPE_SPHERE, KD_SHAPE_PLANE, KD_SHAPE_CYLINDER,
                                      KD_SHAPE_TORUS};
    int i = app_find_word(words, word);
    return shapes[i < 0 ? 0 : i];
}

/* Half a gigabyte of meshes. A file pays for its triangles by its size; a shape of millions is one line. */
enum { SHAPE_TRIANGLES_MAX = 4194304 };

/* Register a shape with its material; equal ones share an entry, and so their mesh and its voxels. */
static kd_status ensure_shape(app_scene *scene, const kd_script_spawn *spawn, uint32_t *out)
{
    char key[512];
    const kd_script_mesh *s = &spawn->mesh;
    const kd_script_material *m = &spawn->material;
    snprintf(key, sizeof key, "mesh:%s %a %a %a %u : %a %a %a %a %a %a %a %a %a %d%d %a %a %a %a %a",
             s->shape, (double)s->size.x, (double)s->size.y, (double)s->size.z, s->segments,
             (double)m->base_color.x, (double)m->base_color.y, (double)m->base_color.z,
             (double)m->base_color.w, (double)m->metallic, (double)m->roughness, (double)m->emissive.x,
             (double)m->emissive.y, (double)m->emissive.z, m->double_sided, m->unlit, (double)m->ior,
             (double)m->specular, (double)m->clearcoat, (double)m->clearcoat_roughness,
             (double)m->transmission);
    if (app_scene_find_loaded(scene, key, out))
        return KD_OK;
    kd_model *model;
    kd_material_desc material = material_of(m);
    kd_status status = kd_model_make_shape(shape_of(s->shape), s->size, s->segments, &material, &model);
    if (status != KD_OK)
        return status;
    scene->shape_triangles += model->triangle_count;
    if (scene->shape_triangles > SHAPE_TRIANGLES_MAX) {
        kd_model_destroy(model);
        return kd_fail(
            KD_TOO_LARGE,
            "all shapes together have more than %d triangles; give them fewer segments, or the same "
            "size and material, which share one",
            SHAPE_TRIANGLES_MAX);
    }
    status = kd_scene_add_model(scene->world, model, out);
    if (status != KD_OK) {
        kd_model_destroy(model);
        return status;
    }
    return app_scene_add_loaded(scene, key, *out);
}

static kd_status spawn_plain(app_scene *scene, const kd_script_spawn *spawn, kd_entity *out)
{
    kd_world *w = scene->world;
    *out = kd_spawn(w, KD_TAG(kd_transform), KD_TAG(kd_world_transform));
    if (!out->generation)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = kd_set_name(w, *out, spawn->name);
    if (status == KD_OK && spawn->parent.generation)
        status = kd_set_parent(w, *out, spawn->parent);
    return status;
}

/* A shape is one entity to its scenario: its only node's mesh moves to the root. */
static kd_status join_shape(kd_world *w, kd_entity root)
{
    kd_entity node = kd_first_child(w, root);
    const kd_mesh_instance *mesh = kd_find(w, node, kd_mesh_instance);
    if (!mesh)
        return KD_OK;
    kd_mesh_instance copy = *mesh;
    kd_destroy(w, node);
    return kd_set_value(w, root, (kd_value){&kd_mesh_instance_desc, &copy});
}

/* A model stands still until its scenario lets it play. */
static void stop_clips(kd_world *w, kd_entity root)
{
    kd_animation *animation = kd_find_mut(w, root, kd_animation);
    if (animation)
        animation->clip = 0;
}

static kd_status spawn_model(app_scene *scene, const kd_script_spawn *spawn, kd_entity *out)
{
    uint32_t model;
    const char *name = spawn->name ? spawn->name : "";
    const kd_model_options options = {.scene = spawn->model_scene,
                                      .variant = spawn->variant,
                                      .roots = spawn->roots,
                                      .root_count = spawn->root_count};
    kd_status status = spawn->model ? app_scene_model(scene, spawn->model, &options, &model)
                                    : ensure_shape(scene, spawn, &model);
    if (status == KD_OK)
        status = check_room(
            scene, 1ull + kd_singleton(scene->world, kd_scene_store)->models[model].model->node_count);
    if (status == KD_OK)
        status = kd_scene_instantiate(scene->world, model, spawn->parent, name, out);
    if (status == KD_OK && !spawn->model)
        status = join_shape(scene->world, *out);
    if (status == KD_OK && spawn->model)
        stop_clips(scene->world, *out);
    if (status == KD_OK && spawn->model && spawn->material.given) {
        kd_material_desc material = material_of(&spawn->material);
        kd_scene_override_material(scene->world, *out, kd_scene_add_material(scene->world, &material));
    }
    return status;
}

/* A picture round the scene; what the scenario says of its sky follows. */
static kd_status add_sky(app_scene *scene, const char *path, kd_entity e)
{
    kd_sky sky = *(const kd_sky *)kd_sky_desc.default_value;
    kd_status status = app_scene_sky(scene, path, &sky.image);
    if (status != KD_OK)
        return status;
    return kd_set_value(scene->world, e, (kd_value){&kd_sky_desc, &sky});
}

static kd_status spawn_any(void *user, const kd_script_spawn *spawn, kd_entity *out, kd_script_error *error)
{
    app_scene *scene = user;
    app_console_capture(error->text, sizeof error->text);
    bool plain = !spawn->model && !spawn->mesh.shape;
    kd_status status = check_room(scene, 1);
    if (status == KD_OK)
        status = plain ? spawn_plain(scene, spawn, out) : spawn_model(scene, spawn, out);
    if (status == KD_OK && spawn->sky_image)
        status = add_sky(scene, spawn->sky_image, *out);
    app_console_capture(NULL, 0);
    return status;
}

static kd_status play(void *user, kd_entity entity, const kd_script_play *p, kd_script_error *error)
{
    app_scene *scene = user;
    app_console_capture(error->text, sizeof error->text);
    kd_status status = p->layer ? kd_scene_play_layer(scene->world, entity,
                                                      &(kd_scene_layer){.layer = p->layer,
                                                                        .clip = p->stop   ? NULL
                                                                                : p->clip ? p->clip
                                                                                          : "",
                                                                        .from = p->from,
                                                                        .loop = p->loop,
                                                                        .speed = p->speed,
                                                                        .weight = p->weight,
                                                                        .blend_s = p->blend_s})
                                : kd_scene_play(scene->world, entity, p->clip, p->loop, p->speed, p->blend_s);
    app_console_capture(NULL, 0);
    return status;
}

static kd_status find_clip(void *user, kd_entity entity, const char *clip, uint32_t *number, float *length_s,
                           kd_script_error *error)
{
    app_scene *scene = user;
    app_console_capture(error->text, sizeof error->text);
    kd_status status = kd_scene_find_clip(scene->world, entity, clip, number, length_s);
    app_console_capture(NULL, 0);
    return status;
}

static kd_status clone(void *user, kd_entity entity, kd_entity parent, kd_entity *out, kd_script_error *error)
{
    app_scene *scene = user;
    app_console_capture(error->text, sizeof error->text);
    kd_status status =
        check_room(scene, count_below(scene->world, entity, (uint64_t)scene->settings.script_entities + 1));
    if (status == KD_OK)
        status = kd_scene_clone(scene->world, entity, parent, out);
    app_console_capture(NULL, 0);
    return status;
}

static void asked_for(void *user, const char *path)
{
    const app_scene *scene = user;
    if (scene->asked_for)
        scene->asked_for(scene->asked_for_user, path);
}

static bool may_write(void *user, const char *component, const char *field)
{
    (void)user;
    return app_may_write(component, field);
}

kd_status app_scene_load_script(app_scene *scene, const app_options *options)
{
    scene->asked_for = options->asked_for;
    scene->asked_for_user = options->asked_for_user;
    const char **params = calloc(options->set_count + 1, sizeof *params);
    uint32_t param_count = 0;
    if (!params)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    for (uint32_t i = 0; i < options->set_count; i++)
        if (app_is_param(options->sets[i]))
            params[param_count++] = options->sets[i] + strlen(APP_PARAM_PREFIX);
    scene->entities_max = scene->settings.script_entities;
    kd_status status = kd_script_load(
        &(kd_script_desc){
            .path = options->subject,
            .roots = options->roots,
            .root_count = options->root_count,
            .params = params,
            .param_count = param_count,
            .seed = options->seed,
            .world = scene->world,
            .host = {.user = scene,
                     .scene = set_scene,
                     .set = set_setting,
                     .spawn = spawn_any,
                     .play = play,
                     .find_clip = find_clip,
                     .clone = clone,
                     .may_write = may_write,
                     .asked_for = asked_for,
                     .stopped = stopped},
        },
        &scene->script);
    free(params);
    return status;
}
