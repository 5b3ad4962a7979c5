#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/clock.h"
#include "runtime/core/json.h"
#include "runtime/core/log.h"

static void nested_containers_get_their_commas(void **state)
{
    (void)state;
    kd_json j = {0};
    kd_json_object_begin(&j);
    kd_json_key(&j, "a");
    kd_json_array_begin(&j);
    kd_json_int(&j, -1);
    kd_json_object_begin(&j);
    kd_json_object_end(&j);
    kd_json_array_begin(&j);
    kd_json_array_end(&j);
    kd_json_bool(&j, true);
    kd_json_array_end(&j);
    kd_json_key(&j, "b");
    kd_json_uint(&j, UINT64_MAX);
    kd_json_key(&j, "c");
    kd_json_null(&j);
    kd_json_object_end(&j);
    assert_string_equal(kd_json_text(&j), "{\"a\":[-1,{},[],true],\"b\":18446744073709551615,\"c\":null}");
    kd_json_fini(&j);
}

static void indent_breaks_lines(void **state)
{
    (void)state;
    kd_json j = {.indent = 2};
    kd_json_object_begin(&j);
    kd_json_key(&j, "a");
    kd_json_array_begin(&j);
    kd_json_int(&j, 1);
    kd_json_int(&j, 2);
    kd_json_array_end(&j);
    kd_json_object_end(&j);
    assert_string_equal(kd_json_text(&j), "{\n  \"a\": [\n    1,\n    2\n  ]\n}");
    kd_json_fini(&j);
}

static void assert_string_written(const char *text, const char *expected)
{
    kd_json j = {0};
    kd_json_string(&j, text);
    assert_string_equal(kd_json_text(&j), expected);
    kd_json_fini(&j);
}

static void strings_are_escaped(void **state)
{
    (void)state;
    assert_string_written("a\"b\\c\n\t\x01", "\"a\\\"b\\\\c\\n\\t\\u0001\"");
    assert_string_written("\xC3\xA9 \xE2\x82\xAC \xF0\x9F\x98\x80", "\"\xC3\xA9 \xE2\x82\xAC \xF0\x9F\x98\x80\"");
    assert_string_written("a\xFF"
                          "b",
                          "\"a\\ufffdb\"");
    assert_string_written("\xC0\xAF", "\"\\ufffd\\ufffd\"");             /* overlong '/' */
    assert_string_written("\xED\xA0\x80", "\"\\ufffd\\ufffd\\ufffd\"");  /* surrogate */
    assert_string_written("\xE2\x82", "\"\\ufffd\\ufffd\"");              /* cut off */
    assert_string_written(NULL, "null");
}

static void doubles_read_back_equal(void **state)
{
    (void)state;
    const double values[] = {0, -0.0, 0.1, 1.0 / 3, 1e300, 5e-324, 123456789.123456789, 1e15, 16.6, (double)0.02f};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        kd_json j = {0};
        kd_json_double(&j, values[i]);
        double back = strtod(kd_json_text(&j), NULL);
        assert_memory_equal(&back, &values[i], sizeof back);
        kd_json_fini(&j);
    }
    kd_json j = {0};
    kd_json_double(&j, 16.6);
    assert_string_equal(kd_json_text(&j), "16.6");
    kd_json_fini(&j);
}

static void what_is_no_number_becomes_null(void **state)
{
    (void)state;
    kd_json j = {0};
    kd_json_array_begin(&j);
    kd_json_double(&j, (double)NAN);
    kd_json_double(&j, (double)INFINITY);
    kd_json_double(&j, -(double)INFINITY);
    kd_json_array_end(&j);
    assert_string_equal(kd_json_text(&j), "[null,null,null]");
    kd_json_fini(&j);
}

static char caught[2048];
static void catch_message(void *user, kd_log_level level, const char *text)
{
    *(kd_log_level *)user = level;
    strncpy(caught, text, sizeof caught - 1);
}

static void fail_logs_whole_message_and_returns_status(void **state)
{
    (void)state;
    kd_log_level level = KD_LOG_DEBUG;
    char longer[1500];
    memset(longer, 'x', sizeof longer - 1);
    longer[sizeof longer - 1] = '\0';
    kd_log_set_sink(catch_message, &level);
    int errors = kd_log_count(KD_LOG_ERROR), warnings = kd_log_count(KD_LOG_WARNING);
    assert_int_equal(kd_fail(KD_BAD_FORMAT, "%s!", longer), KD_BAD_FORMAT);
    assert_int_equal(level, KD_LOG_ERROR);
    assert_int_equal(strlen(caught), 1500);
    assert_int_equal(caught[1499], '!');
    kd_log(KD_LOG_WARNING, "w");
    assert_int_equal(kd_log_count(KD_LOG_ERROR), errors + 1);
    assert_int_equal(kd_log_count(KD_LOG_WARNING), warnings + 1);
    kd_log_set_sink(NULL, NULL);
}

static void every_status_has_a_text(void **state)
{
    (void)state;
    for (int s = 0; s < KD_STATUS_COUNT; s++)
        assert_true(strlen(kd_status_text((kd_status)s)) > 3);
    assert_non_null(kd_status_text((kd_status)999));
    assert_string_equal(kd_status_text(KD_DISK_FULL), "no space left on the disk");
}

static void clock_never_goes_back(void **state)
{
    (void)state;
    uint64_t last = kd_clock_ns();
    for (int i = 0; i < 10000; i++) {
        uint64_t now = kd_clock_ns();
        assert_true(now >= last);
        last = now;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nested_containers_get_their_commas),
        cmocka_unit_test(indent_breaks_lines),
        cmocka_unit_test(strings_are_escaped),
        cmocka_unit_test(doubles_read_back_equal),
        cmocka_unit_test(what_is_no_number_becomes_null),
        cmocka_unit_test(fail_logs_whole_message_and_returns_status),
        cmocka_unit_test(every_status_has_a_text),
        cmocka_unit_test(clock_never_goes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
