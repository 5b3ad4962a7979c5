#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/core/json.h"

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
    assert_string_written("\xC3\xA9 \xE2\x82\xAC \xF0\x9F\x98\x80",
                          "\"\xC3\xA9 \xE2\x82\xAC \xF0\x9F\x98\x80\"");
    assert_string_written("a\xFF"
                          "b",
                          "\"a\\ufffdb\"");
    assert_string_written("\xC0\xAF", "\"\\ufffd\\ufffd\"");            /* overlong '/' */
    assert_string_written("\xED\xA0\x80", "\"\\ufffd\\ufffd\\ufffd\""); /* surrogate */
    assert_string_written("\xE2\x82", "\"\\ufffd\\ufffd\"");            /* cut off */
    assert_string_written(NULL, "null");
}

static void doubles_read_back_equal(void **state)
{
    (void)state;
    const double values[] = {0,    -0.0, 0.1,          1.0 / 3, 1e300, 5e-324, 123456789.123456789,
                             1e15, 16.6, (double)0.02f};
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nested_containers_get_their_commas),
        cmocka_unit_test(indent_breaks_lines),
        cmocka_unit_test(strings_are_escaped),
        cmocka_unit_test(doubles_read_back_equal),
        cmocka_unit_test(what_is_no_number_becomes_null),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
