/* What the G-buffer keeps of known surfaces, through the views that show it. */

#include "runtime/asset/model_memory.h"
#include "tests/render_fixture.h"

static const float PI = 3.14159265f;

static void show(render *r, kd_view_mode view, const char *name)
{
    r->frame->view = view;
    render_frame(r, name);
}

/* A plane facing up, seen from a height of 20 m. Albedo keeps 8 bits of its root: steps of 2 * sqrt(a) / 255
 * < 0.8 %. */
static void views_show_albedo_normal_and_depth_of_a_quad(void **state)
{
    render *r = *state;
    kd_material_desc m = render_matte(0.5f);
    m.base_color = (kd_vec4){0.5f, 0.1f, 0.9f, 1};
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){2, 1, 2}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    render_top_camera(r, 2);
    show(r, KD_VIEW_ALBEDO, "albedo");
    render_expect(r, 80, 60, (kd_vec3){0.5f, 0.1f, 0.9f}, 0.02f);
    show(r, KD_VIEW_NORMAL, "normal");
    render_expect(r, 80, 60, (kd_vec3){0.5f, 1, 0.5f}, 0.001f);
    assert_in_range(r->ldr[(60 * 160 + 80) * 4], 127, 128);
    assert_int_equal(r->ldr[(60 * 160 + 80) * 4 + 1], 255);
    show(r, KD_VIEW_DEPTH, "depth");
    render_expect(r, 80, 60, (kd_vec3){20, 20, 20}, 0.001f);
    render_expect(r, 2, 2, (kd_vec3){0, 0, 0}, 0); /* background */
    show(r, KD_VIEW_AO, "ao");
    render_expect(r, 80, 60, (kd_vec3){1, 1, 1}, 0); /* nothing occludes where there is no GI */
}

/* Depth is the distance along the axis, for perspective too: a wall across the view has one depth in all its
 * pixels. */
static void depth_of_a_wall_is_the_same_in_every_pixel(void **state)
{
    render *r = *state;
    kd_material_desc m = render_matte(0.5f);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){400, 1, 400}, &m, (kd_vec3){0, 0, -100},
                 render_look((kd_vec3){0, 1, 0}), RENDER_UNIT);
    render_camera(r, (kd_vec3){0, 0, 0}, (kd_vec3){0, 0, -1}, 1.2f);
    show(r, KD_VIEW_DEPTH, "wall");
    for (uint32_t x = 0; x < 160; x += 53)
        for (uint32_t y = 0; y < 120; y += 17)
            render_expect(r, x, y, (kd_vec3){100, 100, 100}, 0.001f);
}

/* Turned by 30 degrees round z, +Y becomes (-1/2, sqrt(3)/2, 0). A plane scaled to (2, 1, 1) and turned keeps
 * that normal, since the scale lies in the plane. */
static void normals_turn_with_the_object_and_ignore_its_scale(void **state)
{
    render *r = *state;
    kd_material_desc m = render_matte(0.5f);
    kd_quat turn = {0, 0, sinf(PI / 12), cosf(PI / 12)};
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &m, (kd_vec3){0, 0, 0}, turn, (kd_vec3){2, 0.3f, 1});
    render_top_camera(r, 2);
    show(r, KD_VIEW_NORMAL, "turned");
    render_expect(r, 80, 60, (kd_vec3){0.5f - 0.25f, 0.5f + sqrtf(3) / 4, 0.5f}, 0.001f);
}

/* A single-sided plane shows nothing from behind; a double-sided one shows its normal towards the viewer.
 * Mirroring (a negative scale) turns the winding over, not the side. */
static void sides_show_as_the_material_says(void **state)
{
    render *r = *state;
    kd_material_desc single = render_matte(0.5f), both = single;
    both.double_sided = true;
    kd_quat upside_down = {1, 0, 0, 0};
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &single, (kd_vec3){-1.5f, 0, 0}, upside_down,
                 RENDER_UNIT);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &both, (kd_vec3){0, 0, 0}, upside_down, RENDER_UNIT);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &single, (kd_vec3){1.5f, 0, 0}, RENDER_UPRIGHT,
                 (kd_vec3){-1, 1, 1});
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &both, (kd_vec3){0, 0, 1.3f}, RENDER_UPRIGHT,
                 (kd_vec3){-1, 1, 1});
    render_top_camera(r, 2);
    show(r, KD_VIEW_NORMAL, "sides");
    render_expect(r, 35, 60, (kd_vec3){0, 0, 0}, 0);
    render_expect(r, 80, 60, (kd_vec3){0.5f, 1, 0.5f}, 0.001f);
    render_expect(r, 125, 60, (kd_vec3){0.5f, 1, 0.5f}, 0.001f);
    render_expect(r, 80, 99, (kd_vec3){0.5f, 1, 0.5f}, 0.001f);
}

/* ---- a quad with textures, 2 m wide, facing +Y with u along x and v along z ---- */

typedef struct textured {
    model_memory memory; /* ends with the model */
    kd_image images[3];
    kd_material_desc material;
    kd_primitive_desc primitive;
    kd_mesh_desc mesh;
    kd_node_desc node;
    kd_model model;
} textured;

static const kd_vec3 quad_positions[4] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
static const kd_vec3 quad_normals[4] = {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}};
static const kd_vec4 quad_tangents[4] = {{1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}};
static const kd_vec2 quad_uv[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
static const uint32_t quad_indices[6] = {0, 2, 1, 0, 3, 2};

static kd_texture_ref quad_map(uint32_t image)
{
    return (kd_texture_ref){.image = image, .nearest = true, .scale = {1, 1}};
}

/* A model as a loader would make it: it stands in its own arena, so that the store can destroy it. */
static textured *make_textured(const kd_image *images, uint32_t image_count)
{
    kd_arena arena = {0};
    textured *t = KD_ARENA_NEW(&arena, textured, 1);
    assert_non_null(t);
    memcpy(t->images, images, image_count * sizeof *images);
    t->material = render_matte(1);
    t->primitive = (kd_primitive_desc){.vertex_count = 4,
                                       .index_count = 6,
                                       .indices = quad_indices,
                                       .positions = quad_positions,
                                       .normals = quad_normals,
                                       .tangents = quad_tangents,
                                       .uv0 = quad_uv,
                                       .bounds_min = {-1, 0, -1},
                                       .bounds_max = {1, 0, 1}};
    t->mesh = (kd_mesh_desc){.name = "quad", .primitive_count = 1, .primitives = &t->primitive};
    t->node = (kd_node_desc){.name = "quad",
                             .parent = KD_NONE,
                             .rotation = {0, 0, 0, 1},
                             .scale = {1, 1, 1},
                             .mesh = 0,
                             .skin = KD_NONE,
                             .camera = KD_NONE,
                             .light = KD_NONE};
    t->model = (kd_model){.path = "quad",
                          .image_count = image_count,
                          .images = t->images,
                          .material_count = 1,
                          .materials = &t->material,
                          .mesh_count = 1,
                          .meshes = &t->mesh,
                          .node_count = 1,
                          .nodes = &t->node,
                          .bounds_min = {-1, 0, -1},
                          .bounds_max = {1, 0, 1}};
    t->memory = (model_memory){arena, 1};
    t->model.internal = &t->memory;
    return t;
}

static kd_entity add_textured(render *r, textured *t)
{
    uint32_t number;
    kd_entity root;
    assert_int_equal(kd_scene_add_model(r->world, &t->model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(r->world, number, KD_NO_ENTITY, "quad", &root), KD_OK);
    return root;
}

/* Four texels, row 0 (z < 0, the picture's upper half) first: red, green / blue, opaque-less white. */
static const uint8_t four_texels[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 0};

static void base_color_map_lies_as_its_coordinates_say(void **state)
{
    render *r = *state;
    textured *t = make_textured(&(kd_image){"four", 2, 2, four_texels}, 1);
    t->material.base_color_map = quad_map(0);
    add_textured(r, t);
    render_top_camera(r, 2);
    show(r, KD_VIEW_ALBEDO, "map");
    render_expect(r, 65, 45, (kd_vec3){1, 0, 0}, 0.01f);
    render_expect(r, 95, 45, (kd_vec3){0, 1, 0}, 0.01f);
    render_expect(r, 65, 75, (kd_vec3){0, 0, 1}, 0.01f);
    render_expect(r, 95, 75, (kd_vec3){1, 1, 1}, 0.01f);
}

/* KHR_texture_transform by a quarter turn: rotation pi/2 takes (u, v) to (v, -u), repeated: the upper left of
 * the quad, uv (1/4, 1/4), reads (1/4, -1/4) = (1/4, 3/4): blue; the upper right, (3/4, 1/4), reads (1/4,
 * -3/4) = (1/4, 1/4): red. An offset of (1/2, 0) then moves one texel on: white and green. */
static void texture_transform_turns_and_moves(void **state)
{
    render *r = *state;
    textured *t = make_textured(&(kd_image){"four", 2, 2, four_texels}, 1);
    t->material.base_color_map = quad_map(0);
    t->material.base_color_map.rotation = PI / 2;
    kd_entity first = add_textured(r, t);
    render_top_camera(r, 2);
    show(r, KD_VIEW_ALBEDO, "turned_map");
    render_expect(r, 65, 45, (kd_vec3){0, 0, 1}, 0.01f);
    render_expect(r, 95, 45, (kd_vec3){1, 0, 0}, 0.01f);
    kd_destroy(r->world, first);
    t = make_textured(&(kd_image){"four", 2, 2, four_texels}, 1);
    t->material.base_color_map = quad_map(0);
    t->material.base_color_map.rotation = PI / 2;
    t->material.base_color_map.offset.x = 0.5f;
    add_textured(r, t);
    show(r, KD_VIEW_ALBEDO, "moved_map");
    render_expect(r, 65, 45, (kd_vec3){1, 1, 1}, 0.01f);
    render_expect(r, 95, 45, (kd_vec3){0, 1, 0}, 0.01f);
}

/* The transparent texel is a hole in the picture and in the shadow: the floor 1 m below shows its light
 * there. */
static void mask_texels_are_holes_in_picture_and_shadow(void **state)
{
    render *r = *state;
    kd_material_desc floor = render_matte(0.5f);
    textured *t = make_textured(&(kd_image){"four", 2, 2, four_texels}, 1);
    t->material.base_color_map = quad_map(0);
    t->material.alpha_mode = KD_ALPHA_MASK;
    t->material.alpha_cutoff = 0.5f;
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){8, 1, 8}, &floor, (kd_vec3){0, -2.5f, 0}, RENDER_UPRIGHT,
                 RENDER_UNIT);
    add_textured(r, t);
    render_top_camera(r, 4); /* 15 pixels a metre */
    show(r, KD_VIEW_ALBEDO, "holes");
    render_expect(r, 72, 52, (kd_vec3){1, 0, 0}, 0.01f);
    render_expect(r, 87, 67, (kd_vec3){0.5f, 0.5f, 0.5f}, 0.01f);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3},
                 (kd_vec3){0, 5, 0}, (kd_vec3){1, -1, 0});
    show(r, KD_VIEW_DIRECT, "holes_lit");
    /* the quad's shadow lies 2.5 m towards +x: 1.5 … 3.5, its hole at x 2.5 … 3.5, z 0 … 1 */
    float lit = render_pixel(r, 20, 60)[0];
    assert_true(lit > 0.3f * 0.5f);
    assert_true(render_pixel(r, 80 + 45, 60 + 7)[0] > lit * 0.99f); /* (3, 0.5) */
    assert_true(render_pixel(r, 80 + 45, 60 - 8)[0] < lit * 0.01f); /* (3, -0.5) */
    assert_true(render_pixel(r, 80 + 30, 60 + 7)[0] < lit * 0.01f); /* (2, 0.5) */
}

/* A texel (1, 0.5, 1) / 255 of a normal map leans by 45 degrees along the tangent +x; the bitangent is
 * cross(n, t) * w = cross(+y, +x) = -z for w = 1, so green leans to -z. A mirrored object (scale -1 in x)
 * leans the tangent to -x, and its bitangent stays: the image is mirrored, not turned upside down. */
static void normal_map_leans_along_tangent_and_bitangent(void **state)
{
    static const uint8_t lean_u[4] = {218, 128, 218, 255}, lean_v[4] = {128, 218, 218, 255};
    render *r = *state;
    const uint8_t *const texels[2] = {lean_u, lean_v};
    float s = sqrtf(0.5f) / 2;
    const kd_vec3 expected[2][2] = {{{0.5f + s, 0.5f + s, 0.5f}, {0.5f - s, 0.5f + s, 0.5f}},
                                    {{0.5f, 0.5f + s, 0.5f - s}, {0.5f, 0.5f + s, 0.5f - s}}};
    render_top_camera(r, 2);
    for (int i = 0; i < 4; i++) {
        textured *t = make_textured(&(kd_image){"lean", 1, 1, texels[i / 2]}, 1);
        t->material.normal_map = quad_map(0);
        t->material.normal_scale = 1;
        kd_entity e = add_textured(r, t);
        kd_find_mut(r->world, e, kd_transform)->scale.x = i % 2 == 0 ? 1.0f : -1.0f;
        show(r, KD_VIEW_NORMAL, "lean");
        render_expect(r, 80, 60, expected[i / 2][i % 2], 0.01f);
        kd_destroy(r->world, e);
    }
}

/* A picture of another size: targets follow, and one pixel is a picture too. */
static void targets_follow_the_size(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1}, {33, 17}, {257, 3}, {160, 120}};
    render *r = *state;
    kd_material_desc m = render_matte(0.5f);
    render_shape(r, KD_SHAPE_PLANE, (kd_vec3){9, 1, 9}, &m, (kd_vec3){0, 0, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    render_top_camera(r, 0.01f);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        r->frame->width = sizes[i][0];
        r->frame->height = sizes[i][1];
        show(r, KD_VIEW_ALBEDO, "size");
        render_expect(r, 0, 0, (kd_vec3){0.5f, 0.5f, 0.5f}, 0.01f);
        render_expect(r, sizes[i][0] - 1, sizes[i][1] - 1, (kd_vec3){0.5f, 0.5f, 0.5f}, 0.01f);
    }
}

/* Light arrives alike at black, white and polished surfaces: a sun of 3 lx straight down gives 3 / pi. */
static void light_is_shown_without_what_it_falls_on(void **state)
{
    render *r = *state;
    kd_material_desc materials[3] = {render_matte(0.02f), render_matte(0.9f), render_matte(0.5f)};
    materials[2].metallic = 1;
    materials[2].roughness = 0.2f;
    for (int i = 0; i < 3; i++)
        render_shape(r, KD_SHAPE_PLANE, (kd_vec3){1, 1, 1}, &materials[i],
                     (kd_vec3){1.2f * (float)(i - 1), 0, 0}, RENDER_UPRIGHT, RENDER_UNIT);
    render_top_camera(r, 2);
    render_light(r, (kd_light){.type = KD_DIRECTIONAL, .color = {1, 1, 1}, .intensity = 3, .no_shadow = true},
                 (kd_vec3){0, 5, 0}, (kd_vec3){0, -1, 0});
    show(r, KD_VIEW_LIGHT, "light");
    for (uint32_t i = 0; i < 3; i++)
        render_expect(r, 80 + 36 * (i - 1), 60, (kd_vec3){3 / PI, 3 / PI, 3 / PI}, 0.01f);
    render_expect(r, 2, 2, (kd_vec3){0, 0, 0}, 0); /* background */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        RENDER_TEST(views_show_albedo_normal_and_depth_of_a_quad),
        RENDER_TEST(depth_of_a_wall_is_the_same_in_every_pixel),
        RENDER_TEST(normals_turn_with_the_object_and_ignore_its_scale),
        RENDER_TEST(sides_show_as_the_material_says),
        RENDER_TEST(base_color_map_lies_as_its_coordinates_say),
        RENDER_TEST(texture_transform_turns_and_moves),
        RENDER_TEST(mask_texels_are_holes_in_picture_and_shadow),
        RENDER_TEST(normal_map_leans_along_tangent_and_bitangent),
        RENDER_TEST(targets_follow_the_size),
        RENDER_TEST(light_is_shown_without_what_it_falls_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
