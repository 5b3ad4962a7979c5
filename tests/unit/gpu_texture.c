#include "tests/gpu_fixture.h"

static void every_format_and_kind_can_be_made_written_and_read(void **state)
{
    kd_gpu *gpu = *state;
    for (int format = 0; format < KD_TEXTURE_FORMAT_COUNT; format++) {
        bool depth = format == KD_DEPTH32F || format == KD_DEPTH24;
        for (int kind = KD_TEXTURE_2D; kind <= KD_TEXTURE_CUBE; kind++) {
            if (depth && kind == KD_TEXTURE_3D) /* GL has no 3D depth textures */
                continue;
            uint8_t zeros[6 * 8 * 8 * 16] = {0}, out[6 * 8 * 8 * 16];
            kd_gpu_texture texture =
                kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = (kd_texture_kind)kind,
                                                                .format = (kd_texture_format)format,
                                                                .width = 8,
                                                                .height = 8,
                                                                .depth = 3,
                                                                .levels = 2,
                                                                .data = zeros});
            if (!texture.id)
                fail_msg("format %d, kind %d: %s", format, kind, fixture_text);
            memset(out, 0xff, sizeof out);
            kd_gpu_clear_texture(gpu, texture, 1, NULL);
            kd_gpu_read_texture(gpu, texture, 0, out, sizeof out);
            assert_int_equal(out[0], 0);
            kd_gpu_destroy_texture(gpu, texture);
        }
    }
    fixture_assert_clean(gpu);
}

/* 1, 0.5 and 2 of 9 bits under 2^(16 - 24): what an image of words holds is sampled as a colour. */
static void view_shows_a_texture_in_another_format(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_texture_desc desc = {
        .kind = KD_TEXTURE_3D, .format = KD_R32UI, .width = 1, .height = 1, .depth = 2};
    kd_gpu_texture words = kd_gpu_make_texture(gpu, &desc);
    size_t bytes = kd_gpu_bytes(gpu);
    uint32_t word = 256u | 128u << 9 | 511u << 18 | 16u << 27, out[2];
    kd_gpu_texture view = kd_gpu_make_texture_view(gpu, words, &(kd_gpu_texture_desc){.format = KD_RGB9E5});
    kd_gpu_clear_texture(gpu, words, 0, &word);
    kd_gpu_read_texture(gpu, view, 0, out, sizeof out);
    assert_int_equal(out[0], word);
    assert_int_equal(out[1], word);
    assert_int_equal(kd_gpu_bytes(gpu), bytes);
    kd_gpu_destroy_texture(gpu, view);
    fixture_assert_clean(gpu);
    view =
        kd_gpu_make_texture_view(gpu, words, &(kd_gpu_texture_desc){.format = KD_RGBA16F}); /* 8 bytes of 4 */
    assert_int_equal(view.id, 0);
    assert_true(kd_gpu_failed(gpu));
}

static void texture_layers_are_written_one_by_one(void **state)
{
    uint32_t layer[4] = {1, 2, 3, 4}, out[12];
    kd_gpu *gpu = *state;
    kd_gpu_texture texture = kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){
                 .kind = KD_TEXTURE_3D, .format = KD_R32UI, .width = 2, .height = 2, .depth = 3});
    kd_gpu_clear_texture(gpu, texture, 0, &(uint32_t){9});
    kd_gpu_write_texture(gpu, texture, 0, 1, layer, sizeof layer);
    kd_gpu_read_texture(gpu, texture, 0, out, sizeof out);
    for (uint32_t i = 0; i < 12; i++)
        assert_int_equal(out[i], i >= 4 && i < 8 ? i - 3 : 9);
    fixture_assert_clean(gpu);
    kd_gpu_write_texture(gpu, texture, 0, 3, layer, sizeof layer);
    assert_true(kd_gpu_failed(gpu));
}

/* Layer 2 of one array becomes layer 0 of another; the rest of both stays. Depth goes as colour does. */
static void layers_are_copied_between_textures(void **state)
{
    kd_gpu *gpu = *state;
    const kd_texture_format formats[] = {KD_R32UI, KD_DEPTH32F};
    for (int f = 0; f < 2; f++) {
        uint32_t out[8], data[12];
        for (uint32_t i = 0; i < 12; i++) {
            float depth = (float)i / 16;
            memcpy(&data[i], &depth, sizeof depth);
        }
        kd_gpu_texture_desc desc = {.kind = KD_TEXTURE_2D_ARRAY,
                                    .format = formats[f],
                                    .width = 2,
                                    .height = 2,
                                    .depth = 3,
                                    .data = data};
        kd_gpu_texture from = kd_gpu_make_texture(gpu, &desc);
        desc.depth = 2;
        kd_gpu_texture to = kd_gpu_make_texture(gpu, &desc);
        kd_gpu_copy_texture(gpu, from, 2, to, 0, 0);
        kd_gpu_read_texture(gpu, to, 0, out, sizeof out);
        assert_memory_equal(out, data + 8, 16);
        assert_memory_equal(out + 4, data + 4, 16);
        fixture_assert_clean(gpu);
        kd_gpu_destroy_texture(gpu, from);
        kd_gpu_destroy_texture(gpu, to);
    }
}

static void copy_that_does_not_fit_is_refused(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_texture small = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_R32UI, .width = 2});
    kd_gpu_texture large = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_R32UI, .width = 3});
    kd_gpu_copy_texture(gpu, small, 0, large, 0, 0);
    assert_true(kd_gpu_failed(gpu));
}

static void mips_average_level_zero(void **state)
{
    const uint8_t texels[4][4] = {{0, 0, 0, 0}, {40, 0, 0, 0}, {80, 0, 0, 0}, {120, 0, 0, 0}};
    uint8_t out[4];
    kd_gpu *gpu = *state;
    kd_gpu_texture texture = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_RGBA8,
                                                                             .width = 2,
                                                                             .height = 2,
                                                                             .data = texels,
                                                                             .levels = UINT32_MAX,
                                                                             .generate_mips = true});
    kd_gpu_read_texture(gpu, texture, 1, out, 4);
    assert_in_range(out[0], 59, 61); /* (0 + 40 + 80 + 120) / 4, a step of rounding either way */
    fixture_assert_clean(gpu);
}

/* Sample `texture` in a compute shader: the body sets `result`. */
static void sample(kd_gpu *gpu, const char *sampler, const char *body, kd_gpu_texture texture,
                   float result[4])
{
    char text[1024];
    snprintf(text, sizeof text,
             "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer Out { vec4 result; };\n"
             "layout(binding = 3) uniform %s map;\nvoid main() { %s }\n",
             sampler, body);
    fixture_write("s.comp", text);
    kd_gpu_program program = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/t/s.comp"});
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 16, .zeroed = true});
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_bind_texture(gpu, 3, texture);
    kd_gpu_dispatch(gpu, program, 1, 1, 1);
    kd_gpu_read_buffer(gpu, buffer, 0, result, 16);
    kd_gpu_destroy_buffer(gpu, buffer);
    kd_gpu_destroy_program(gpu, program);
}

static void shadow_filter_compares_less_or_equal(void **state)
{
    const float depths[4] = {0.5f, 0.5f, 0.5f, 0.5f};
    float result[4];
    kd_gpu *gpu = *state;
    kd_gpu_texture map = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_DEPTH32F,
                                                                         .width = 2,
                                                                         .height = 2,
                                                                         .data = depths,
                                                                         .filter = KD_SHADOW,
                                                                         .wrap_s = KD_BORDER_ONE,
                                                                         .wrap_t = KD_BORDER_ONE});
    sample(gpu, "sampler2DShadow",
           "result = vec4(textureLod(map, vec3(0.5, 0.5, 0.4), 0), textureLod(map, vec3(0.5, 0.5, 0.5), 0), "
           "textureLod(map, vec3(0.5, 0.5, 0.6), 0), textureLod(map, vec3(3.0, 3.0, 0.9), 0));",
           map, result);
    assert_float_equal(result[0], 1, 0); /* nearer than the occluder: lit */
    assert_float_equal(result[1], 1, 0); /* at the occluder */
    assert_float_equal(result[2], 0, 0);
    assert_float_equal(result[3], 1, 0); /* the border is at depth 1 */
    fixture_assert_clean(gpu);
}

static void lod_picks_a_level_under_every_filter(void **state)
{
    const kd_filter filters[] = {KD_LINEAR, KD_NEAREST, KD_LINEAR_MIP};
    kd_gpu *gpu = *state;
    for (int i = 0; i < 3; i++) {
        float result[4];
        kd_gpu_texture map = kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.kind = KD_TEXTURE_3D,
                                                                             .format = KD_R32F,
                                                                             .width = 4,
                                                                             .height = 4,
                                                                             .depth = 4,
                                                                             .levels = 3,
                                                                             .filter = filters[i]});
        for (uint32_t level = 0; level < 3; level++)
            kd_gpu_clear_texture(gpu, map, level, &(float){(float)level});
        sample(gpu, "sampler3D",
               "result = vec4(textureLod(map, vec3(0.5), 0).x, textureLod(map, vec3(0.5), 2).x, 0, 0);", map,
               result);
        assert_float_equal(result[0], 0, 0);
        assert_float_equal(result[1], 2, 0);
        kd_gpu_destroy_texture(gpu, map);
    }
    fixture_assert_clean(gpu);
}

static void texel_buffer_reads_its_buffer(void **state)
{
    const uint32_t words[4] = {10, 20, 30, 40};
    float result[4];
    kd_gpu *gpu = *state;
    kd_gpu_buffer buffer =
        kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = sizeof words, .data = words});
    kd_gpu_texture view = kd_gpu_make_texel_buffer(gpu, buffer, KD_R32UI);
    sample(gpu, "usamplerBuffer", "for (int i = 0; i < 4; i++) result[i] = float(texelFetch(map, i).x);",
           view, result);
    for (int i = 0; i < 4; i++)
        assert_float_equal(result[i], (float)words[i], 0);
    fixture_assert_clean(gpu);
    assert_int_equal(kd_gpu_make_texel_buffer(gpu, buffer, KD_DEPTH24).id, 0);
    assert_true(kd_gpu_failed(gpu));
}

static void image_is_written_and_reinterpreted(void **state)
{
    uint8_t out[8 * 8 * 4];
    kd_gpu *gpu = *state;
    fixture_write("i.comp",
                  "layout(local_size_x = 8, local_size_y = 8) in;\n"
                  "layout(r32ui, binding = 2) uniform writeonly uimage2D map;\n"
                  "void main() { imageStore(map, ivec2(gl_GlobalInvocationID.xy), uvec4(0x04030201u)); }\n");
    kd_gpu_program program = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/t/i.comp"});
    kd_gpu_texture map =
        kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_RGBA8, .width = 8, .height = 8});
    kd_gpu_bind_image(gpu, 2, map, 0, KD_IMAGE_WRITE, KD_R32UI);
    kd_gpu_dispatch(gpu, program, 1, 1, 1);
    kd_gpu_read_texture(gpu, map, 0, out, sizeof out);
    for (size_t i = 0; i < sizeof out; i++)
        assert_int_equal(out[i], i % 4 + 1);
    fixture_assert_clean(gpu);
    kd_gpu_bind_image(gpu, 2, map, 0, KD_IMAGE_WRITE, KD_RGBA16F); /* texels of another size */
    assert_true(kd_gpu_failed(gpu));
}

static void texture_that_cannot_be_is_named(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_texture_desc desc = {.format = KD_RGBA8, .width = 1u << 24, .height = 4, .name = "wide"};
    assert_int_equal(kd_gpu_make_texture(gpu, &desc).id, 0);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("texture wide"));
    desc = (kd_gpu_texture_desc){.format = KD_RGBA8, .width = 4, .height = 4, .levels = 4, .name = "deep"};
    assert_int_equal(kd_gpu_make_texture(gpu, &desc).id, 0);
    assert_true(fixture_logged("texture deep"));
    desc = (kd_gpu_texture_desc){
        .kind = KD_TEXTURE_CUBE, .format = KD_RGBA8, .width = 4, .height = 8, .name = "cuboid"};
    assert_int_equal(kd_gpu_make_texture(gpu, &desc).id, 0);
    assert_true(fixture_logged("texture cuboid"));
}

static void failed_texture_is_harmless(void **state)
{
    uint32_t word = 1;
    kd_gpu *gpu = *state;
    kd_gpu_texture none = {0};
    kd_gpu_destroy_texture(gpu, none);
    assert_false(kd_gpu_failed(gpu));
    kd_gpu_bind_texture(gpu, 0, none);
    kd_gpu_bind_image(gpu, 0, none, 0, KD_IMAGE_READ, KD_RGBA8);
    kd_gpu_write_texture(gpu, none, 0, 0, &word, 4);
    kd_gpu_clear_texture(gpu, none, 0, NULL);
    kd_gpu_read_texture(gpu, none, 0, &word, 4);
    assert_int_equal(word, 0);
    assert_int_equal(kd_gpu_make_target(gpu, &(kd_gpu_target_desc){0}).id, 0);
    assert_true(kd_gpu_failed(gpu));
}

static void texture_used_after_its_end_is_noticed(void **state)
{
    kd_gpu *gpu = *state;
    kd_gpu_texture_desc desc = {.format = KD_R8, .width = 1, .height = 1};
    kd_gpu_texture old = kd_gpu_make_texture(gpu, &desc);
    kd_gpu_bind_texture(gpu, 0, old);
    kd_gpu_destroy_texture(gpu, old);
    kd_gpu_make_texture(gpu, &desc);
    assert_false(kd_gpu_failed(gpu));
    kd_gpu_bind_texture(gpu, 0, old);
    assert_true(kd_gpu_failed(gpu));
    assert_true(fixture_logged("bind_texture: the texture was destroyed before"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(every_format_and_kind_can_be_made_written_and_read),
        FIXTURE_TEST(view_shows_a_texture_in_another_format),
        FIXTURE_TEST(texture_layers_are_written_one_by_one),
        FIXTURE_TEST(layers_are_copied_between_textures),
        FIXTURE_TEST(copy_that_does_not_fit_is_refused),
        FIXTURE_TEST(mips_average_level_zero),
        FIXTURE_TEST(shadow_filter_compares_less_or_equal),
        FIXTURE_TEST(lod_picks_a_level_under_every_filter),
        FIXTURE_TEST(texel_buffer_reads_its_buffer),
        FIXTURE_TEST(image_is_written_and_reinterpreted),
        FIXTURE_TEST(texture_that_cannot_be_is_named),
        FIXTURE_TEST(failed_texture_is_harmless),
        FIXTURE_TEST(texture_used_after_its_end_is_noticed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
