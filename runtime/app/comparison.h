#ifndef KD_APP_COMPARISON_H
#define KD_APP_COMPARISON_H

/* Pictures measured against their references, and what is said about them: a table, JSON, one page of HTML.
 */

#include "runtime/app/options.h"
#include "runtime/app/picture.h"

/* How one picture differs from its reference. Figures that the kind of file does not allow are NaN. */
typedef struct app_difference {
    double flip;         /* mean LDR-FLIP of what is shown, 0 … 1 */
    double hdr_flip;     /* mean HDR-FLIP of the radiance */
    double relative_mse; /* of the radiance */
    double ssim;         /* of what is shown */
    double mean_ratio;   /* mean radiance over that of the reference */
} app_difference;

/* A pair of pictures and what was found. */
typedef struct app_pair {
    char name[64];               /* "cones final" */
    app_picture test, reference; /* as read or rendered */
    app_picture shown[2];        /* sRGB codes: test, reference */
    float *map;                  /* LDR-FLIP of every pixel */
    app_difference difference;
    double tracer_s; /* the path tracer's time to the same relMSE; NaN: not known */
} app_pair;

/** Measure pictures of equal size: `test` and `reference` are given, the rest is filled. `light` false:
 * values are no radiance (directions, shares), so exposure and curve are left out. Errors  NO_MEMORY with a
 * message; fini is still to be called */
kd_status app_pair_measure(app_pair *pair, float exposure, kd_tonemap curve, bool light);
void app_pair_fini(app_pair *pair);
/** Make the picture of its differences. Errors NO_MEMORY with a message */
kd_status app_pair_heat(const app_pair *pair, app_picture *out);

/* A way of rendering, and what it costs. */
typedef struct app_row {
    char name[32];
    double frame_ms; /* median */
    double gi_ms;    /* of the systems that only this way of rendering needs; NaN: not known */
    uint64_t gpu_bytes;
    uint32_t first_pair, pair_count;
} app_row;

typedef struct app_comparison {
    const char *title;
    uint32_t width, height;
    char reference[128]; /* what the reference is, in words */
    app_row *rows;
    app_pair *pairs;
    uint32_t row_count, pair_count;
    double tracer_rate; /* relMSE of the path tracer's indirect term times its seconds: noise falls as 1 / t;
                           0: none */
} app_comparison;

/** Print to standard output. */
void app_comparison_print(const app_comparison *c);
/** Errors as kd_file_write; one message */
kd_status app_comparison_write_json(const char *path, const app_comparison *c);
/** One file with all pictures inside. Errors as kd_file_write; one message */
kd_status app_comparison_write_html(const char *path, const app_comparison *c);

/** Print what was found of pairs of pictures, and write what the options ask for. Errors  as above */
kd_status app_comparison_report(const app_options *options, const char *title, const char *reference,
                                app_pair *pairs, uint32_t count);

/** Measure what flickers between two files with layers, options->subject and the frame after it,
 *  options->second. Errors  as app_picture_read, also for channels that are missing; one message */
kd_status app_compare_temporal(const app_options *options, const kd_settings *settings);

/** `kandil compare`: two pictures, or a scene's techniques against its reference. Errors with one message */
kd_status app_compare_run(const app_options *options);

#endif
