#ifndef KD_APP_OPTIONS_H
#define KD_APP_OPTIONS_H

/* The command line, checked. What was not said is told apart from what was, since a scenario may say it
 * instead. */

#include <stdbool.h>
#include <stdint.h>

#include "runtime/core/settings.h"
#include "runtime/core/status.h"
#include "runtime/gpu/gpu.h"

typedef enum app_command {
    APP_HELP,
    APP_VERSION,
    APP_RUN,
    APP_INFO,
    APP_DOCTOR,
    APP_BENCH,
    APP_REFERENCE,
    APP_COMPARE,
    APP_VOXELIZE
} app_command;

typedef enum app_bench {
    APP_BENCH_ALL,
    APP_BENCH_ECS,
    APP_BENCH_JOBS,
    APP_BENCH_VOXELS,
    APP_BENCH_SVO
} app_bench;

typedef enum app_output_kind { APP_OUTPUT_PNG, APP_OUTPUT_EXR, APP_OUTPUT_FILM } app_output_kind;
typedef struct app_output {
    const char *path;
    app_output_kind kind;
    bool every_frame; /* a film, or a path with %d: the frame's number */
} app_output;

/* What the path tracer is asked for. */
typedef struct app_tracing {
    int64_t frame;   /* -1: the last that --frames, --seconds or the scenario give */
    uint32_t spp;    /* 0: not said */
    int32_t bounces; /* KD_REFERENCE_ENDLESS: no limit */
    bool bounces_said, gathered;
    uint32_t terms; /* bits by kd_reference_term; 0: the final picture alone */
    bool lambert, centre;
    double time_budget_s, noise; /* 0: not said */
} app_tracing;

/* What `kandil voxelize` is asked for; 0, false, NULL: not said. */
typedef struct app_voxelizing {
    const char *out;
    double span;         /* m */
    uint32_t resolution; /* voxels along the longest side of the scene, instead of a span */
    uint32_t levels;
    int separating; /* 6, 26 */
    bool fill;
    bool hausdorff;
} app_voxelizing;

enum { APP_MAX_TRACES = 4, APP_MAX_ASSIGNMENTS = 16 };

typedef struct app_options {
    const struct kd_extension *extension; /* of the program, or NULL */
    app_command command;
    const char *subject;               /* the scene, the file, or the topic of help; NULL */
    const char *second;                /* the picture to compare with, the scene of a bench; NULL */
    const char *model_scene, *variant; /* of a bare model, by name; NULL: not said */
    int64_t frames;                    /* -1: not said */
    double seconds;                    /* negative: not said */
    double fps;                        /* 0: not said */
    uint32_t width, height;            /* 0: not said */
    uint64_t seed;
    uint32_t threads; /* 0: one per processor */
    kd_context_api context;
    int gi, view;                       /* kd_gi_technique, kd_view_mode; -1: not said */
    const char *profile;                /* "table" or NULL */
    const char *traces[APP_MAX_TRACES]; /* paths of timelines */
    uint32_t trace_count;
    const char *compare_profile; /* path of an earlier timeline, or NULL */
    bool profile_sync, window, quiet, resume;
    const char *stats, *graph; /* paths or NULL */
    app_bench bench;
    uint32_t bench_n;                 /* 0: not said */
    const char *bench_case;           /* a part of the names of cases, or NULL */
    const char *bench_model;          /* path of the model that makes a crowd, or NULL */
    const char *dump;                 /* a folder for what the tree holds, or NULL */
    const char *json, *html, *report; /* paths or NULL */
    bool temporal;                    /* of two pictures: neighbouring frames with layers */
    uint32_t techniques;              /* bits by kd_gi_technique; 0: not said */
    app_tracing tracing;
    app_voxelizing voxelizing;
    const char *voxels; /* a .kvox file to take voxels from, or NULL */
    uint32_t output_count, root_count, set_count;
    app_output *outputs;
    const char **roots;
    const char **sets;       /* "KEY=VALUE" as given; settings among them are checked already */
    char (*assignments)[48]; /* [APP_MAX_ASSIGNMENTS] what options that stand for a setting put into `sets` */
    uint32_t assignment_count;
    void *memory;                                    /* of the lists */
    void (*asked_for)(void *user, const char *path); /* told of files that a scenario asks for; or NULL */
    void *asked_for_user;
} app_options;

/** Read the command line. Strings point into argv.
 *
 *  Errors  USAGE with one message; NO_MEMORY. Nothing to free then
 *  Owns    app_options_fini frees the lists
 */
kd_status app_options_parse(int argc, char **argv, app_options *out);
void app_options_fini(app_options *options);

/* One row of the list of options, for parsing and for `kandil help run`. */
typedef struct app_option_row {
    const char *name;  /* "--frames" */
    const char *value; /* "N"; NULL: a flag */
    kd_status (*read)(app_options *options, const char *value);
    const char *doc;
} app_option_row;
/** Get the options a command takes, ended by an empty row. Returns NULL when it takes none. */
const app_option_row *app_command_options(app_command command);

typedef struct app_command_row {
    const char *name;
    app_command command;
    const char *subject; /* "SCENE", NULL when it takes none, "[COMMAND]" when it may be left out */
    const char *doc;
} app_command_row;
extern const app_command_row app_commands[]; /* ended by an empty row */

/** Tell whether "KEY=VALUE" names a field of an entity (NAME.component.field) rather than a setting. */
bool app_is_entity_field(const char *assignment);

/** Tell whether it is a parameter of the scenario, "param.NAME=VALUE". */
#define APP_PARAM_PREFIX "param."
bool app_is_param(const char *assignment);

/** Words of --gi and --view, in order of the enumerations, NULL-terminated. */
extern const char *const app_gi_words[];
extern const char *const app_view_words[];
/** Words of --context, in order of kd_context_api. */
extern const char *const app_context_words[];
/** Words of --terms, in order of kd_reference_term. */
extern const char *const app_term_words[];
/** Index of a word; -1 when it is none of them. */
int app_find_word(const char *const *words, const char *word);

#endif
