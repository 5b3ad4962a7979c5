#ifndef KD_TESTS_CONTEXT_USE_H
#define KD_TESTS_CONTEXT_USE_H

/* Use a context of any kind for real: a compute pass with an include, an indirect one, a picture, a readback.
 */

#include "tests/gpu_fixture.h"

enum { USE_WORDS = 256 };

static inline kd_gpu *context_open(kd_context_api api, bool window)
{
    kd_gpu *gpu = NULL;
    kd_gpu_desc desc = {.api = api, .window = window, .width = 64, .height = 48, .debug = true};
    return kd_gpu_open(&desc, &gpu) == KD_OK ? gpu : NULL;
}

static inline void context_compute(kd_gpu *gpu)
{
    uint32_t words[USE_WORDS];
    const uint32_t params[4] = {11}, groups[4] = {0, USE_WORDS / 2 / 64, 1, 1};
    fixture_write("square.glsl", "uint square(uint x) { return x * x; }\n");
    fixture_write("use.comp",
                  "#include \"shaders/t/square.glsl\"\nlayout(local_size_x = 64) in;\n"
                  "layout(std430, binding = 0) buffer Words { uint words[]; };\n"
                  "layout(std140, binding = 0) uniform Params { uint add; };\n"
                  "void main() { uint i = gl_GlobalInvocationID.x; words[i] += square(i) + add; }\n");
    kd_gpu_program program =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/t/use.comp"});
    kd_gpu_buffer buffer =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizeof words, .zeroed = true});
    kd_gpu_buffer args =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizeof groups, .data = groups});
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_bind_uniform(gpu, 0, params, sizeof params);
    kd_gpu_dispatch(gpu, program, USE_WORDS / 64, 1, 1);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_dispatch_indirect(gpu, program, args, 4); /* the lower half once more */
    kd_gpu_read_buffer(gpu, buffer, 0, words, sizeof words);
    for (uint32_t i = 0; i < USE_WORDS; i++)
        assert_int_equal(words[i], (i * i + 11) * (i < USE_WORDS / 2 ? 2 : 1));
}

static inline void context_draw(kd_gpu *gpu)
{
    enum { SIDE = 8 };
    uint64_t tag = 0;
    size_t size = 0;
    fixture_write(
        "use.vert",
        "void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }\n");
    fixture_write("use.frag", "layout(location = 0) out vec4 color;\n"
                              "void main() { color = vec4(1, gl_FragCoord.x < 4.0 ? 1 : 0, 0, 1); }\n");
    kd_gpu_program program = kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.vertex = "shaders/t/use.vert", .fragment = "shaders/t/use.frag"});
    kd_gpu_texture color = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.width = SIDE, .height = SIDE});
    kd_gpu_target target = kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.color = {color}});
    kd_gpu_readback ring = kd_gpu_make_readback(gpu, SIDE * SIDE * 4, 0, "picture");
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = target, .clear_color = true});
    kd_gpu_draw_procedural(gpu, program, 3, 1);
    assert_int_equal(kd_gpu_readback_texture(gpu, ring, color, 0, 3), KD_OK);
    const uint8_t *pixels = kd_gpu_readback_poll(gpu, ring, true, &tag, &size);
    assert_non_null(pixels);
    for (int i = 0; i < SIDE * SIDE; i++) {
        assert_int_equal(pixels[i * 4], 255);
        assert_int_equal(pixels[i * 4 + 1], i % SIDE < 4 ? 255 : 0);
        assert_int_equal(pixels[i * 4 + 2], 0);
    }
}

static inline void context_use(kd_gpu *gpu)
{
    context_compute(gpu);
    context_draw(gpu);
    fixture_assert_clean(gpu);
}

static inline int context_setup(void **state)
{
    (void)state;
    fixture_init();
    return 0;
}

static inline int context_teardown(void **state)
{
    (void)state;
    fixture_fini();
    return 0;
}

#define CONTEXT_TEST(name) cmocka_unit_test_setup_teardown(name, context_setup, context_teardown)

#endif
