#include "runtime/gpu/embedded.h"
#include "runtime/gpu/source.h"
#include "tests/gpu_fixture.h"

static int setup(void **state)
{
    (void)state;
    fixture_init();
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    fixture_fini();
    return 0;
}

static int count(const char *text, const char *word)
{
    int found = 0;
    for (const char *at = text; (at = strstr(at, word)) != NULL; at += strlen(word))
        found++;
    return found;
}

static void source_starts_with_version_and_defines(void **state)
{
    const char *const defines[] = {"SIZE 8", "FAST", NULL};
    const char *expected =
        "#version 450 core\n#define KD_GLSL 1\n#define SIZE 8\n#define FAST\n#line 1 0\nvoid main() {}\n";
    gpu_source source = {0};
    (void)state;
    fixture_write("a.comp", "void main() {}");
    assert_true(gpu_source_expand(&source, "shaders/t/a.comp", defines));
    assert_string_equal(source.text, expected);
    gpu_source_fini(&source);
}

static void source_includes_a_file_once_and_counts_lines_on(void **state)
{
    gpu_source source = {0};
    (void)state;
    fixture_write("leaf.glsl", "float leaf;\n");
    fixture_write("node.glsl", "#include \"shaders/t/leaf.glsl\"\nfloat node;\n");
    fixture_write("a.comp",
                  "# include  \"shaders/t/node.glsl\"\n#include \"shaders/t/leaf.glsl\"\nfloat a;\n");
    assert_true(gpu_source_expand(&source, "shaders/t/a.comp", NULL));
    assert_int_equal(count(source.text, "float leaf;"), 1);
    assert_int_equal(source.path_count, 3);
    /* node is file 1, leaf file 2; behind the leaf comes line 2 of node, behind node line 2 of the main file,
     * whose second include gives an empty line. */
    assert_string_equal(strstr(source.text, "#line 1 0"),
                        "#line 1 0\n#line 1 1\n#line 1 2\nfloat leaf;\n#line 2 1\n"
                        "float node;\n#line 2 0\n\nfloat a;\n");
    gpu_source_fini(&source);
}

static void source_includes_itself_only_once(void **state)
{
    gpu_source source = {0};
    (void)state;
    fixture_write("a.comp", "#include \"shaders/t/a.comp\"\nfloat a;\n");
    assert_true(gpu_source_expand(&source, "shaders/t/a.comp", NULL));
    assert_int_equal(count(source.text, "float a;"), 1);
    gpu_source_fini(&source);
}

static void source_leaves_includes_in_comments_alone(void **state)
{
    gpu_source source = {0};
    (void)state;
    fixture_write("leaf.glsl", "float leaf;\n");
    fixture_write("a.comp",
                  "/* text\n#include \"shaders/t/leaf.glsl\"\n*/\n// #include \"shaders/t/leaf.glsl\"\n");
    assert_true(gpu_source_expand(&source, "shaders/t/a.comp", NULL));
    assert_int_equal(count(source.text, "float leaf;"), 0);
    gpu_source_fini(&source);
}

static void source_turns_a_missing_include_into_an_error_line(void **state)
{
    gpu_source source = {0};
    (void)state;
    fixture_write("a.comp",
                  "#include \"shaders/t/gone.glsl\"\n#include <stdint.h>\n#include \"../../etc/passwd\"\n");
    assert_true(gpu_source_expand(&source, "shaders/t/a.comp", NULL));
    assert_int_equal(count(source.text, "#error cannot include"), 3);
    assert_non_null(strstr(source.text, "shaders/t/gone.glsl"));
    gpu_source_fini(&source);
}

static void source_names_a_missing_file(void **state)
{
    gpu_source source = {0};
    (void)state;
    assert_false(gpu_source_expand(&source, "shaders/t/none.comp", NULL));
    assert_non_null(strstr(source.error, "shaders/t/none.comp"));
    assert_non_null(strstr(source.error, fixture_folder));
    gpu_source_fini(&source);
}

static void source_stops_at_too_many_files(void **state)
{
    gpu_source source = {0};
    char name[32], text[64];
    (void)state;
    /* Each file includes the next: deeper than 16 is refused as a missing include, never a crash. */
    for (int i = 0; i < 24; i++) {
        snprintf(name, sizeof name, "%d.glsl", i);
        snprintf(text, sizeof text, "#include \"shaders/t/%d.glsl\"\n", i + 1);
        fixture_write(name, text);
    }
    assert_true(gpu_source_expand(&source, "shaders/t/0.glsl", NULL));
    assert_int_equal(source.path_count, 17);
    assert_int_equal(count(source.text, "#error"), 1);
    gpu_source_fini(&source);
}

static void source_comes_from_the_program_without_a_folder(void **state)
{
    (void)state;
    assert_int_equal(unsetenv("KANDIL_SHADER_DIR"), 0);
    for (const kd_embedded_shader *shader = kd_embedded_shaders; shader->path; shader++) {
        gpu_source source = {0};
        assert_int_equal(strlen(shader->text), shader->size);
        assert_true(gpu_source_expand(&source, shader->path, NULL));
        assert_string_equal(source.paths[0], shader->path);
        gpu_source_fini(&source);
    }
    gpu_source missing = {0};
    assert_false(gpu_source_expand(&missing, "shaders/t/none.comp", NULL));
    assert_non_null(strstr(missing.error, "in the program"));
    gpu_source_fini(&missing);
}

static void assert_translated(const gpu_source *source, const char *line, const char *expected)
{
    char out[256];
    gpu_source_translate(source, line, strlen(line), out, sizeof out);
    assert_string_equal(out, expected);
}

static void translate_reads_the_messages_of_all_compilers(void **state)
{
    char first[] = "shaders/a.comp", second[] = "shaders/b.glsl";
    gpu_source source = {.paths = {first, second}, .path_count = 2};
    (void)state;
    assert_translated(&source, "0:12(5): error: x undeclared", "shaders/a.comp:12: error: x undeclared");
    assert_translated(&source, "1(7) : error C1503: undefined", "shaders/b.glsl:7: error C1503: undefined");
    assert_translated(&source, "ERROR: 1:3: 'x' : undeclared", "shaders/b.glsl:3: error: 'x' : undeclared");
    assert_translated(&source, "2:1(1): error: beyond", "2:1(1): error: beyond");
    assert_translated(&source, "error: no place", "error: no place");
    assert_translated(&source, "", "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(source_starts_with_version_and_defines, setup, teardown),
        cmocka_unit_test_setup_teardown(source_includes_a_file_once_and_counts_lines_on, setup, teardown),
        cmocka_unit_test_setup_teardown(source_includes_itself_only_once, setup, teardown),
        cmocka_unit_test_setup_teardown(source_leaves_includes_in_comments_alone, setup, teardown),
        cmocka_unit_test_setup_teardown(source_turns_a_missing_include_into_an_error_line, setup, teardown),
        cmocka_unit_test_setup_teardown(source_names_a_missing_file, setup, teardown),
        cmocka_unit_test_setup_teardown(source_stops_at_too_many_files, setup, teardown),
        cmocka_unit_test_setup_teardown(source_comes_from_the_program_without_a_folder, setup, teardown),
        cmocka_unit_test(translate_reads_the_messages_of_all_compilers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
