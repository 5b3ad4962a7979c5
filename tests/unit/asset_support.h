#ifndef KD_TESTS_ASSET_SUPPORT_H
#define KD_TESTS_ASSET_SUPPORT_H

/* What the tests of the asset module share: counting messages, and small glTF files written on the spot. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "runtime/asset/model.h"
#include "runtime/core/log.h"

typedef struct messages {
    int errors, warnings;
    char last_error[1024];
} messages;
static messages seen_messages;

static inline void collect_message(void *user, kd_log_level level, const char *text)
{
    messages *m = user;
    if (level == KD_LOG_ERROR) {
        m->errors++;
        snprintf(m->last_error, sizeof m->last_error, "%s", text);
    }
    m->warnings += level == KD_LOG_WARNING;
}

static inline void watch_messages(void)
{
    seen_messages = (messages){0};
    kd_log_set_sink(collect_message, &seen_messages);
}

static inline void write_bytes(const char *path, const void *bytes, size_t size)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

static char test_folder[64];

static inline const char *in_folder(const char *name)
{
    static char path[128];
    if (!*test_folder) {
        snprintf(test_folder, sizeof test_folder, "/tmp/kandil_asset_XXXXXX");
        assert_non_null(mkdtemp(test_folder));
    }
    snprintf(path, sizeof path, "%s/%s", test_folder, name);
    return path;
}

/* Load JSON written with ' for ", with `bin` beside it as data.bin. */
static inline kd_status load_case(const char *json, const void *bin, size_t size, kd_model **out)
{
    char *text = strdup(json);
    assert_non_null(text);
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    write_bytes(in_folder("case.gltf"), text, strlen(text));
    free(text);
    if (size)
        write_bytes(in_folder("data.bin"), bin, size);
    watch_messages();
    return kd_model_load(in_folder("case.gltf"), out);
}

/* The case must load without a message. */
static inline kd_model *load_good(const char *json, const void *bin, size_t size)
{
    kd_model *model = NULL;
    kd_status status = load_case(json, bin, size, &model);
    if (status)
        print_message("unexpected: %s\n", seen_messages.last_error);
    assert_int_equal(status, KD_OK);
    assert_int_equal(seen_messages.errors, 0);
    return model;
}

/* The case must fail with one message that holds `part`. */
static inline void load_bad(const char *json, const void *bin, size_t size, kd_status expected,
                            const char *part)
{
    kd_model *model = NULL;
    kd_status status = load_case(json, bin, size, &model);
    assert_null(model);
    assert_int_equal(status, expected);
    assert_int_equal(seen_messages.errors, 1);
    if (!strstr(seen_messages.last_error, part))
        fail_msg("'%s' is not in '%s'", part, seen_messages.last_error);
}

static inline int remove_folder(void **state)
{
    (void)state;
    if (*test_folder) {
        unlink(in_folder("case.gltf"));
        unlink(in_folder("data.bin"));
        unlink(in_folder("case.glb"));
        rmdir(test_folder);
    }
    return 0;
}

#define NEAR(a, b, tolerance) assert_float_equal((a), (b), (tolerance))

static inline void assert_vec3(kd_vec3 v, float x, float y, float z, float tolerance)
{
    NEAR(v.x, x, tolerance);
    NEAR(v.y, y, tolerance);
    NEAR(v.z, z, tolerance);
}

#endif
