#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/core/log.h"
#include "runtime/core/settings.h"

static char last_message[512];
static int messages;

static void catch_message(void *user, kd_log_level level, const char *text)
{
    (void)user;
    (void)level;
    messages++;
    snprintf(last_message, sizeof last_message, "%s", text);
}

static int set_up(void **state)
{
    (void)state;
    messages = 0;
    last_message[0] = '\0';
    kd_log_set_sink(catch_message, NULL);
    return 0;
}

/* Every refusal: USAGE, exactly one message that contains `part`, and no change. */
static void assert_refused(const char *assignment, const char *part)
{
    kd_settings settings = kd_settings_defaults(), before = settings;
    messages = 0;
    assert_int_equal(kd_settings_set(&settings, assignment), KD_USAGE);
    assert_int_equal(messages, 1);
    if (!strstr(last_message, part))
        fail_msg("\"%s\" lacks \"%s\"", last_message, part);
    assert_memory_equal(&settings, &before, sizeof settings);
}

static void defaults_agree_with_rows_and_ranges(void **state)
{
    (void)state;
    kd_settings settings = kd_settings_defaults();
    size_t count;
    const kd_setting_row *rows = kd_settings_rows(&count);
    assert_true(count >= 23);
    for (size_t i = 0; i < count; i++) {
        assert_true(kd_settings_value(&settings, &rows[i]) == rows[i].default_value);
        assert_true(rows[i].default_value >= rows[i].min && rows[i].default_value <= rows[i].max);
        assert_ptr_equal(kd_settings_find(rows[i].key, strlen(rows[i].key)), &rows[i]);
        assert_true(rows[i].doc[0] != '\0');
    }
    assert_true(settings.voxels_span == 0.02f);
    assert_int_equal(settings.voxels_resolution, 128);
    assert_true(settings.specular_cones);
    assert_int_equal(settings.svo_layers, KD_SVO_LAYERS_TWO);
}

/* What format writes, set takes, and the value is the same to the bit. */
static void format_reads_back_equal(void **state)
{
    (void)state;
    kd_settings settings = kd_settings_defaults();
    settings.voxels_span = 1.0f / 3.0f;
    settings.view_tonemap = KD_TONEMAP_LINEAR;
    settings.voxels_resolution = 512;
    settings.view_auto_exposure = true;
    kd_settings copy = kd_settings_defaults();
    size_t count;
    const kd_setting_row *rows = kd_settings_rows(&count);
    for (size_t i = 0; i < count; i++) {
        char value[32], assignment[96];
        snprintf(assignment, sizeof assignment, "%s=%s", rows[i].key,
                 kd_settings_format(&settings, &rows[i], value, sizeof value));
        assert_int_equal(kd_settings_set(&copy, assignment), KD_OK);
        assert_true(kd_settings_value(&copy, &rows[i]) == kd_settings_value(&settings, &rows[i]));
    }
    assert_int_equal(messages, 0);
}

static void set_takes_every_type(void **state)
{
    (void)state;
    kd_settings s = kd_settings_defaults();
    assert_int_equal(kd_settings_set(&s, "voxels.span=0.08"), KD_OK);
    assert_true(s.voxels_span == 0.08f);
    assert_int_equal(kd_settings_set(&s, "voxels.resolution=256"), KD_OK);
    assert_int_equal(s.voxels_resolution, 256);
    assert_int_equal(kd_settings_set(&s, "view.tonemap=reinhard"), KD_OK);
    assert_int_equal(s.view_tonemap, KD_TONEMAP_REINHARD);
    assert_int_equal(s.light_leak, KD_LEAK_DEFAULT);
    assert_int_equal(kd_settings_set(&s, "light.leak=strict"), KD_OK);
    assert_int_equal(s.light_leak, KD_LEAK_STRICT);
    assert_int_equal(kd_settings_set(&s, "svo.layers=one"), KD_OK);
    assert_int_equal(s.svo_layers, KD_SVO_LAYERS_ONE);
    assert_int_equal(kd_settings_set(&s, "specular.cones=off"), KD_OK);
    assert_false(s.specular_cones);
    assert_int_equal(kd_settings_set(&s, "specular.cones=1"), KD_OK);
    assert_true(s.specular_cones);
    assert_int_equal(kd_settings_set(&s, "view.exposure_ev=-1.5e0"), KD_OK);
    assert_true(s.view_exposure_ev == -1.5f);
}

static void set_takes_the_ends_of_a_range(void **state)
{
    (void)state;
    kd_settings s = kd_settings_defaults();
    assert_int_equal(kd_settings_set(&s, "voxels.span=0.0001"), KD_OK);
    assert_int_equal(kd_settings_set(&s, "voxels.span=100"), KD_OK);
    assert_int_equal(kd_settings_set(&s, "cones.count=3"), KD_OK);
    assert_int_equal(kd_settings_set(&s, "cones.count=16"), KD_OK);
}

static void set_refuses_values_outside_the_range(void **state)
{
    (void)state;
    assert_refused("voxels.span=0", "from 0.0001 to 100 m");
    assert_refused("voxels.span=100.1", "voxels.span");
    assert_refused("voxels.span=-1", "from 0.0001");
    assert_refused("voxels.span=nan", "number");
    assert_refused("voxels.span=inf", "number");
    assert_refused("cones.count=17", "whole number from 3 to 16");
    assert_refused("cones.count=99999999999999999999", "from 3 to 16");
    assert_refused("light.bounces=3", "0, 1, 2 or inf");
    assert_refused("light.leak=never", "default or strict");
}

static void set_refuses_malformed_values(void **state)
{
    (void)state;
    assert_refused("voxels.span=", "\"\"");
    assert_refused("voxels.span=0.1x", "0.1x");
    assert_refused("voxels.span= 0.1", "number");
    assert_refused("cones.count=4.5", "whole number");
    assert_refused("specular.cones=maybe", "on or off");
    assert_refused("view.tonemap=filmic", "aces, reinhard or linear");
    assert_refused("voxels.resolution=100", "128, 256, 512 or 1024");
    assert_refused("voxels.resolution=0x80", "128, 256, 512 or 1024");
}

static void set_refuses_malformed_assignments(void **state)
{
    (void)state;
    assert_refused("", "KEY=VALUE");
    assert_refused("voxels.span", "KEY=VALUE");
    assert_refused("=3", "KEY=VALUE");
}

static void set_names_near_misses(void **state)
{
    (void)state;
    assert_refused("voxels.spam=1", "did you mean voxels.span?");
    assert_refused("voxel.resolution=64", "voxels.resolution");
    assert_refused("span=1", "voxels.span");
    assert_refused("CONES.COUNT=6", "cones.count");
    assert_refused("zzzzzzzzzz=1", "kandil help settings");
    messages = 0;
    kd_settings s = kd_settings_defaults();
    assert_int_equal(kd_settings_set(&s, "zzzzzzzzzz=1"), KD_USAGE);
    assert_null(strstr(last_message, "did you mean"));
}

static void set_survives_a_very_long_key(void **state)
{
    (void)state;
    char assignment[5000];
    memset(assignment, 'v', sizeof assignment);
    memcpy(assignment + 4990, "=1", 3);
    assert_refused(assignment, "no such setting");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(defaults_agree_with_rows_and_ranges, set_up),
        cmocka_unit_test_setup(format_reads_back_equal, set_up),
        cmocka_unit_test_setup(set_takes_every_type, set_up),
        cmocka_unit_test_setup(set_takes_the_ends_of_a_range, set_up),
        cmocka_unit_test_setup(set_refuses_values_outside_the_range, set_up),
        cmocka_unit_test_setup(set_refuses_malformed_values, set_up),
        cmocka_unit_test_setup(set_refuses_malformed_assignments, set_up),
        cmocka_unit_test_setup(set_names_near_misses, set_up),
        cmocka_unit_test_setup(set_survives_a_very_long_key, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
