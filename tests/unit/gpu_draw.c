#include "tests/gpu_fixture.h"

enum { SIDE = 16, PIXELS = SIDE * SIDE };

typedef struct scene {
    kd_gpu_texture color, depth;
    kd_gpu_target target;
    kd_gpu_program
        program; /* attributes: position at 0, colour at 1, per instance, offset at 2, per instance */
    kd_gpu_program triangle; /* procedural: covers everything at the depth and colour of uniform block 0 */
} scene;

static scene make_scene(kd_gpu *gpu)
{
    scene made;
    fixture_write("a.vert", "layout(location = 0) in vec3 position;\nlayout(location = 1) in vec4 color;\n"
                            "layout(location = 2) in vec2 offset;\nlayout(location = 0) out vec4 out_color;\n"
                            "void main() { gl_Position = vec4(position.xy + offset, position.z, 1);"
                            " out_color = color; }\n");
    fixture_write("a.frag", "layout(location = 0) in vec4 color;\nlayout(location = 0) out vec4 result;\n"
                            "void main() { result = color; }\n");
    fixture_write("p.vert", "layout(std140, binding = 0) uniform Params { vec4 color; vec4 depth; };\n"
                            "layout(location = 0) out vec4 out_color;\n"
                            "void main() { vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;\n"
                            "gl_Position = vec4(at, depth.x, 1); out_color = color; }\n");
    made.program = kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.vertex = "shaders/t/a.vert", .fragment = "shaders/t/a.frag"});
    made.triangle = kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.vertex = "shaders/t/p.vert", .fragment = "shaders/t/a.frag"});
    made.color =
        kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_RGBA8, .width = SIDE, .height = SIDE});
    made.depth = kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){.format = KD_DEPTH32F, .width = SIDE, .height = SIDE});
    made.target = kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.color = {made.color}, .depth = made.depth});
    return made;
}

static kd_gpu_buffer make_data(kd_gpu *gpu, const void *data, size_t size)
{
    return kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = size, .data = data});
}

/* A quad over the lower left quarter, counterclockwise. */
static const float quad[4][3] = {{-1, -1, 0}, {0, -1, 0}, {0, 0, 0}, {-1, 0, 0}};
static const uint32_t quad_indices[6] = {0, 1, 2, 0, 2, 3};
/* Four instances: the first stays, the others move to the lower right, upper left and upper right quarter. */
static const float quad_offsets[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
static const uint8_t quad_colors[4][4] = {
    {255, 0, 0, 255}, {0, 255, 0, 255}, {0, 0, 255, 255}, {255, 255, 0, 255}};

static kd_gpu_geometry make_quads(kd_gpu *gpu)
{
    return (kd_gpu_geometry){
        .attributes = {{make_data(gpu, quad, sizeof quad), 0, KD_ATTR_F32X3, 0, 12, false},
                       {make_data(gpu, quad_colors, sizeof quad_colors), 1, KD_ATTR_UNORM8X4, 0, 4, true},
                       {make_data(gpu, quad_offsets, sizeof quad_offsets), 2, KD_ATTR_F32X2, 0, 8, true}},
        .indices = make_data(gpu, quad_indices, sizeof quad_indices)};
}

/* Compare the pixel in the middle of a quarter (0 lower left, 1 lower right, 2 upper left, 3 upper right). */
static void assert_quarter(kd_gpu *gpu, const scene *s, int quarter, uint32_t r, uint32_t g, uint32_t b)
{
    uint8_t pixels[PIXELS][4];
    kd_gpu_read_texture(gpu, s->color, 0, pixels, sizeof pixels);
    const uint8_t *pixel =
        pixels[(quarter / 2 * SIDE / 2 + SIDE / 4) * SIDE + quarter % 2 * SIDE / 2 + SIDE / 4];
    if (pixel[0] != r || pixel[1] != g || pixel[2] != b)
        fail_msg("quarter %d is %d %d %d, not %u %u %u", quarter, pixel[0], pixel[1], pixel[2], r, g, b);
}

static void begin(kd_gpu *gpu, const scene *s)
{
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = s->target, .clear_color = true});
}

static void cover(kd_gpu *gpu, const scene *s, float r, float g, float b, float a, float depth)
{
    const float params[8] = {r, g, b, a, depth};
    kd_gpu_bind_uniform(gpu, 0, params, sizeof params);
    kd_gpu_draw_procedural(gpu, s->triangle, 3, 1);
}

static void triangle_covers_its_half_of_the_target(void **state)
{
    const float corners[3][3] = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}};
    const float red[4] = {1, 0, 0, 1}, no_offset[2] = {0, 0};
    uint8_t pixels[PIXELS][4];
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_geometry geometry = {
        .attributes = {{make_data(gpu, corners, sizeof corners), 0, KD_ATTR_F32X3, 0, 0, false},
                       {make_data(gpu, red, sizeof red), 1, KD_ATTR_F32X4, 0, 0, true},
                       {make_data(gpu, no_offset, 8), 2, KD_ATTR_F32X2, 0, 0, true}}};
    begin(gpu, &s);
    kd_gpu_draw_indexed(gpu, s.program, &geometry, &(kd_draw_indexed){3, 1, 0, 0, 0});
    kd_gpu_read_texture(gpu, s.color, 0, pixels, sizeof pixels);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            if (x + y != SIDE - 1) /* centres on the diagonal may fall to either side */
                assert_int_equal(pixels[y * SIDE + x][0], x + y < SIDE - 1 ? 255 : 0);
    fixture_assert_clean(gpu);
}

static void instances_take_their_own_attributes(void **state)
{
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_geometry quads = make_quads(gpu);
    begin(gpu, &s);
    kd_gpu_draw_indexed(gpu, s.program, &quads, &(kd_draw_indexed){6, 3, 0, 0, 0});
    assert_quarter(gpu, &s, 0, 255, 0, 0);
    assert_quarter(gpu, &s, 1, 0, 255, 0);
    assert_quarter(gpu, &s, 2, 0, 0, 255);
    assert_quarter(gpu, &s, 3, 0, 0, 0);
    fixture_assert_clean(gpu);
}

static void base_instance_moves_the_attributes(void **state)
{
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_geometry quads = make_quads(gpu);
    begin(gpu, &s);
    kd_gpu_draw_indexed(gpu, s.program, &quads, &(kd_draw_indexed){6, 1, 0, 0, 3});
    assert_quarter(gpu, &s, 0, 0, 0, 0);
    assert_quarter(gpu, &s, 3, 255, 255, 0);
    fixture_assert_clean(gpu);
}

static void indirect_draws_read_the_buffer(void **state)
{
    const kd_draw_indexed draws[3] = {{6, 1, 0, 0, 0}, {6, 1, 0, 0, 2}, {6, 1, 0, 0, 3}};
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_geometry quads = make_quads(gpu);
    begin(gpu, &s);
    kd_gpu_draw_indirect(gpu, s.program, &quads, make_data(gpu, draws, sizeof draws), sizeof draws[0], 2);
    assert_quarter(gpu, &s, 0, 0, 0, 0);
    assert_quarter(gpu, &s, 1, 0, 0, 0);
    assert_quarter(gpu, &s, 2, 0, 0, 255);
    assert_quarter(gpu, &s, 3, 255, 255, 0);
    fixture_assert_clean(gpu);
}

static void geometry_changes_between_draws(void **state)
{
    const uint8_t white[4][4] = {
        {255, 255, 255, 255}, {255, 255, 255, 255}, {255, 255, 255, 255}, {255, 255, 255, 255}};
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_geometry quads = make_quads(gpu), other = quads;
    other.attributes[1].buffer = make_data(gpu, white, sizeof white);
    begin(gpu, &s);
    kd_gpu_draw_indexed(gpu, s.program, &quads, &(kd_draw_indexed){6, 1, 0, 0, 0});
    kd_gpu_draw_indexed(gpu, s.program, &other, &(kd_draw_indexed){6, 1, 0, 0, 1});
    kd_gpu_draw_indexed(gpu, s.program, &quads, &(kd_draw_indexed){6, 1, 0, 0, 2});
    assert_quarter(gpu, &s, 0, 255, 0, 0);
    assert_quarter(gpu, &s, 1, 255, 255, 255);
    assert_quarter(gpu, &s, 2, 0, 0, 255);
    fixture_assert_clean(gpu);
}

static void culling_keeps_counterclockwise_faces(void **state)
{
    const struct {
        kd_cull cull;
        uint32_t red;
    } rows[] = {{KD_CULL_BACK, 255}, {KD_CULL_NONE, 255}, {KD_CULL_FRONT, 0}};
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_geometry quads = make_quads(gpu);
    for (int i = 0; i < 3; i++) {
        kd_gpu_begin_raster(gpu,
                            &(kd_gpu_raster){.target = s.target, .clear_color = true, .cull = rows[i].cull});
        kd_gpu_draw_indexed(gpu, s.program, &quads, &(kd_draw_indexed){6, 1, 0, 0, 0});
        assert_quarter(gpu, &s, 0, rows[i].red, 0, 0);
    }
    fixture_assert_clean(gpu);
}

static void depth_keeps_the_nearest_and_equal_matches(void **state)
{
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_raster raster = {.target = s.target,
                            .clear_color = true,
                            .clear_depth = true,
                            .depth_test = true,
                            .depth_write = true};
    kd_gpu_begin_raster(gpu, &raster);
    cover(gpu, &s, 0, 1, 0, 1, 0.5f);
    cover(gpu, &s, 1, 0, 0, 1, 0.75f); /* behind */
    assert_quarter(gpu, &s, 0, 0, 255, 0);
    cover(gpu, &s, 0, 0, 1, 1, 0.5f); /* as near: less or equal passes */
    assert_quarter(gpu, &s, 0, 0, 0, 255);
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = s.target, .depth_equal = true});
    cover(gpu, &s, 1, 1, 1, 1, 0.25f); /* nearer, but not equal */
    assert_quarter(gpu, &s, 0, 0, 0, 255);
    cover(gpu, &s, 1, 0, 1, 1, 0.5f);
    assert_quarter(gpu, &s, 0, 255, 0, 255);
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = s.target});
    cover(gpu, &s, 1, 1, 0, 1, 0.9f); /* no test at all */
    assert_quarter(gpu, &s, 0, 255, 255, 0);
    fixture_assert_clean(gpu);
}

static void depth_clamp_and_bias_apply(void **state)
{
    float depths[PIXELS];
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_raster raster = {.target = s.target,
                            .clear_color = true,
                            .clear_depth = true,
                            .depth_test = true,
                            .depth_write = true};
    kd_gpu_begin_raster(gpu, &raster);
    cover(gpu, &s, 1, 0, 0, 1, -2); /* before the near plane: clipped */
    assert_quarter(gpu, &s, 0, 0, 0, 0);
    raster.depth_clamp = true;
    kd_gpu_begin_raster(gpu, &raster);
    cover(gpu, &s, 1, 0, 0, 1, -2);
    assert_quarter(gpu, &s, 0, 255, 0, 0);
    raster.depth_clamp = false;
    raster.depth_bias_constant = 1000;
    kd_gpu_begin_raster(gpu, &raster);
    cover(gpu, &s, 1, 0, 0, 1, 0);
    kd_gpu_read_texture(gpu, s.depth, 0, depths, sizeof depths);
    assert_true(depths[0] > 0.5f && depths[0] < 0.51f); /* z 0 is depth 0.5, moved away a little */
    fixture_assert_clean(gpu);
}

static void blending_mixes_and_adds(void **state)
{
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_raster raster = {
        .target = s.target, .clear_color = true, .color = {1, 0, 0, 1}, .blend = KD_BLEND_ADD};
    kd_gpu_begin_raster(gpu, &raster);
    cover(gpu, &s, 0, 1, 0, 1, 0);
    assert_quarter(gpu, &s, 3, 255, 255, 0);
    raster.blend = KD_BLEND_ALPHA;
    kd_gpu_begin_raster(gpu, &raster);
    cover(gpu, &s, 0, 0, 1, 0, 0); /* alpha 0 changes nothing, alpha 1 replaces */
    assert_quarter(gpu, &s, 3, 255, 0, 0);
    cover(gpu, &s, 0, 0, 1, 1, 0);
    assert_quarter(gpu, &s, 3, 0, 0, 255);
    fixture_assert_clean(gpu);
}

static void rectangle_limits_the_clear_and_the_draw(void **state)
{
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    begin(gpu, &s);
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = s.target,
                                              .x = SIDE / 2,
                                              .width = SIDE / 2,
                                              .height = SIDE / 2,
                                              .clear_color = true,
                                              .color = {1, 1, 1, 1}});
    assert_quarter(gpu, &s, 0, 0, 0, 0);
    assert_quarter(gpu, &s, 1, 255, 255, 255);
    cover(gpu, &s, 0, 1, 0, 1, 0);
    assert_quarter(gpu, &s, 0, 0, 0, 0);
    assert_quarter(gpu, &s, 1, 0, 255, 0);
    assert_quarter(gpu, &s, 3, 0, 0, 0);
    fixture_assert_clean(gpu);
}

static void target_of_a_layer_draws_to_it_alone(void **state)
{
    float depths[6][PIXELS];
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_texture cube = kd_gpu_make_texture(
        gpu, &(kd_gpu_texture_desc){
                 .kind = KD_TEXTURE_CUBE, .format = KD_DEPTH32F, .width = SIDE, .height = SIDE});
    kd_gpu_clear_texture(gpu, cube, 0, NULL);
    kd_gpu_target face = kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.depth = cube, .layer = 4});
    kd_gpu_program depth_only =
        kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.vertex = "shaders/t/p.vert"});
    const float params[8] = {0, 0, 0, 0, 0.5f};
    kd_gpu_begin_raster(
        gpu, &(kd_gpu_raster){.target = face, .clear_depth = true, .depth_test = true, .depth_write = true});
    kd_gpu_bind_uniform(gpu, 0, params, sizeof params);
    kd_gpu_draw_procedural(gpu, depth_only, 3, 1);
    kd_gpu_read_texture(gpu, cube, 0, depths, sizeof depths);
    for (int layer = 0; layer < 6; layer++)
        assert_float_equal(depths[layer][7], layer == 4 ? 0.75f : 0, 1e-6f); /* z 0.5 is depth 0.75 */
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = s.target});
    fixture_assert_clean(gpu);
}

static void target_without_textures_runs_fragments(void **state)
{
    uint32_t count = 0;
    kd_gpu *gpu = *state;
    make_scene(gpu);
    fixture_write("count.frag", "layout(std430, binding = 0) buffer Count { uint count; };\n"
                                "void main() { atomicAdd(count, 1u); }\n");
    kd_gpu_program program = kd_gpu_make_program(
        gpu, &(kd_gpu_program_desc){.vertex = "shaders/t/p.vert", .fragment = "shaders/t/count.frag"});
    kd_gpu_target empty = kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.width = 8, .height = 8});
    kd_gpu_buffer buffer = kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = 4, .zeroed = true});
    const float params[8] = {0};
    kd_gpu_bind_storage(gpu, 0, buffer);
    kd_gpu_bind_uniform(gpu, 0, params, sizeof params);
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = empty});
    kd_gpu_draw_procedural(gpu, program, 3, 1);
    kd_gpu_read_buffer(gpu, buffer, 0, &count, 4);
    assert_int_equal(count, 64);
    fixture_assert_clean(gpu);
}

static void integer_targets_are_cleared_as_integers(void **state)
{
    uint32_t out[16];
    kd_gpu *gpu = *state;
    kd_gpu_texture ids =
        kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_R32UI, .width = 4, .height = 4});
    kd_gpu_target target = kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.color = {ids}});
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = target, .clear_color = true, .color = {7}});
    kd_gpu_read_texture(gpu, ids, 0, out, sizeof out);
    assert_int_equal(out[15], 7);
    fixture_assert_clean(gpu);
}

static void srgb_targets_encode_what_is_written(void **state)
{
    uint8_t out[4];
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_texture color =
        kd_gpu_make_texture(gpu, &(kd_gpu_texture_desc){.format = KD_SRGBA8, .width = 1, .height = 1});
    kd_gpu_target target = kd_gpu_make_target(gpu, &(kd_gpu_target_desc){.color = {color}});
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){.target = target});
    cover(gpu, &s, 0.5f, 1, 0, 1, 0);
    kd_gpu_read_texture(gpu, color, 0, out, 4);
    assert_in_range(out[0], 187, 189); /* 255 (1.055 0.5^(1/2.4) - 0.055) = 187.5 */
    assert_int_equal(out[1], 255);
    fixture_assert_clean(gpu);
}

static void draws_without_a_pass_do_nothing(void **state)
{
    kd_gpu *gpu = *state;
    scene s = make_scene(gpu);
    kd_gpu_begin_raster(gpu, &(kd_gpu_raster){0}); /* the window, of which there is none */
    assert_true(kd_gpu_failed(gpu));
    cover(gpu, &s, 1, 1, 1, 1, 0);
    begin(gpu, &s);
    kd_gpu_draw_procedural(gpu, (kd_gpu_program){0}, 3, 1);
    assert_quarter(gpu, &s, 0, 0, 0, 0);
    kd_gpu_destroy_target(gpu, s.target);
    cover(gpu, &s, 1, 1, 1, 1, 0);
    assert_quarter(gpu, &s, 0, 0, 0, 0);
    assert_true(fixture_logged("no raster pass has begun"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        FIXTURE_TEST(triangle_covers_its_half_of_the_target),
        FIXTURE_TEST(instances_take_their_own_attributes),
        FIXTURE_TEST(base_instance_moves_the_attributes),
        FIXTURE_TEST(indirect_draws_read_the_buffer),
        FIXTURE_TEST(geometry_changes_between_draws),
        FIXTURE_TEST(culling_keeps_counterclockwise_faces),
        FIXTURE_TEST(depth_keeps_the_nearest_and_equal_matches),
        FIXTURE_TEST(depth_clamp_and_bias_apply),
        FIXTURE_TEST(blending_mixes_and_adds),
        FIXTURE_TEST(rectangle_limits_the_clear_and_the_draw),
        FIXTURE_TEST(target_of_a_layer_draws_to_it_alone),
        FIXTURE_TEST(target_without_textures_runs_fragments),
        FIXTURE_TEST(integer_targets_are_cleared_as_integers),
        FIXTURE_TEST(srgb_targets_encode_what_is_written),
        FIXTURE_TEST(draws_without_a_pass_do_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
