/* Another scene, or the same from files that were written anew, in the place of the one that is on. The new
 * one is loaded, opened and has made its first frame before the old one goes: when any of that fails the old
 * one stays. Of a scenario alone that was written anew the first step suffices: then the world that is on is
 * filled by it, and all that the GPU has is used again. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/app/console.h"
#include "runtime/app/window/session.h"
#include "runtime/core/clock.h"
#include "runtime/core/log.h"

/* A scene that is loaded anew is brought to the frame that was on, if its steps take no longer than this. */
#define CATCH_UP_S 0.1

/* What a scenario registers stays with its world: now and then one is made anew whole. */
enum { MOST_RENEWALS = 16 };

/* ---- the scenes beside ---- */

static const char *const scene_extensions[] = {".lua", ".gltf", ".glb", NULL};

static bool is_scene(const char *name)
{
    for (int i = 0; scene_extensions[i]; i++)
        if (name[0] != '.' && kd_path_has_extension(name, scene_extensions[i]))
            return true;
    return false;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

void window_list_scenes(window_session *s)
{
    char folder[KD_PATH_MAX];
    for (uint32_t i = 0; i < s->scene_count; i++)
        free(s->scenes[i]);
    s->scene_count = 0;
    DIR *dir = kd_path_folder(folder, sizeof folder, s->subject) == KD_OK ? opendir(folder) : NULL;
    for (struct dirent *entry; dir && s->scene_count < WINDOW_MAX_SCENES && (entry = readdir(dir)) != NULL;) {
        char *name = is_scene(entry->d_name) ? strdup(entry->d_name) : NULL;
        if (name)
            s->scenes[s->scene_count++] = name;
    }
    if (dir)
        closedir(dir);
    qsort(s->scenes, s->scene_count, sizeof *s->scenes, by_name);
}

void window_next_scene(window_session *s, int by)
{
    uint32_t at = 0;
    window_list_scenes(s);
    while (at < s->scene_count && strcmp(s->scenes[at], kd_path_name(s->subject)) != 0)
        at++;
    if (s->scene_count)
        window_choose_scene(s, (at + s->scene_count + (uint32_t)by) % s->scene_count);
}

void window_choose_scene(window_session *s, uint32_t index)
{
    char folder[KD_PATH_MAX];
    if (kd_path_folder(folder, sizeof folder, s->subject) == KD_OK)
        (void)kd_path_join(s->next_subject, sizeof s->next_subject, folder, s->scenes[index]);
}

/* ---- what is watched ---- */

void window_watch_files(window_session *s)
{
    char folder[KD_PATH_MAX];
    const app_scene *scene = &s->stage->scene;
    const kd_scene_store *store = kd_singleton(scene->world, kd_scene_store);
    const char *shaders = getenv("KANDIL_SHADER_DIR");
    window_watch_clear(s->watch);
    window_watch_file(s->watch, s->subject, scene->script ? WINDOW_CHANGED_SCENARIO : WINDOW_CHANGED_MODEL);
    for (uint32_t i = 0; scene->script && i < kd_script_file_count(scene->script); i++)
        window_watch_file(s->watch, kd_script_file(scene->script, i), WINDOW_CHANGED_SCENARIO);
    for (uint32_t i = 0; i < scene->loaded_count; i++) {
        char path[KD_PATH_MAX];
        const char *key = scene->loaded[i].key; /* the path is its first line */
        if (strncmp(key, APP_SKY_PREFIX, strlen(APP_SKY_PREFIX)) == 0) {
            window_watch_file(s->watch, key + strlen(APP_SKY_PREFIX), WINDOW_CHANGED_MODEL);
            continue;
        }
        snprintf(path, sizeof path, "%.*s", (int)strcspn(key, "\n"), key);
        if (!is_scene(path))
            continue;
        const kd_model *model = store->models[scene->loaded[i].number].model;
        window_watch_file(s->watch, path, WINDOW_CHANGED_MODEL);
        for (uint32_t k = 0; k < model->file_count; k++)
            window_watch_file(s->watch, model->files[k], WINDOW_CHANGED_MODEL);
    }
    if (shaders && *shaders && kd_path_join(folder, sizeof folder, shaders, "shaders") == KD_OK)
        window_watch_tree(s->watch, folder, WINDOW_CHANGED_SHADERS);
}

/* What a load that fails asked for may be what is to be mended: it is watched until one comes on. */
static void watch_asked_for(void *user, const char *path)
{
    const window_session *s = user;
    window_watch_file(s->watch, path,
                      kd_path_has_extension(path, ".lua") ? WINDOW_CHANGED_SCENARIO : WINDOW_CHANGED_MODEL);
}

static kd_status load_watched(window_session *s, app_options options, const app_stage *beside,
                              app_stage **out)
{
    options.asked_for = watch_asked_for;
    options.asked_for_user = s;
    return app_stage_load(&options, s->desc->jobs, beside, out);
}

/* ---- switching ---- */

/* Another scene has other entities and parameters: of `--set` the settings alone are for it. */
static void keep_settings(app_options *o, const char **kept)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < o->set_count; i++)
        if (!app_is_param(o->sets[i]) && !app_is_entity_field(o->sets[i]))
            kept[count++] = o->sets[i];
    o->sets = kept;
    o->set_count = count;
}

/* What was chosen in the panels, where the command line did not choose. */
static void carry_over(const window_session *s, app_stage *to)
{
    to->scene.width = s->stage->scene.width;
    to->scene.height = s->stage->scene.height;
}

/* Run the steps of the frames that were on before, without pictures. Returns the frame that comes next. */
static uint64_t catch_up(app_stage *stage, uint64_t frame)
{
    uint64_t next = 1, began_ns = kd_clock_ns();
    app_stage_enable_gpu(stage, false);
    while (next < frame && (double)(kd_clock_ns() - began_ns) * 1e-9 < CATCH_UP_S &&
           app_stage_frame(stage, next) == KD_OK)
        next++;
    app_stage_enable_gpu(stage, true);
    return next;
}

static kd_status open_other(window_session *s, app_stage *other)
{
    carry_over(s, other);
    kd_status status = app_stage_open(other, &s->desc->reopen);
    return status == KD_OK ? app_stage_frame(other, 0) : status;
}

/* The other stage came to nothing; why was said. */
static void leave_out(window_session *s, app_stage *other)
{
    app_stage_close(other);
    kd_gpu_forgive(s->gpu);
    s->alarm = true;
    app_console_recover();
}

static void go_on_at(window_session *s, uint64_t frame)
{
    s->frame = frame;
    s->stopped = false;
    s->alarm = false;
    s->next_step_s = s->now_s;
    window_touch(s);
    window_watch_files(s);
}

/* Take the other stage on; `frame` is where its time is. */
static kd_status take_on(window_session *s, app_stage *other, uint64_t frame)
{
    window_stage_end(s);
    app_stage_close(s->stage);
    s->stage = other;
    s->stage->options = s->options;
    s->stage->scene.asked_for = NULL;
    s->profile_row = 0;
    s->renewals = 0;
    s->whole_due = false;
    go_on_at(s, frame);
    return window_stage_begin(s);
}

static void say_on(window_session *s, uint64_t began_ns)
{
    char said[KD_PATH_MAX + 64];
    snprintf(said, sizeof said, "%s is on, after %.0f ms", s->subject,
             (double)(kd_clock_ns() - began_ns) * 1e-6);
    window_note(s, false, said);
}

static kd_status change_scene(window_session *s, const char *subject)
{
    bool same = strcmp(subject, s->subject) == 0;
    const char **kept = calloc(s->desc->options->set_count + 1, sizeof *kept);
    app_options options = *s->desc->options;
    app_stage *other = NULL;
    if (!kept)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    if (strcmp(subject, options.subject) != 0)
        keep_settings(&options, kept);
    options.subject = subject;
    app_console_recover();
    uint64_t began_ns = kd_clock_ns(), frame = 1;
    kd_status status =
        same ? load_watched(s, options, NULL, &other) : app_stage_load(&options, s->desc->jobs, NULL, &other);
    if (status == KD_OK)
        status = open_other(s, other);
    if (status != KD_OK) {
        leave_out(s, other);
        free((void *)kept);
        return KD_OK;
    }
    if (same)
        frame = catch_up(other, s->frame);
    snprintf(s->subject, sizeof s->subject, "%s", subject);
    s->options = options;
    s->options.subject = s->subject;
    free((void *)s->kept_sets);
    s->kept_sets = kept;
    if (!same)
        s->camera.mode = WINDOW_CAMERA_FIXED;
    status = take_on(s, other, frame);
    say_on(s, began_ns);
    return status;
}

/* ---- the same world, filled anew ---- */

/* Settings that say how something is looked at: no system keeps anything that was made by them. */
static bool is_of_looks(const char *key)
{
    static const char *const groups[] = {"view.", "cones.", "ao.", "specular.", NULL};
    for (int i = 0; groups[i]; i++)
        if (strncmp(key, groups[i], strlen(groups[i])) == 0)
            return true;
    return false;
}

static bool same_settings(const kd_settings *a, const kd_settings *b)
{
    size_t count;
    const kd_setting_row *rows = kd_settings_rows(&count);
    for (size_t i = 0; i < count; i++)
        if (!is_of_looks(rows[i].key) && kd_settings_value(a, &rows[i]) != kd_settings_value(b, &rows[i]))
            return false;
    return true;
}

/* The steps from the first on, as the other scene has shown that they can be made. Its messages were said. */
static kd_status fill_anew(window_session *s)
{
    app_console_set_quiet(true);
    kd_status status = app_stage_renew(s->stage);
    app_stage_enable_gpu(s->stage, false);
    if (status == KD_OK)
        status = app_stage_frame(s->stage, 0);
    app_stage_enable_gpu(s->stage, true);
    app_console_set_quiet(s->desc->options->quiet);
    return status;
}

/* Make the first step without systems, whose components it may ask for nevertheless, as they are by default.
 */
static kd_status try_step(app_stage *trial, const app_stage *on)
{
    for (uint32_t id = 1; id <= kd_component_count(on->world); id++) {
        const kd_component_desc *desc = kd_component_info(on->world, id);
        (void)kd_component_ensure(trial->world, desc);
        if (kd_singleton_find(on->world, id))
            (void)kd_singleton_ensure(trial->world, desc);
    }
    return app_scene_step(&trial->scene, 0);
}

/* The scenario was written anew, its models were not. An extension may keep what we do not know of. */
static kd_status renew_scene(window_session *s)
{
    app_stage *trial = NULL;
    uint64_t began_ns = kd_clock_ns();
    app_console_recover();
    kd_status status = load_watched(s, s->options, s->stage, &trial);
    bool stays = status == KD_OK && !s->options.extension && !s->broken_shaders &&
                 s->renewals < MOST_RENEWALS &&
                 same_settings(&trial->scene.settings, &s->stage->scene.settings);
    if (status == KD_OK)
        status = stays ? try_step(trial, s->stage) : open_other(s, trial);
    if (status != KD_OK) {
        leave_out(s, trial);
        return KD_OK;
    }
    if (!stays) {
        status = take_on(s, trial, catch_up(trial, s->frame));
        say_on(s, began_ns);
        return status;
    }
    app_stage_close(trial);
    s->chosen = KD_NO_ENTITY;
    s->renewals++;
    if (fill_anew(s) != KD_OK) {
        s->whole_due = true;
        return change_scene(s, s->subject);
    }
    go_on_at(s, catch_up(s->stage, s->frame));
    say_on(s, began_ns);
    return KD_OK;
}

/* ---- shaders ---- */

/* Passes that make the picture from what is there; all others leave something behind for the next frame. */
static bool is_drawn_anew(const char *path)
{
    static const char *const folders[] = {"shaders/resolve/",  "shaders/cone_trace/", "shaders/debug_view/",
                                          "shaders/deferred/", "shaders/ui/",         NULL};
    for (int i = 0; folders[i]; i++)
        if (strncmp(path, folders[i], strlen(folders[i])) == 0)
            return true;
    return false;
}

static void note_program(void *user, const char *path)
{
    bool *whole = user;
    *whole = *whole || !is_drawn_anew(path);
}

static void reload_shaders(window_session *s)
{
    char said[96];
    bool whole = false;
    uint32_t changed = 0;
    uint64_t began_ns = kd_clock_ns();
    app_console_recover();
    kd_status status = kd_gpu_reload_programs(s->gpu, note_program, &whole, &changed);
    app_console_recover();
    s->broken_shaders = status != KD_OK;
    s->alarm = s->broken_shaders || s->stopped;
    whole = whole || (s->stopped && !s->broken_shaders);
    if (changed) {
        snprintf(said, sizeof said, "%u shader programs made anew in %.0f ms", changed,
                 (double)(kd_clock_ns() - began_ns) * 1e-6);
        window_note(s, false, said);
    }
    s->reload_asked = s->reload_asked || whole;
    window_touch(s);
}

kd_status window_switch(window_session *s)
{
    char subject[KD_PATH_MAX];
    if (s->frame == 0 && !s->stopped)
        return KD_OK;
    uint32_t changes = window_watch_poll(s->watch, s->now_s);
    if (changes & WINDOW_CHANGED_SHADERS)
        reload_shaders(s);
    bool other = s->next_subject[0] != '\0', whole = s->reload_asked || (changes & WINDOW_CHANGED_MODEL);
    s->whole_due = s->whole_due || whole;
    if (!other && !whole && !(changes & WINDOW_CHANGED_SCENARIO))
        return KD_OK;
    snprintf(subject, sizeof subject, "%s", other ? s->next_subject : s->subject);
    s->next_subject[0] = '\0';
    s->reload_asked = false;
    if (s->desc->options->output_count || s->desc->options->trace_count) {
        window_note(s, true, "the scene stays: what is written of it (--out, --profile FILE) has begun");
        return KD_OK;
    }
    return other || s->whole_due ? change_scene(s, subject) : renew_scene(s);
}
