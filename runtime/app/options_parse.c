/* The command line: which command, which of its options, and what stands beside them. */
#include "runtime/app/options.h"

#include <stdlib.h>
#include <string.h>

#include "runtime/app/options_read.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "runtime/core/nearest.h"
#include "runtime/reference/reference.h"

static const app_option_row *find_option(const app_option_row *rows, const char *name, size_t length)
{
    for (const app_option_row *row = rows; row->name; row++)
        if (strlen(row->name) == length && strncmp(row->name, name, length) == 0)
            return row;
    return NULL;
}

static kd_status fail_unknown_option(const app_option_row *rows, const char *command, const char *name)
{
    kd_nearest near = kd_nearest_to(name);
    for (const app_option_row *row = rows; row->name; row++)
        kd_nearest_offer(&near, row->name);
    if (near.best)
        return kd_fail(KD_USAGE, "unknown option %s; did you mean %s?", name, near.best);
    return kd_fail(KD_USAGE, "unknown option %s; `kandil help %s` lists all", name, command);
}

/* Read the option at argv[*i], and its value behind '=' or in the next argument. */
static kd_status read_option(app_options *out, const char *command, int argc, char **argv, int *i)
{
    const char *argument = argv[*i], *equals = strchr(argument, '=');
    size_t length = equals ? (size_t)(equals - argument) : strlen(argument);
    const app_option_row *rows = app_command_options(out->command);
    const app_option_row *row = rows ? find_option(rows, argument, length) : NULL;
    if (!rows)
        return kd_fail(KD_USAGE, "unknown option %s; this command takes none", argument);
    if (!row)
        return fail_unknown_option(rows, command, argument);
    if (!row->value)
        return equals ? kd_fail(KD_USAGE, "%s takes no value; write it alone", row->name)
                      : row->read(out, NULL);
    if (equals)
        return row->read(out, equals + 1);
    if (*i + 1 >= argc)
        return kd_fail(KD_USAGE, "%s needs a value; write %s %s", row->name, row->name, row->value);
    return row->read(out, argv[++*i]);
}

static kd_status read_bench(app_options *out, const char *text)
{
    static const char *const words[] = {"all", "ecs", "jobs", "voxels", "svo", NULL};
    int bench = 0;
    kd_status status = app_read_word("bench", text, words, &bench);
    out->bench = (app_bench)bench;
    return status;
}

/* The picture to compare with; the scene of a bench that runs one. */
static bool takes_second(const app_options *o)
{
    return o->command == APP_COMPARE ||
           (o->command == APP_BENCH && o->bench != APP_BENCH_ECS && o->bench != APP_BENCH_JOBS);
}

static kd_status read_subject(app_options *out, const app_command_row *row, const char *text)
{
    if (!row->subject)
        return kd_fail(KD_USAGE, "unexpected argument '%s'; `kandil %s` takes none", text, row->name);
    if (takes_second(out) && out->subject && !out->second) {
        out->second = text;
        return KD_OK;
    }
    if (out->subject)
        return kd_fail(KD_USAGE, "unexpected argument '%s' after '%s'; give one %s", text, out->subject,
                       row->subject);
    out->subject = text;
    return out->command == APP_BENCH ? read_bench(out, text) : KD_OK;
}

static const app_command_row *find_command(const char *name)
{
    for (const app_command_row *row = app_commands; row->name; row++)
        if (strcmp(row->name, name) == 0)
            return row;
    return NULL;
}

static kd_status fail_unknown_command(const char *name)
{
    kd_nearest near = kd_nearest_to(name);
    for (const app_command_row *row = app_commands; row->name; row++)
        kd_nearest_offer(&near, row->name);
    if (near.best)
        return kd_fail(KD_USAGE, "unknown command '%s'; did you mean '%s'?", name, near.best);
    if (kd_path_has_extension(name, ".lua") || kd_path_has_extension(name, ".gltf") ||
        kd_path_has_extension(name, ".glb"))
        return kd_fail(KD_USAGE, "unknown command '%s'; to render it write `kandil run %s`", name, name);
    return kd_fail(KD_USAGE, "unknown command '%s'; `kandil help` lists all", name);
}

static bool is_help(const char *text)
{
    return strcmp(text, "--help") == 0 || strcmp(text, "-h") == 0;
}

static kd_status read_arguments(app_options *out, const app_command_row *row, int argc, char **argv)
{
    bool options_end = false;
    kd_status status = KD_OK;
    for (int i = 2; i < argc && status == KD_OK; i++) {
        if (!options_end && is_help(argv[i])) {
            out->command = APP_HELP;
            out->subject = row->name;
            return KD_OK;
        }
        if (!options_end && strcmp(argv[i], "--") == 0)
            options_end = true;
        else if (!options_end && argv[i][0] == '-' && argv[i][1])
            status = read_option(out, row->name, argc, argv, &i);
        else
            status = read_subject(out, row, argv[i]);
    }
    for (uint32_t i = 0; i < out->output_count && status == KD_OK; i++) {
        const char *path = out->outputs[i].path;
        if ((out->stats && strcmp(path, out->stats) == 0) || (out->graph && strcmp(path, out->graph) == 0))
            return kd_fail(KD_USAGE, "--out: %s is written by another option too; choose another name", path);
    }
    if (status == KD_OK && row->subject && row->subject[0] != '[' && !out->subject)
        return kd_fail(KD_USAGE, "%s needs a %s; write `kandil %s %s`", row->name, row->subject, row->name,
                       row->subject);
    return status;
}

/* Every list has room for one entry an argument. */
static kd_status make_lists(app_options *out, int argc)
{
    size_t count = (size_t)(argc > 0 ? argc : 0) + 1;
    size_t lists = count * (sizeof *out->outputs + 2 * sizeof *out->roots);
    char *memory = calloc(1, lists + APP_MAX_ASSIGNMENTS * sizeof out->assignments[0]);
    if (!memory)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    out->memory = memory;
    out->outputs = (app_output *)(void *)memory;
    out->roots = (const char **)(void *)(out->outputs + count);
    out->sets = out->roots + count;
    out->assignments = (char(*)[48])(void *)(memory + lists);
    return KD_OK;
}

kd_status app_options_parse(int argc, char **argv, app_options *out)
{
    *out = (app_options){.command = APP_HELP, .frames = -1, .seconds = -1, .gi = -1, .view = -1};
    out->tracing = (app_tracing){.frame = -1, .bounces = KD_REFERENCE_ENDLESS};
    if (argc < 2)
        return kd_fail(KD_USAGE, "no command; `kandil help` lists all");
    if (is_help(argv[1]))
        return KD_OK;
    if (strcmp(argv[1], "--version") == 0) {
        out->command = APP_VERSION;
        return KD_OK;
    }
    const app_command_row *row = find_command(argv[1]);
    if (!row)
        return fail_unknown_command(argv[1]);
    kd_status status = make_lists(out, argc);
    out->command = row->command;
    out->tracing.centre =
        row->command == APP_COMPARE; /* the renderer's own way, so that light alone differs */
    if (status == KD_OK)
        status = read_arguments(out, row, argc, argv);
    if (status != KD_OK)
        app_options_fini(out);
    return status;
}

void app_options_fini(app_options *options)
{
    free(options->memory);
    options->memory = NULL;
    options->output_count = options->root_count = options->set_count = 0;
}
