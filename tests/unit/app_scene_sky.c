/* Pictures of skies: one of a path, however many entities and fillings of the world ask for it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "components/sky.h"
#include "runtime/app/scene.h"
#include "runtime/core/file.h"
#include "runtime/core/log.h"
#include "tests/folder_fixture.h"

static char said[1024];

static void collect(void *user, kd_log_level level, const char *text)
{
    (void)user;
    if (level == KD_LOG_ERROR)
        snprintf(said, sizeof said, "%s", text);
}

static void write_sky(const char *path)
{
    static const char head[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n";
    uint8_t bytes[sizeof head - 1 + 4 * 2 * 4];
    memcpy(bytes, head, sizeof head - 1);
    memset(bytes + sizeof head - 1, 128, 4 * 2 * 4);
    assert_int_equal(kd_file_write(path, bytes, sizeof bytes), KD_OK);
}

static void write_scenario(const char *text)
{
    assert_int_equal(kd_file_write("s.lua", text, strlen(text)), KD_OK);
}

static uint32_t image_of(const kd_world *w, const char *name)
{
    const kd_sky *sky = kd_find(w, kd_find_named(w, name), kd_sky);
    assert_non_null(sky);
    return sky->image;
}

static void a_picture_is_read_once_a_path(void **state)
{
    char *argv[] = {"kandil", "run", "s.lua", NULL};
    app_options options;
    app_scene scene;
    kd_world *w = kd_world_make();
    (void)state;
    write_sky("a.hdr");
    write_sky("b.hdr");
    write_scenario("for i = 1, 9 do kandil.spawn { name = 'a' .. i, sky_image = 'a.hdr' } end\n"
                   "kandil.spawn { name = 'b', sky_image = 'b.hdr' }\n");
    assert_int_equal(app_options_parse(3, argv, &options), KD_OK);
    assert_int_equal(app_scene_load(&scene, w, &options, NULL), KD_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(kd_singleton(w, kd_sky_images)->count, 2);
        assert_int_equal(image_of(w, "a1"), image_of(w, "a9"));
        assert_int_not_equal(image_of(w, "a1"), image_of(w, "b"));
        assert_int_equal(app_scene_renew(&scene, &options), KD_OK);
    }
    app_scene_fini(&scene);
    kd_world_destroy(w);
    app_options_fini(&options);
}

/* What the world holds already only claims to be large: nobody looks at it. */
static void too_many_bytes_are_refused(void **state)
{
    char *argv[] = {"kandil", "run", "s.lua", NULL};
    app_options options;
    app_scene scene;
    uint32_t number;
    kd_world *w = kd_world_make();
    (void)state;
    write_sky("c.hdr");
    write_scenario("");
    assert_int_not_equal(kd_sky_add_image(w, (kd_sky_map){16384, 4096, calloc(3, sizeof(float))}), 0);
    assert_int_equal(app_options_parse(3, argv, &options), KD_OK);
    assert_int_equal(app_scene_load(&scene, w, &options, NULL), KD_OK);
    kd_log_set_sink(collect, NULL);
    assert_int_equal(app_scene_sky(&scene, "c.hdr", &number), KD_TOO_LARGE);
    kd_log_set_sink(NULL, NULL);
    assert_non_null(strstr(said, "c.hdr: all pictures of skies together take more than 512 MiB; use fewer"));
    assert_int_equal(kd_singleton(w, kd_sky_images)->count, 1);
    app_scene_fini(&scene);
    kd_world_destroy(w);
    app_options_fini(&options);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_picture_is_read_once_a_path),
        cmocka_unit_test(too_many_bytes_are_refused),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
