/* One table row an option: its name, its value's name in the help, its reader. A reader checks everything
 * that can be checked before the work begins. */
#include "runtime/app/options.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components/frame.h"
#include "runtime/app/options_read.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/ecs/world.h"
#include "runtime/reference/reference.h"

#define MAX_SIZE    16384
#define MAX_FRAMES  100000000
#define MAX_BENCH_N 50000000

/* Lists of words, for the readers and for the help. */
/* clang-format off */
#define GI_LIST(X) X("cones") X("none")
#define VIEW_LIST(X)                                                                                         \
    X("final") X("direct") X("indirect") X("ao") X("specular") X("albedo") X("normal") X("depth") X("light") \
    X("caches") X("pages") X("octree") X("lookup") X("cost")
#define CONTEXT_LIST(X)                                                                                      \
    X("auto") X("glfw") X("egl") X("egl-device") X("egl-surfaceless") X("egl-software") X("osmesa")
#define TERM_LIST(X)                                                                                         \
    X("final") X("direct") X("indirect") X("diffuse") X("specular") X("ao") X("albedo") X("normal")          \
    X("depth")
/* clang-format on */
#define WORD(word)   word,
#define SPACED(word) " " word

const char *const app_gi_words[] = {GI_LIST(WORD) NULL};
const char *const app_view_words[] = {VIEW_LIST(WORD) NULL};
_Static_assert(sizeof app_view_words / sizeof *app_view_words == KD_VIEW_MODE_COUNT + 1,
               "a view lacks its word");

const char *const app_term_words[] = {TERM_LIST(WORD) NULL};
_Static_assert(sizeof app_term_words / sizeof *app_term_words == KD_REFERENCE_TERM_COUNT + 1,
               "a term lacks its word");

const char *const app_context_words[] = {CONTEXT_LIST(WORD) NULL};
_Static_assert(sizeof app_context_words / sizeof *app_context_words == KD_CONTEXT_API_COUNT + 1,
               "a context lacks its word");

const app_command_row app_commands[] = {
    {"run", APP_RUN, "SCENE", "render a scenario (.lua) or a model (.gltf, .glb)"},
    {"reference", APP_REFERENCE, "SCENE", "path trace a scenario or a model: what the picture should be"},
    {"compare", APP_COMPARE, "SCENE|PICTURE REFERENCE",
     "measure techniques against the path traced picture, or one picture against another"},
    {"voxelize", APP_VOXELIZE, "SCENE", "write the voxels of a model or a scenario to a .kvox file"},
    {"info", APP_INFO, "FILE", "list what a model or a .kvox file holds"},
    {"bench", APP_BENCH, "[ecs|jobs|voxels|svo|all] [SCENE]",
     "measure the ECS, the jobs or the voxel scene beside this machine's limits"},
    {"doctor", APP_DOCTOR, NULL, "list every way to a GPU or software driver, and what is missing"},
    {"help", APP_HELP, "[COMMAND]", "explain the program, a command, `settings` or `scenario`"},
    {NULL, APP_HELP, NULL, NULL},
};

/* ---- readers ---- */

static kd_status read_frames(app_options *o, const char *text)
{
    return app_read_integer("--frames", text, 0, MAX_FRAMES, &o->frames);
}

static kd_status read_seconds(app_options *o, const char *text)
{
    return app_read_real("--seconds", text, 0, 1e6, &o->seconds);
}

static kd_status read_fps(app_options *o, const char *text)
{
    return app_read_real("--fps", text, 0.001, 10000, &o->fps);
}

static kd_status read_size(app_options *o, const char *text)
{
    char *x, *end;
    long width = strtol(text, &x, 10), height = *x == 'x' ? strtol(x + 1, &end, 10) : 0;
    if (!isdigit((unsigned char)*text) || *x != 'x' || !isdigit((unsigned char)x[1]) || *end)
        return kd_fail(KD_USAGE, "--size: '%s' is not of the form WIDTHxHEIGHT; write it like 640x360", text);
    if (width < 1 || height < 1 || width > MAX_SIZE || height > MAX_SIZE)
        return kd_fail(KD_USAGE, "--size: %s is out of range; each side may have 1 to %d pixels", text,
                       MAX_SIZE);
    o->width = (uint32_t)width;
    o->height = (uint32_t)height;
    return KD_OK;
}

static kd_status read_seed(app_options *o, const char *text)
{
    int64_t value = 0;
    kd_status status = app_read_integer("--seed", text, 0, INT64_MAX, &value);
    o->seed = (uint64_t)value;
    return status;
}

static kd_status read_threads(app_options *o, const char *text)
{
    int64_t value = 0;
    kd_status status = app_read_integer("--threads", text, 0, KD_MAX_WORKERS, &value);
    o->threads = (uint32_t)value;
    return status;
}

/* Check the number in a path such as shot_%04d.png: one conversion, of an integer, at most nine digits wide.
 */
static kd_status check_pattern(const char *path, bool *is_pattern)
{
    const char *percent = strchr(path, '%'), *p = percent ? percent + 1 : NULL;
    *is_pattern = percent != NULL;
    if (!percent)
        return KD_OK;
    if (*p == '0')
        p++;
    if (isdigit((unsigned char)*p))
        p++;
    if (*p != 'd' || strchr(p, '%'))
        return kd_fail(KD_USAGE, "--out: %s: a pattern has one frame number such as %%04d; correct it", path);
    return KD_OK;
}

static kd_status read_out(app_options *o, const char *text)
{
    app_output output = {0};
    kd_status status = app_read_path("--out", text, &output.path);
    if (status == KD_OK)
        status = check_pattern(text, &output.every_frame);
    if (status != KD_OK)
        return status;
    if (kd_path_has_extension(text, ".png"))
        output.kind = APP_OUTPUT_PNG;
    else if (kd_path_has_extension(text, ".exr"))
        output.kind = APP_OUTPUT_EXR;
    else if (kd_path_has_extension(text, ".mp4") || kd_path_has_extension(text, ".webm"))
        output.kind = APP_OUTPUT_FILM;
    else
        return kd_fail(KD_USAGE, "--out: %s: unknown kind of file; end the name in .png, .exr, .mp4 or .webm",
                       text);
    if (output.kind == APP_OUTPUT_FILM && output.every_frame)
        return kd_fail(KD_USAGE, "--out: %s: a film is one file; leave the frame number out", text);
    output.every_frame = output.every_frame || output.kind == APP_OUTPUT_FILM;
    for (uint32_t i = 0; i < o->output_count; i++)
        if (strcmp(o->outputs[i].path, text) == 0)
            return kd_fail(KD_USAGE, "--out: %s is given twice; leave one out", text);
    o->outputs[o->output_count++] = output;
    return KD_OK;
}

static kd_status read_context(app_options *o, const char *text)
{
    int api = 0;
    kd_status status = app_read_word("--context", text, app_context_words, &api);
    o->context = (kd_context_api)api;
    return status;
}

static kd_status read_asset_root(app_options *o, const char *text)
{
    return app_read_path("--asset-root", text, &o->roots[o->root_count++]);
}

static kd_status read_model_scene(app_options *o, const char *text)
{
    o->model_scene = text;
    return KD_OK;
}

static kd_status read_variant(app_options *o, const char *text)
{
    o->variant = text;
    return KD_OK;
}

static kd_status read_gi(app_options *o, const char *text)
{
    return app_read_word("--gi", text, app_gi_words, &o->gi);
}

static kd_status read_view(app_options *o, const char *text)
{
    return app_read_word("--view", text, app_view_words, &o->view);
}

bool app_is_param(const char *assignment)
{
    return strncmp(assignment, APP_PARAM_PREFIX, strlen(APP_PARAM_PREFIX)) == 0;
}

bool app_is_entity_field(const char *assignment)
{
    size_t key = strcspn(assignment, "="), dots = 0;
    for (size_t i = 0; i < key; i++)
        dots += assignment[i] == '.';
    return dots >= 2 && !kd_settings_find(assignment, key);
}

static kd_status read_set(app_options *o, const char *text)
{
    kd_settings scratch = kd_settings_defaults();
    if (!strchr(text, '=') || *text == '=')
        return kd_fail(KD_USAGE,
                       "--set: '%s' is not of the form KEY=VALUE; `kandil help settings` lists the keys",
                       text);
    o->sets[o->set_count++] = text;
    return app_is_param(text) || app_is_entity_field(text) ? KD_OK : kd_settings_set(&scratch, text);
}

static kd_status read_resume(app_options *o, const char *text)
{
    (void)text;
    o->resume = true;
    return KD_OK;
}

/* Options that stand for a setting; the text is checked as --set does. */
static kd_status read_setting(app_options *o, const char *option, const char *key, const char *text)
{
    kd_settings scratch = kd_settings_defaults();
    char *assignment = o->assignments[o->assignment_count];
    if (o->assignment_count == APP_MAX_ASSIGNMENTS)
        return kd_fail(KD_USAGE, "%s: given too often; give it once", option);
    int length = snprintf(assignment, sizeof o->assignments[0], "%s=%s", key, text);
    if (length >= (int)sizeof o->assignments[0])
        return kd_fail(KD_USAGE, "%s: '%.32s…' is no value for it; `kandil help settings` has %s", option,
                       text, key);
    o->assignment_count++;
    o->sets[o->set_count++] = assignment;
    return kd_settings_set(&scratch, assignment);
}

static kd_status read_level(app_options *o, const char *text)
{
    int64_t level = 0;
    kd_status status = app_read_integer("--level", text, 0, 15, &level);
    return status == KD_OK ? read_setting(o, "--level", "view.level", text) : status;
}

static kd_status read_supersample(app_options *o, const char *text)
{
    return read_setting(o, "--supersample", "film.supersample", text);
}

static kd_status read_subframes(app_options *o, const char *text)
{
    return read_setting(o, "--subframes", "film.subframes", text);
}

static kd_status read_shutter(app_options *o, const char *text)
{
    return read_setting(o, "--shutter", "film.shutter_deg", text);
}

static kd_status read_layers(app_options *o, const char *text)
{
    (void)text;
    return read_setting(o, "--layers", "film.layers", "on");
}

static kd_status read_png_depth(app_options *o, const char *text)
{
    return read_setting(o, "--png-depth", "film.png_depth", text);
}

static kd_status read_profile(app_options *o, const char *text)
{
    if (strcmp(text, "table") == 0) {
        o->profile = text;
        return KD_OK;
    }
    if (!kd_path_has_extension(text, ".json") && !kd_path_has_extension(text, ".pftrace"))
        return kd_fail(KD_USAGE, "--profile: '%s' is not supported; give table, FILE.json or FILE.pftrace",
                       text);
    if (o->trace_count == APP_MAX_TRACES)
        return kd_fail(KD_USAGE, "--profile: more than %d files; leave one out", APP_MAX_TRACES);
    return app_read_path("--profile", text, &o->traces[o->trace_count++]);
}

static kd_status read_compare_profile(app_options *o, const char *text)
{
    return app_read_path("--compare-profile", text, &o->compare_profile);
}

static kd_status read_stats(app_options *o, const char *text)
{
    return app_read_path("--stats", text, &o->stats);
}

static kd_status read_graph(app_options *o, const char *text)
{
    if (!kd_path_has_extension(text, ".dot") && !kd_path_has_extension(text, ".svg"))
        return kd_fail(KD_USAGE, "--graph: %s: unknown kind of file; end the name in .dot or .svg", text);
    return app_read_path("--graph", text, &o->graph);
}

static kd_status read_json(app_options *o, const char *text)
{
    return app_read_path("--json", text, &o->json);
}

static kd_status read_bench_n(app_options *o, const char *text)
{
    int64_t value = 0;
    kd_status status = app_read_integer("--n", text, 1, MAX_BENCH_N, &value);
    o->bench_n = (uint32_t)value;
    return status;
}

static kd_status read_bench_case(app_options *o, const char *text)
{
    o->bench_case = text;
    return KD_OK;
}

static kd_status read_bench_model(app_options *o, const char *text)
{
    return app_read_path("--model", text, &o->bench_model);
}

static kd_status read_dump(app_options *o, const char *text)
{
    return app_read_path("--dump", text, &o->dump);
}

/* ---- readers of what `kandil voxelize` is asked for ---- */

static kd_status read_kvox(app_options *o, const char *text)
{
    if (!kd_path_has_extension(text, ".kvox"))
        return kd_fail(KD_USAGE, "-o: %s: voxels go to a .kvox file; end the name so", text);
    return app_read_path("-o", text, &o->voxelizing.out);
}

static kd_status read_span(app_options *o, const char *text)
{
    return app_read_real("--span", text, 1e-4, 100, &o->voxelizing.span);
}

static kd_status read_resolution(app_options *o, const char *text)
{
    int64_t value = 0;
    kd_status status = app_read_integer("--resolution", text, 1, 4096, &value);
    o->voxelizing.resolution = (uint32_t)value;
    return status;
}

static kd_status read_cascades(app_options *o, const char *text)
{
    int64_t value = 0;
    kd_status status = app_read_integer("--cascades", text, 1, 4, &value);
    o->voxelizing.levels = (uint32_t)value;
    return status;
}

static kd_status read_separating(app_options *o, const char *text)
{
    static const char *const words[] = {"6", "26", NULL};
    int word = 0;
    kd_status status = app_read_word("--separating", text, words, &word);
    o->voxelizing.separating = word ? 26 : 6;
    return status;
}

static kd_status read_fill(app_options *o, const char *text)
{
    (void)text;
    o->voxelizing.fill = true;
    return KD_OK;
}

static kd_status read_hausdorff(app_options *o, const char *text)
{
    (void)text;
    o->voxelizing.hausdorff = true;
    return KD_OK;
}

static kd_status read_voxels(app_options *o, const char *text)
{
    return app_read_path("--voxels", text, &o->voxels);
}

static kd_status read_window(app_options *o, const char *text)
{
    (void)text;
    o->window = true;
    return KD_OK;
}

static kd_status read_profile_sync(app_options *o, const char *text)
{
    (void)text;
    o->profile_sync = true;
    return KD_OK;
}

static kd_status read_quiet(app_options *o, const char *text)
{
    (void)text;
    o->quiet = true;
    return KD_OK;
}

static const app_option_row run_options[] = {
    {"--frames", "N", read_frames, "number of frames; beats --seconds, which beats the scenario's"},
    {"--seconds", "S", read_seconds,
     "length; default: the scenario's, else 4 (a model: 48 frames for films and patterns, else 1)"},
    {"--fps", "F", read_fps, "simulation steps a second; default: the scenario's, else 30"},
    {"--size", "WxH", read_size, "size of the picture; default: the scenario's, else 640x360"},
    {"--seed", "N", read_seed, "seed of the scenario's math.random; default 0"},
    {"--threads", "N", read_threads,
     "threads; 0, the default, takes one per processor. Never changes the result"},
    {"--out", "PATH", read_out,
     "repeatable: .png, .exr (last frame; every frame with a number such as %04d), .mp4, .webm"},
    {"--resume", NULL, read_resume, "leave out frames whose numbered pictures stand there already"},
    {"--layers", NULL, read_layers,
     "write the parts of the light, albedo, normal, depth and motion into .exr too"},
    {"--png-depth", "8|16", read_png_depth, "bits a channel of .png; default 8"},
    {"--supersample", "N", read_supersample, "render N x N pixels for each of the picture; up to 8"},
    {"--subframes", "N", read_subframes, "motion blur: moments that a frame is the mean of; up to 256"},
    {"--shutter", "DEG", read_shutter,
     "how long the shutter is open before a frame's time; 360: a whole step; default 180"},
    {"--context", "API", read_context, "way to the GPU, one of:" CONTEXT_LIST(SPACED)},
    {"--window", NULL, read_window, "show a window; it is closed to end"},
    {"--asset-root", "DIR", read_asset_root,
     "repeatable: a folder beside the scenario's own from which it may load"},
    {"--scene", "NAME", read_model_scene, "which scene of a model file; `kandil info` lists them"},
    {"--variant", "NAME", read_variant, "which of a model's sets of materials; `kandil info` lists them"},
    {"--gi", "TECHNIQUE", read_gi, "indirect light, the first by default:" GI_LIST(SPACED)},
    {"--set", "KEY=VALUE", read_set,
     "repeatable: a setting, or an entity's field such as lamp.light.intensity=5"},
    {"--voxels", "FILE.kvox", read_voxels,
     "take voxels from a file that `kandil voxelize` has written for this scene"},
    {"--view", "VIEW", read_view, "what the picture shows, one of:" VIEW_LIST(SPACED)},
    {"--level", "L", read_level,
     "level that --view caches, pages, octree and lookup show; default: the finest"},
    {"--profile", "table|FILE", read_profile,
     "print the time of every system at the end, or write the whole timeline (.json for Chrome, .pftrace for "
     "Perfetto); repeatable"},
    {"--compare-profile", "OLD.json", read_compare_profile,
     "say which systems became slower since an earlier --profile FILE.json"},
    {"--profile-sync", NULL, read_profile_sync,
     "finish each GPU system to time it; the default on software drivers"},
    {"--stats", "FILE.json", read_stats, "write scene, times, voxels and memory"},
    {"--graph", "FILE", read_graph, "write the frame's graph as .dot, or .svg through Graphviz"},
    {"--quiet", NULL, read_quiet, "print errors only"},
    {NULL, NULL, NULL, NULL},
};

static const app_option_row voxelize_options[] = {
    {"-o", "FILE.kvox", read_kvox, "file to write"},
    {"--span", "M", read_span,
     "edge of the finest voxels in metres; default: what `kandil run` takes for the scene"},
    {"--resolution", "N", read_resolution, "voxels along the longest side of the scene, instead of a span"},
    {"--cascades", "N", read_cascades,
     "spans, each twice the one before; default: the setting voxels.cascades"},
    {"--separating", "6|26", read_separating,
     "6, the default: thin, no path by faces gets through (rigid meshes, finest span); 26: every cell that a "
     "surface touches"},
    {"--fill", NULL, read_fill, "fill closed meshes"},
    {"--hausdorff", NULL, read_hausdorff,
     "print how far voxels are from the mesh with 64, 128 and 256 along the longest side; without -o that "
     "alone"},
    {"--threads", "N", read_threads, "threads; 0, the default, takes one per processor"},
    {"--context", "API", read_context, "way to the GPU, one of:" CONTEXT_LIST(SPACED)},
    {"--asset-root", "DIR", read_asset_root,
     "repeatable: a folder beside the scenario's own from which it may load"},
    {"--scene", "NAME", read_model_scene, "which scene of a model file; `kandil info` lists them"},
    {"--variant", "NAME", read_variant, "which of a model's sets of materials; `kandil info` lists them"},
    {"--set", "KEY=VALUE", read_set, "repeatable: a setting, or an entity's field"},
    {"--quiet", NULL, read_quiet, "print errors only"},
    {NULL, NULL, NULL, NULL},
};

static const app_option_row reference_options[] = {
    {"--out", "PATH", read_out,
     "repeatable: .exr (linear radiance), .png; further terms go beside it as PATH_TERM"},
    {"-o", "PATH", read_out, "the same"},
    {"--spp", "N", app_read_spp, "samples a pixel; default 64"},
    {"--bounces", "N|inf", app_read_bounces,
     "bounces of light; 0: what comes straight from lights, emitters and sky; default inf"},
    {"--gathers", "N|inf", app_read_gathers,
     "count as the renderer's light.bounces: lights bounce N times, light of emitters and sky once less"},
    {"--terms", "LIST", app_read_terms, "what to write, a list of: " TERM_LIST(SPACED) "; default final"},
    {"--frame", "N", app_read_frame,
     "frame to show, from 0; default: the last that `kandil run` would render"},
    {"--frames", "N", read_frames, "number of frames, of which the last is shown"},
    {"--seconds", "S", read_seconds, "the same in seconds"},
    {"--fps", "F", read_fps, "simulation steps a second; default: the scenario's, else 30"},
    {"--size", "WxH", read_size, "size of the picture; default: the scenario's, else 640x360"},
    {"--seed", "N", read_seed, "seed of the samples and of the scenario's math.random; default 0"},
    {"--threads", "N", read_threads,
     "threads; 0, the default, takes one per processor. Never changes the result"},
    {"--pixel", "area|centre", app_read_pixel,
     "mean over the pixel's area, the default, or rays through its middle as `kandil run` does"},
    {"--lambert", NULL, app_read_lambert,
     "materials are their base colour alone, ideally diffuse, lit from both sides, maps interpolated as "
     "stored"},
    {"--time-budget", "S", app_read_time_budget, "end after so many seconds with the samples done by then"},
    {"--noise", "X", app_read_noise, "end when the mean relative squared error is about X"},
    {"--asset-root", "DIR", read_asset_root,
     "repeatable: a folder beside the scenario's own from which it may load"},
    {"--scene", "NAME", read_model_scene, "which scene of a model file; `kandil info` lists them"},
    {"--variant", "NAME", read_variant, "which of a model's sets of materials; `kandil info` lists them"},
    {"--set", "KEY=VALUE", read_set,
     "repeatable: a setting, or an entity's field such as lamp.light.intensity=5"},
    {"--stats", "FILE.json", read_stats, "write samples, rays, times and noise"},
    {"--quiet", NULL, read_quiet, "print errors only"},
    {NULL, NULL, NULL, NULL},
};

static const app_option_row compare_options[] = {
    {"--json", "FILE", read_json, "write the figures"},
    {"--html", "FILE", app_read_html, "write one page with pictures, heat maps and a slider"},
    {"--report", "DIR", app_read_report, "write report.html, report.json and every picture to a folder"},
    {"--temporal", NULL, app_read_temporal,
     "two pictures: neighbouring frames written with --layers, the earlier first; what flickers between them"},
    {"--gi", "LIST", app_read_techniques, "techniques of a scene, some of:" GI_LIST(SPACED) "; default: all"},
    {"--spp", "N", app_read_spp, "samples a pixel of the reference; default 64"},
    {"--bounces", "N|inf", app_read_bounces, "bounces of light in the reference, as for `kandil reference`"},
    {"--gathers", "N|inf", app_read_gathers,
     "count as the setting light.bounces does, and by default as it says"},
    {"--frame", "N", app_read_frame,
     "frame to compare, from 0; default: the last that `kandil run` would render"},
    {"--frames", "N", read_frames, "number of frames, of which the last is compared"},
    {"--seconds", "S", read_seconds, "the same in seconds"},
    {"--fps", "F", read_fps, "simulation steps a second; default: the scenario's, else 30"},
    {"--size", "WxH", read_size, "size of the picture; default: the scenario's, else 640x360"},
    {"--seed", "N", read_seed, "seed of the samples and of the scenario's math.random; default 0"},
    {"--threads", "N", read_threads, "threads; 0, the default, takes one per processor"},
    {"--pixel", "area|centre", app_read_pixel,
     "the reference's rays: through the pixels' middles, the default, or their mean"},
    {"--lambert", NULL, app_read_lambert, "take every material of the reference as ideally diffuse"},
    {"--time-budget", "S", app_read_time_budget, "end the reference after so many seconds"},
    {"--noise", "X", app_read_noise, "end it when the mean relative squared error is about X"},
    {"--context", "API", read_context, "way to the GPU, one of:" CONTEXT_LIST(SPACED)},
    {"--asset-root", "DIR", read_asset_root,
     "repeatable: a folder beside the scenario's own from which it may load"},
    {"--scene", "NAME", read_model_scene, "which scene of a model file; `kandil info` lists them"},
    {"--variant", "NAME", read_variant, "which of a model's sets of materials; `kandil info` lists them"},
    {"--set", "KEY=VALUE", read_set,
     "repeatable: a setting, or an entity's field; exposure and curve of the pictures too"},
    {"--quiet", NULL, read_quiet, "print errors only"},
    {NULL, NULL, NULL, NULL},
};

static const app_option_row bench_options[] = {
    {"--json", "FILE", read_json, "write the rows to a file too"},
    {"--threads", "N", read_threads, "threads of the cases for several; 0, the default: one per processor"},
    {"--n", "N", read_bench_n,
     "measure this size alone; default: 1000, 65536 and 1000000 entities, crowds of 1 to 256"},
    {"--case", "NAME", read_bench_case, "measure the cases whose name contains this"},
    {"--frames", "N", read_frames, "voxels, svo: frames measured for each row; default 12"},
    {"--model", "MODEL", read_bench_model,
     "voxels: what makes the crowd; default: the walker of the samples"},
    {"--dump", "DIR", read_dump,
     "svo: measure nothing, run --frames frames (default 1) and write what the tree holds to a folder"},
    {"--context", "API", read_context, "way to the GPU, one of:" CONTEXT_LIST(SPACED)},
    {"--profile-sync", NULL, read_profile_sync,
     "finish each GPU system to time it; the default on software drivers"},
    {"--asset-root", "DIR", read_asset_root,
     "repeatable: a folder beside the scenario's own from which it may load"},
    {"--set", "KEY=VALUE", read_set, "repeatable: a setting of the scene, such as voxels.span=0.04"},
    {NULL, NULL, NULL, NULL},
};

const app_option_row *app_command_options(app_command command)
{
    switch (command) {
    case APP_RUN: return run_options;
    case APP_REFERENCE: return reference_options;
    case APP_VOXELIZE: return voxelize_options;
    case APP_COMPARE: return compare_options;
    case APP_BENCH: return bench_options;
    default: return NULL;
    }
}
