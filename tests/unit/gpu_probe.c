#include "runtime/gpu/context.h"
#include "tests/gpu_fixture.h"

static void probe_reports_every_way(void **state)
{
    kd_gpu_probe_row rows[8];
    bool any = false;
    (void)state;
    uint32_t count = kd_gpu_probe(rows, 8);
    assert_int_equal(count, 5);
    for (uint32_t i = 0; i < count; i++) {
        any = any || rows[i].works;
        if (rows[i].works) {
            assert_string_not_equal(rows[i].renderer, "");
            assert_string_not_equal(rows[i].version, "");
            assert_true(rows[i].max_ssbo_bytes >= 1 << 24); /* the least that GL 4.5 allows */
        } else {
            assert_string_not_equal(rows[i].note, "");
        }
    }
    if (!any)
        exit(FIXTURE_SKIP);
}

static void probe_writes_no_more_than_there_is_room(void **state)
{
    kd_gpu_probe_row rows[2];
    (void)state;
    memset(rows, 0x55, sizeof rows);
    assert_int_equal(kd_gpu_probe(rows, 1), 1);
    assert_int_equal(rows[1].note[0], 0x55);
    assert_int_equal(kd_gpu_probe(NULL, 0), 0);
}

static void probe_says_what_a_missing_display_means(void **state)
{
    kd_gpu_probe_row rows[8];
    (void)state;
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    uint32_t count = kd_gpu_probe(rows, 8);
    assert_int_equal(rows[count - 1].api, KD_CONTEXT_GLFW);
    assert_false(rows[count - 1].works);
    assert_true(strstr(rows[count - 1].note, "DISPLAY is not set") ||
                strstr(rows[count - 1].note, "is missing"));
}

static void missing_library_is_named(void **state)
{
    const char *const names[] = {"libkandil_none.so.1", "libkandil_none.so", NULL};
    gpu_reason reason = {""};
    (void)state;
    assert_null(gpu_library_open(names, &reason));
    assert_non_null(strstr(reason.text, "libkandil_none.so.1 is missing"));
}

static void names_are_there_for_every_way(void **state)
{
    (void)state;
    for (int api = 0; api < KD_CONTEXT_API_COUNT; api++)
        assert_string_not_equal(kd_context_api_name((kd_context_api)api), "unknown");
    assert_string_equal(kd_context_api_name(KD_CONTEXT_API_COUNT), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(probe_reports_every_way),
        cmocka_unit_test(probe_writes_no_more_than_there_is_room),
        cmocka_unit_test(probe_says_what_a_missing_display_means),
        cmocka_unit_test(missing_library_is_named),
        cmocka_unit_test(names_are_there_for_every_way),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
