/* What the voxelizer writes of a voxel: colour, normal, share of emission; and where masks leave none. */

#include "tests/voxel_cells_fixture.h"

#define SPAN 0.02f

static float albedo_of(const cells *c, uint32_t voxel, int channel)
{
    float root = (float)(c->color[voxel] >> (8 * channel) & 255u) / 255;
    return root * root;
}

/* Stored as the root in 8 bits: half a step of it, and half a step of 8-bit input. */
#define ALBEDO_STEP (1.0f / 255 + 1.0f / 510)

static kd_model *make_shape(kd_shape shape, kd_vec3 size, const kd_material_desc *material,
                            kd_primitive_desc **primitive)
{
    kd_model *model;
    assert_int_equal(kd_model_make_shape(shape, size, 0, material, &model), KD_OK);
    *primitive = (kd_primitive_desc *)(uintptr_t)model->meshes[0].primitives;
    return model;
}

static void faces_keep_their_colours(void **state)
{
    (void)state;
    static const float levels[6] = {0.02f, 0.9f, 0.3f, 0.6f, 1, 0};
    static kd_vec4 colors[24];
    for (int i = 0; i < 24; i++) /* four vertices a face: +x -x +y -y +z -z */
        colors[i] = (kd_vec4){levels[i / 4], levels[(i / 4 + 2) % 6], levels[(i / 4 + 3) % 6], 1};
    kd_material_desc white = voxel_matte(1, 1, 1);
    kd_primitive_desc *p;
    kd_model *model = make_shape(KD_SHAPE_BOX, (kd_vec3){0.5f, 0.5f, 0.5f}, &white, &p);
    p->colors = colors;
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    voxel_spawn(&v, model, voxel_at(0.003f, 0.003f, 0.003f));
    voxel_frame(&v);
    cells c = read_cells(&v, 0);
    uint32_t seen[6] = {0};
    for (int face = 0; face < 6; face++) {
        double sum[3] = {0};
        for (int64_t a = -10; a < 10; a++)
            for (int64_t b = -10; b < 10; b++) {
                int64_t cell[3], axis = face / 2;
                float at = (face % 2 ? -0.25f : 0.25f) - (&c.cache->phase.x)[axis];
                cell[axis] = (int64_t)floorf(at / c.cache->span + (float)KD_VOXELIZE_NUDGE);
                cell[(axis + 1) % 3] = a;
                cell[(axis + 2) % 3] = b;
                size_t i = cell_at(&c, cell);
                assert_int_equal(c.wall[i], 1);
                seen[face]++;
                int32_t normal = (int32_t)(int8_t)(c.shape[c.voxel[i]][1] >> (8 * axis) & 255u);
                assert_int_equal(normal, face % 2 ? -127 : 127);
                for (int k = 0; k < 3; k++)
                    sum[k] += (double)albedo_of(&c, c.voxel[i], k);
            }
        for (int k = 0; k < 3; k++)
            assert_float_equal((float)(sum[k] / seen[face]), (&colors[4 * face].x)[k], ALBEDO_STEP);
    }
    free_cells(&c);
    voxel_close(&v);
}

/* One image on a plane, its left half differing from its right; u runs along x. */
static kd_model *half_and_half(kd_material_desc material, const uint8_t left[4], const uint8_t right[4])
{
    static uint8_t pixels[64 * 4 * 4];
    static kd_image image = {"halves", 64, 4, pixels};
    kd_primitive_desc *p;
    for (int i = 0; i < 64 * 4; i++)
        memcpy(pixels + 4 * i, i % 64 < 32 ? left : right, 4);
    kd_model *model = make_shape(KD_SHAPE_PLANE, (kd_vec3){0.5f, 0, 0.5f}, &material, &p);
    model->images = &image;
    model->image_count = 1;
    return model;
}

static kd_texture_ref first_image(void)
{
    return (kd_texture_ref){.image = 0, .scale = {1, 1}, .wrap_s = KD_WRAP_CLAMP, .wrap_t = KD_WRAP_CLAMP};
}

static void halves_of(voxel_world *v, cells *c, uint32_t count[2], double emission[2], double red[2])
{
    voxel_frame(v);
    *c = read_cells(v, 0);
    for (uint32_t z = 0; z < c->size[2]; z++)
        for (uint32_t x = 0; x < c->size[0]; x++)
            for (uint32_t y = 0; y < c->size[1]; y++) {
                size_t i = ((size_t)z * c->size[1] + y) * c->size[0] + x;
                float at = ((float)(c->low[0] + x) + 0.5f) * c->cache->span + c->cache->phase.x;
                if (!c->wall[i] || fabsf(at) < 1.5f * SPAN)
                    continue;
                count[at > 0]++;
                emission[at > 0] += (double)(c->shape[c->voxel[i]][1] >> 24) / 255;
                red[at > 0] += (double)albedo_of(c, c->voxel[i], 0);
            }
}

static void emissive_map_decides_the_share(void **state)
{
    (void)state;
    kd_material_desc m = voxel_matte(0.5f, 0.5f, 0.5f);
    m.emissive = (kd_vec3){2, 2, 2};
    m.emissive_map = first_image();
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    voxel_spawn(&v, half_and_half(m, (uint8_t[4]){0, 0, 0, 255}, (uint8_t[4]){255, 255, 255, 255}),
                voxel_at(0, 0, 0));
    cells c;
    uint32_t count[2] = {0};
    double emission[2] = {0}, red[2] = {0};
    halves_of(&v, &c, count, emission, red);
    assert_true(count[0] > 200 && count[1] > 200);
    assert_true(emission[0] < 0.005 * count[0]);
    assert_true(emission[1] > 0.995 * count[1]);
    free_cells(&c);
    voxel_close(&v);
}

static void colour_map_decides_the_albedo(void **state)
{
    (void)state;
    kd_material_desc m = voxel_matte(1, 1, 1);
    m.base_color_map = first_image();
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    voxel_spawn(&v, half_and_half(m, (uint8_t[4]){188, 0, 0, 255}, (uint8_t[4]){0, 0, 0, 255}),
                voxel_at(0, 0, 0));
    cells c;
    uint32_t count[2] = {0};
    double emission[2] = {0}, red[2] = {0};
    halves_of(&v, &c, count, emission, red);
    assert_float_equal((float)(red[0] / count[0]), 0.5029f, 2 * ALBEDO_STEP); /* sRGB 188 */
    assert_float_equal((float)(red[1] / count[1]), 0, ALBEDO_STEP);
    free_cells(&c);
    voxel_close(&v);
}

static void masked_parts_leave_no_voxels(void **state)
{
    (void)state;
    kd_material_desc m = voxel_matte(1, 1, 1);
    m.base_color_map = first_image();
    m.alpha_mode = KD_ALPHA_MASK;
    m.alpha_cutoff = 0.5f;
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    voxel_spawn(&v, half_and_half(m, (uint8_t[4]){255, 255, 255, 255}, (uint8_t[4]){255, 255, 255, 0}),
                voxel_at(0, 0, 0));
    cells c;
    uint32_t count[2] = {0};
    double emission[2] = {0}, red[2] = {0};
    halves_of(&v, &c, count, emission, red);
    assert_true(count[0] > 200);
    assert_int_equal(count[1], 0);
    free_cells(&c);
    voxel_close(&v);
}

/* An entity may bring a material of its own, and change it; another one of the same mesh keeps the mesh's. */
static void entitys_material_goes_before_the_meshs(void **state)
{
    (void)state;
    voxel_world v = voxel_open((voxel_options){.span = SPAN});
    kd_material_desc own[3] = {voxel_matte(0.9f, 0.1f, 0.1f), voxel_matte(0.1f, 0.9f, 0.1f),
                               voxel_matte(0.1f, 0.1f, 0.9f)};
    kd_primitive_desc *p;
    kd_model *model = make_shape(KD_SHAPE_BOX, (kd_vec3){0.3f, 0.3f, 0.3f}, &own[0], &p);
    uint32_t number;
    kd_entity roots[3];
    assert_int_equal(kd_scene_add_model(v.world, model, &number), KD_OK);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(kd_scene_instantiate(v.world, number, KD_NO_ENTITY, "box", &roots[i]), KD_OK);
        kd_find_mut(v.world, roots[i], kd_transform)->position.x = 0.4f * (float)(i - 1);
    }
    kd_scene_override_material(v.world, roots[1], kd_scene_add_material(v.world, &own[1]));
    for (int frame = 0; frame < 2; frame++) {
        if (frame == 1)
            kd_scene_override_material(v.world, roots[2], kd_scene_add_material(v.world, &own[2]));
        voxel_frame(&v);
        for (uint32_t i = 0; i < 3; i++) {
            const kd_voxel_object *o = &voxel_scene(&v)->objects[i];
            int which = (int)lroundf(o->model_ws.m[12] / 0.4f) + 1,
                material = which == 2 && frame == 0 ? 0 : which;
            cells c = read_cells(&v, i);
            const float *color = &own[material].base_color.x;
            for (int k = 0; k < 3; k++)
                assert_float_equal(albedo_of(&c, voxel_scene(&v)->chunks[c.cache->first_chunk].first, k),
                                   color[k], ALBEDO_STEP);
            free_cells(&c);
        }
    }
    voxel_close(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faces_keep_their_colours),
        cmocka_unit_test(emissive_map_decides_the_share),
        cmocka_unit_test(colour_map_decides_the_albedo),
        cmocka_unit_test(masked_parts_leave_no_voxels),
        cmocka_unit_test(entitys_material_goes_before_the_meshs),
    };
    return VOXEL_GROUP(tests);
}
