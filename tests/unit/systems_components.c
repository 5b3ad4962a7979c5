/* The reflection tables of all components: what scripts, panels and the documentation rely on. */

#include "tests/systems_fixture.h"

#include "components/camera.h"
#include "components/light.h"
#include "components/render_targets.h"

static const kd_component_desc *const all[] = {
    &kd_transform_desc,     &kd_local_matrix_desc,  &kd_world_transform_desc, &kd_animation_desc,
    &kd_camera_desc,        &kd_view_desc,          &kd_frame_desc,           &kd_light_desc,
    &kd_mesh_instance_desc, &kd_skin_instance_desc, &kd_morph_weights_desc,   &kd_gbuffer_desc,
    &kd_lighting_desc,      &kd_gi_targets_desc,    &kd_picture_desc,         &kd_tree_desc,
    &kd_scene_store_desc,   &kd_draw_list_desc,     &kd_joint_palette_desc};
enum { COUNT = sizeof all / sizeof *all };

/* Bytes of one element, as runtime/ecs/component.h states them. */
static uint32_t element_size(const kd_field *f)
{
    static const uint32_t sizes[] = {
        [KD_BOOL] = 1,  [KD_I32] = 4,   [KD_U32] = 4,   [KD_F32] = 4,    [KD_VEC2] = 8, [KD_VEC3] = 12,
        [KD_VEC4] = 16, [KD_QUAT] = 16, [KD_MAT4] = 64, [KD_COLOR] = 12, [KD_ENUM] = 4, [KD_ENTITY] = 8};
    return f->type == KD_STRING ? f->size : sizes[f->type];
}

static void fields_lie_inside_and_apart(void **state)
{
    (void)state;
    for (int c = 0; c < COUNT; c++) {
        uint32_t end = 0;
        assert_true(all[c]->field_count > 0);
        for (uint32_t i = 0; i < all[c]->field_count; i++) {
            const kd_field *f = &all[c]->fields[i];
            assert_true(f->offset + f->size <= all[c]->size);
            assert_int_equal(f->size, element_size(f) * (f->count ? f->count : 1));
            assert_true(f->offset >= end); /* in order of declaration, none over another */
            end = f->offset + f->size;
        }
    }
}

static void names_are_unique_and_documented(void **state)
{
    (void)state;
    for (int c = 0; c < COUNT; c++) {
        for (int d = 0; d < c; d++)
            assert_string_not_equal(all[c]->name, all[d]->name);
        for (uint32_t i = 0; i < all[c]->field_count; i++) {
            assert_true(strlen(all[c]->fields[i].doc) > 2);
            for (uint32_t k = 0; k < i; k++)
                assert_string_not_equal(all[c]->fields[i].name, all[c]->fields[k].name);
        }
    }
}

static double value_of(const kd_field *f, const void *component)
{
    const void *at = (const char *)component + f->offset;
    if (f->type == KD_F32)
        return *(const float *)at;
    return f->type == KD_I32 ? (double)*(const int32_t *)at : (double)*(const uint32_t *)at;
}

static void defaults_lie_within_ranges(void **state)
{
    (void)state;
    int checked = 0;
    for (int c = 0; c < COUNT; c++)
        for (uint32_t i = 0; i < all[c]->field_count && all[c]->default_value; i++) {
            const kd_field *f = &all[c]->fields[i];
            if (f->type == KD_ENUM) {
                uint32_t names = 0;
                while (f->enum_names[names])
                    names++;
                assert_true(value_of(f, all[c]->default_value) < names);
            } else if (f->min < f->max) {
                double v = value_of(f, all[c]->default_value);
                assert_true(v >= f->min && v <= f->max);
                checked++;
            }
        }
    assert_true(checked > 10);
}

static void enums_have_the_names_that_users_write(void **state)
{
    (void)state;
    const kd_field *type = &kd_light_desc.fields[0];
    assert_string_equal(type->enum_names[KD_DIRECTIONAL], "directional");
    assert_string_equal(type->enum_names[KD_POINT], "point");
    assert_string_equal(type->enum_names[KD_SPOT], "spot");
    for (uint32_t i = 0; i < kd_frame_desc.field_count; i++) {
        const kd_field *f = &kd_frame_desc.fields[i];
        if (strcmp(f->name, "gi") == 0)
            assert_string_equal(f->enum_names[KD_GI_NONE], "none");
        if (strcmp(f->name, "view") == 0) {
            assert_string_equal(f->enum_names[KD_VIEW_OCTREE], "octree");
            assert_null(f->enum_names[KD_VIEW_MODE_COUNT]);
        }
    }
}

static void frame_starts_with_the_settings_defaults(void **state)
{
    (void)state;
    const kd_frame *frame = kd_frame_desc.default_value;
    kd_settings expected = kd_settings_defaults();
    size_t count;
    const kd_setting_row *rows = kd_settings_rows(&count);
    assert_true(count > 10);
    for (size_t i = 0; i < count; i++)
        assert_true(kd_settings_value(&frame->settings, &rows[i]) == kd_settings_value(&expected, &rows[i]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_lie_inside_and_apart),
        cmocka_unit_test(names_are_unique_and_documented),
        cmocka_unit_test(defaults_lie_within_ranges),
        cmocka_unit_test(enums_have_the_names_that_users_write),
        cmocka_unit_test(frame_starts_with_the_settings_defaults),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
