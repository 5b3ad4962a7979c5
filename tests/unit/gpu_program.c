#include "tests/gpu_fixture.h"

static const char *const comp = "layout(local_size_x = 4) in;\n"
                                "layout(std430, binding = 0) buffer Values { uint values[]; };\n";

static void write_comp(const char *name, const char *head, const char *body)
{
    char text[2048];
    snprintf(text, sizeof text, "%s%s%s", head, comp, body);
    fixture_write(name, text);
}

static kd_gpu_program make_compute(kd_gpu *gpu, const char *path)
{
    return kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = path});
}

static void program_uses_includes_and_defines(void **state)
{
    const char *const defines[] = {"ADD 7u", NULL};
    uint32_t values[4];
    kd_gpu *gpu = *state;
    fixture_write("twice.glsl", "uint twice(uint x) { return 2u * x; }\n");
    write_comp("a.comp", "#include \"shaders/t/twice.glsl\"\n",
               "void main() { values[gl_GlobalInvocationID.x] = twice(gl_GlobalInvocationID.x) + ADD; }\n");
    kd_gpu_program program =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/t/a.comp", .defines = defines});
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizeof values});
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_dispatch(gpu, program, 1, 1, 1);
    kd_gpu_read_buffer(gpu, buffer, 0, values, sizeof values);
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(values[i], 2 * i + 7);
    fixture_assert_clean(gpu);
}

static void program_shares_a_header_with_c(void **state)
{
    kd_gpu *gpu = *state;
    fixture_write("shared.h",
                  "#ifndef SHARED_H\n#define SHARED_H\n#ifndef KD_GLSL\n#include <stdint.h>\n#endif\n"
                  "struct shared_row { uint a; };\n#endif\n");
    write_comp("a.comp", "#include \"shaders/t/shared.h\"\n",
               "void main() { shared_row row = shared_row(3u); values[0] = row.a; }\n");
    assert_int_not_equal(make_compute(gpu, "shaders/t/a.comp").id, 0);
    fixture_assert_clean(gpu);
}

static void program_error_names_file_and_line_of_the_include(void **state)
{
    kd_gpu *gpu = *state;
    fixture_write("wrong.glsl", "float fine;\n\nfloat bad() { return undeclared_name; }\n");
    write_comp("a.comp", "#include \"shaders/t/wrong.glsl\"\n", "void main() {}\n");
    assert_int_equal(make_compute(gpu, "shaders/t/a.comp").id, 0);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("shaders/t/wrong.glsl:3: "));
    assert_true(fixture_logged("undeclared_name"));
}

static void program_error_counts_lines_behind_an_include(void **state)
{
    kd_gpu *gpu = *state;
    fixture_write("fine.glsl", "float a;\nfloat b;\nfloat c;\n");
    write_comp("a.comp", "#include \"shaders/t/fine.glsl\"\n", "void main() { values[0] = oops; }\n");
    assert_int_equal(make_compute(gpu, "shaders/t/a.comp").id, 0);
    assert_true(fixture_logged("shaders/t/a.comp:4: ")); /* the include, two lines of head, then main */
}

static void program_error_names_a_missing_include_where_it_stands(void **state)
{
    kd_gpu *gpu = *state;
    write_comp("a.comp", "\n#include \"shaders/t/gone.glsl\"\n", "void main() {}\n");
    assert_int_equal(make_compute(gpu, "shaders/t/a.comp").id, 0);
    assert_true(fixture_logged("shaders/t/a.comp:2: "));
    assert_true(fixture_logged("shaders/t/gone.glsl"));
}

static void program_error_names_stages_that_do_not_link(void **state)
{
    kd_gpu *gpu = *state;
    fixture_write(
        "a.vert",
        "layout(location = 0) out vec4 color;\nvoid main() { color = vec4(1); gl_Position = vec4(0); }\n");
    fixture_write("a.frag",
                  "layout(location = 0) in flat uint color;\nlayout(location = 0) out vec4 result;\n"
                  "void main() { result = vec4(color); }\n");
    kd_gpu_program program = kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.vertex = "shaders/t/a.vert", .fragment = "shaders/t/a.frag"});
    assert_int_equal(program.id, 0);
    assert_true(fixture_logged("shaders/t/a.frag: the stages do not link"));
}

static void program_that_is_missing_is_named(void **state)
{
    kd_gpu *gpu = *state;
    assert_int_equal(make_compute(gpu, "shaders/t/none.comp").id, 0);
    assert_true(fixture_logged("shaders/t/none.comp"));
}

static void failed_program_dispatches_nothing(void **state)
{
    uint32_t value = 0;
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 4, .zeroed = true});
    kd_gpu_bind_storage(gpu, 0, buffer);
    assert_false(kd_gpu_failed(gpu));
    kd_gpu_dispatch(gpu, (kd_gpu_program){0}, 1, 1, 1);
    kd_gpu_dispatch_indirect(gpu, (kd_gpu_program){0}, buffer, 0);
    kd_gpu_read_buffer(gpu, buffer, 0, &value, 4);
    assert_int_equal(value, 0);
    assert_true(kd_gpu_failed(gpu));
}

static void program_used_after_its_end_is_noticed(void **state)
{
    kd_gpu *gpu = *state;
    write_comp("a.comp", "", "void main() {}\n");
    kd_gpu_program program = make_compute(gpu, "shaders/t/a.comp");
    kd_gpu_dispatch(gpu, program, 1, 1, 1);
    kd_gpu_destroy_program(gpu, program);
    assert_false(kd_gpu_failed(gpu));
    kd_gpu_dispatch(gpu, program, 1, 1, 1);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("destroyed before"));
}

/* What a program writes into the first value. */
static uint32_t run(kd_gpu *gpu, kd_gpu_program program, kd_gpu_buffer buffer)
{
    uint32_t value = 0;
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_dispatch(gpu, program, 1, 1, 1);
    kd_gpu_read_buffer(gpu, buffer, 0, &value, sizeof value);
    return value;
}

/* Equal programs are one to the driver. Each may end, or be made anew, and the others serve on. */
static void equal_programs_are_independent(void **state)
{
    kd_gpu *gpu = *state;
    const char *const defines[] = {"MORE 1u", NULL};
    uint32_t count = 0;
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 16});
    write_comp("a.comp", "#ifndef MORE\n#define MORE 0u\n#endif\n",
               "void main() { values[0] = 5u + MORE; }\n");
    const kd_gpu_program_desc other = {.compute = "shaders/t/a.comp", .defines = defines};
    kd_gpu_program a = make_compute(gpu, "shaders/t/a.comp"), b = make_compute(gpu, "shaders/t/a.comp");
    kd_gpu_program c = kd_gpu_make_program(gpu, &other), d = make_compute(gpu, "shaders/t/a.comp");
    assert_true(a.id != b.id && b.id != c.id && c.id != d.id && a.id != d.id);
    kd_gpu_destroy_program(gpu, a);
    assert_int_equal(run(gpu, b, buffer), 5);
    assert_int_equal(run(gpu, c, buffer), 6);
    write_comp("a.comp", "#ifndef MORE\n#define MORE 0u\n#endif\n",
               "void main() { values[0] = 50u + MORE; }\n");
    assert_int_equal(kd_gpu_reload_programs(gpu, NULL, NULL, &count), KD_OK);
    assert_int_equal(count, 3);
    assert_int_equal(run(gpu, b, buffer), 50);
    assert_int_equal(run(gpu, c, buffer), 51);
    kd_gpu_destroy_program(gpu, b);
    assert_int_equal(run(gpu, d, buffer), 50);
    fixture_assert_clean(gpu);
    /* One that does not compile stays what it was, and is no model for others. */
    write_comp("a.comp", "", "void main() { this is wrong; }\n");
    assert_int_not_equal(kd_gpu_reload_programs(gpu, NULL, NULL, &count), KD_OK);
    assert_int_equal(run(gpu, d, buffer), 50);
    assert_int_equal(make_compute(gpu, "shaders/t/a.comp").id, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(program_uses_includes_and_defines),
        FIXTURE_TEST(program_shares_a_header_with_c),
        FIXTURE_TEST(program_error_names_file_and_line_of_the_include),
        FIXTURE_TEST(program_error_counts_lines_behind_an_include),
        FIXTURE_TEST(program_error_names_a_missing_include_where_it_stands),
        FIXTURE_TEST(program_error_names_stages_that_do_not_link),
        FIXTURE_TEST(program_that_is_missing_is_named),
        FIXTURE_TEST(failed_program_dispatches_nothing),
        FIXTURE_TEST(program_used_after_its_end_is_noticed),
        FIXTURE_TEST(equal_programs_are_independent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
