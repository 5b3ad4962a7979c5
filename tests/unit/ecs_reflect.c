/* Fields by path: resolving, reading, writing, and what is refused. */

#include <math.h>

#include "runtime/ecs/reflect.h"
#include "tests/unit/ecs_fixture.h"

typedef struct lamp {
    uint32_t type;
    float intensity;
    kd_vec3 color;
    kd_quat rotation;
    kd_mat4 matrix;
    uint8_t on;
    float weights[4];
    kd_vec2 corners[2];
    char label[8];
    kd_entity target;
    int32_t level;
    uint32_t steps;
} lamp;

static const char *const lamp_types[] = {"directional", "point", "spot", NULL};
KD_COMPONENT_DEFINE(lamp, "light", KD_FIELD_ENUM(lamp, type, lamp_types, "kind of light"),
                    KD_FIELD_RANGE(lamp, intensity, KD_F32, "cd", 0, 1e6, "intensity"),
                    KD_FIELD(lamp, color, KD_COLOR, NULL, "colour"),
                    KD_FIELD(lamp, rotation, KD_QUAT, NULL, "turn"),
                    KD_FIELD(lamp, matrix, KD_MAT4, NULL, "matrix"), KD_FIELD(lamp, on, KD_BOOL, NULL, "lit"),
                    KD_FIELD_ARRAY(lamp, weights, KD_F32, 4, NULL, "weights"),
                    KD_FIELD_ARRAY(lamp, corners, KD_VEC2, 2, "m", "corners"),
                    KD_FIELD(lamp, label, KD_STRING, NULL, "label"),
                    KD_FIELD(lamp, target, KD_ENTITY, NULL, "looks at"),
                    KD_FIELD(lamp, level, KD_I32, NULL, "level"),
                    KD_FIELD(lamp, steps, KD_U32, NULL, "steps"));

static char last_message[1024];
static void keep_message(void *user, kd_log_level level, const char *text)
{
    (void)user, (void)level;
    snprintf(last_message, sizeof last_message, "%s", text);
}

typedef struct scene {
    kd_world *w;
    kd_entity e;
} scene;

static int make(void **state)
{
    scene *s = malloc(sizeof *s);
    s->w = kd_world_make();
    s->e =
        kd_spawn(s->w, KD_VAL(lamp, {.intensity = 2, .weights = {1, 2, 3, 4}}), KD_VAL(position, {1, 2, 3}));
    kd_set_name(s->w, s->e, "lamp.001");
    kd_log_set_sink(keep_message, NULL);
    last_message[0] = 0;
    *state = s;
    return 0;
}
static int drop(void **state)
{
    scene *s = *state;
    kd_log_set_sink(NULL, NULL);
    kd_world_destroy(s->w);
    free(s);
    return 0;
}

static double read_one(const scene *s, const char *path)
{
    kd_field_ref ref;
    double number = NAN;
    assert_int_equal(kd_field_resolve(s->w, path, &ref), KD_OK);
    assert_int_equal(ref.numbers, 1);
    assert_int_equal(kd_field_read(s->w, s->e, &ref, &number, 1), KD_OK);
    return number;
}

static kd_status write_text(const scene *s, const char *path, const char *text)
{
    kd_field_ref ref;
    assert_int_equal(kd_field_resolve(s->w, path, &ref), KD_OK);
    return kd_field_write_text(s->w, s->e, &ref, text);
}

static void path_reaches_every_kind_of_field(void **state)
{
    const scene *s = *state;
    static const struct {
        const char *path;
        uint32_t numbers;
    } cases[] = {
        {"light.type", 1},       {"light.intensity", 1},    {"light.color", 3},       {"light.color.g", 1},
        {"light.rotation", 4},   {"light.rotation.w", 1},   {"light.matrix", 16},     {"light.on", 1},
        {"light.weights", 4},    {"light.weights[2]", 1},   {"light.weights.3", 1},   {"light.corners", 4},
        {"light.corners[1]", 2}, {"light.corners[1].y", 1}, {"light.corners.0.x", 1}, {"light.label", 0},
        {"light.target", 0},     {"position.x", 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        kd_field_ref ref;
        assert_int_equal(kd_field_resolve(s->w, cases[i].path, &ref), KD_OK);
        assert_int_equal(ref.numbers, cases[i].numbers);
    }
}

static void path_that_leads_nowhere_is_told(void **state)
{
    const scene *s = *state;
    static const char *const wrong[] = {"",
                                        "light",
                                        "light.",
                                        "light.intens",
                                        "light.intensity.x",
                                        "light.type.",
                                        "light.color.w",
                                        "light.color.rg",
                                        "light.weights[4]",
                                        "light.weights[",
                                        "light.weights[1",
                                        "light.weights[1]x",
                                        "light.weights[-1]",
                                        "light.corners.x",
                                        "nothing.x",
                                        ".intensity",
                                        "light..intensity",
                                        "light.weights[99999999999999999999]"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        kd_field_ref ref;
        last_message[0] = 0;
        assert_int_equal(kd_field_resolve(s->w, wrong[i], &ref), KD_NOT_FOUND);
        assert_true(last_message[0] != 0);
    }
    kd_field_ref ref;
    kd_field_resolve(s->w, "light.brightness", &ref);
    assert_non_null(strstr(last_message, "light.brightness"));
    assert_non_null(strstr(last_message, "intensity")); /* lists what there is */
    kd_field_resolve(s->w, "lihgt.intensity", &ref);
    assert_non_null(strstr(last_message, "position"));
}

static void path_with_an_entity_may_hold_dots_in_its_name(void **state)
{
    const scene *s = *state;
    kd_entity e;
    kd_field_ref ref;
    assert_int_equal(kd_entity_field_resolve(s->w, "lamp.001.light.intensity", &e, &ref), KD_OK);
    assert_entity(e, s->e);
    assert_string_equal(ref.field->name, "intensity");
    assert_int_equal(kd_entity_field_resolve(s->w, "lamp.light.intensity", &e, &ref), KD_NOT_FOUND);
    assert_non_null(strstr(last_message, "no entity"));
    assert_int_equal(kd_entity_field_resolve(s->w, "lamp.001.light.size", &e, &ref), KD_NOT_FOUND);
    assert_int_equal(kd_entity_field_resolve(s->w, "", &e, &ref), KD_NOT_FOUND);
}

static void numbers_are_written_and_read_back(void **state)
{
    const scene *s = *state;
    kd_field_ref ref;
    double numbers[16];
    assert_true(read_one(s, "light.intensity") == 2 && read_one(s, "light.weights[2]") == 3);
    assert_int_equal(kd_field_resolve(s->w, "light.color", &ref), KD_OK);
    assert_int_equal(kd_field_write(s->w, s->e, &ref, (double[]){0.25, 0.5, 1}, 3), KD_OK);
    assert_true(kd_find(s->w, s->e, lamp)->color.y == 0.5f);
    assert_true(read_one(s, "light.color.b") == 1);
    assert_int_equal(kd_field_write(s->w, s->e, &ref, (double[]){0.125}, 1), KD_OK); /* one for all parts */
    assert_int_equal(kd_field_read(s->w, s->e, &ref, numbers, 16), KD_OK);
    assert_true(numbers[0] == 0.125 && numbers[1] == 0.125 && numbers[2] == 0.125);
    assert_int_equal(kd_field_read(s->w, s->e, &ref, numbers, 2), KD_OUT_OF_RANGE);
    assert_int_equal(kd_field_resolve(s->w, "light.corners[1].y", &ref), KD_OK);
    assert_int_equal(kd_field_write(s->w, s->e, &ref, (double[]){-3}, 1), KD_OK);
    assert_true(kd_find(s->w, s->e, lamp)->corners[1].y == -3 &&
                kd_find(s->w, s->e, lamp)->corners[1].x == 0);
    assert_true(kd_find(s->w, s->e, position)->y == 2); /* nothing else moved */
}

static void text_is_read_by_the_field_s_type(void **state)
{
    const scene *s = *state;
    char out[64];
    kd_field_ref ref;
    assert_int_equal(write_text(s, "light.type", "spot"), KD_OK);
    assert_int_equal(kd_find(s->w, s->e, lamp)->type, 2);
    assert_int_equal(write_text(s, "light.on", "true"), KD_OK);
    assert_int_equal(kd_find(s->w, s->e, lamp)->on, 1);
    assert_int_equal(write_text(s, "light.on", "off"), KD_OK);
    assert_int_equal(kd_find(s->w, s->e, lamp)->on, 0);
    assert_int_equal(write_text(s, "light.color", "{0.5, 0.25 0.125}"), KD_OK);
    assert_true(kd_find(s->w, s->e, lamp)->color.z == 0.125f);
    assert_int_equal(write_text(s, "light.label", "porch"), KD_OK);
    assert_int_equal(write_text(s, "light.label", "up"), KD_OK);
    assert_memory_equal(kd_find(s->w, s->e, lamp)->label, "up\0\0\0\0\0",
                        8); /* nothing of the longer one is left */
    assert_int_equal(write_text(s, "light.target", "lamp.001"), KD_OK);
    assert_entity(kd_find(s->w, s->e, lamp)->target, s->e);
    kd_field_resolve(s->w, "light.target", &ref);
    assert_string_equal(kd_field_read_text(s->w, s->e, &ref, out, sizeof out), "lamp.001");
    kd_field_resolve(s->w, "light.type", &ref);
    assert_string_equal(kd_field_read_text(s->w, s->e, &ref, out, sizeof out), "spot");
    kd_field_resolve(s->w, "light.color", &ref);
    assert_string_equal(kd_field_read_text(s->w, s->e, &ref, out, sizeof out), "0.5,0.25,0.125");
    kd_field_resolve(s->w, "light.label", &ref);
    assert_string_equal(kd_field_read_text(s->w, s->e, &ref, out, sizeof out), "up");
    kd_field_resolve(s->w, "light.matrix", &ref);
    assert_int_equal(strlen(kd_field_read_text(s->w, s->e, &ref, out, 8)), 7); /* cut, never past the end */
}

static void values_out_of_range_change_nothing_and_say_why(void **state)
{
    const scene *s = *state;
    static const struct {
        const char *path, *text, *words;
    } cases[] = {
        {"light.intensity", "-1", "0 to 1e+06 cd"},
        {"light.intensity", "2e6", "out of range"},
        {"light.intensity", "nan", "not finite"},
        {"light.intensity", "inf", "not finite"},
        {"light.intensity", "bright", "bright"},
        {"light.intensity", "1,2", "takes 1"},
        {"light.intensity", "", "list of numbers"},
        {"light.type", "sun", "directional point spot"},
        {"light.type", "3", "out of range"},
        {"light.color", "1,2", "takes 3"},
        {"light.rotation", "1", "takes 4"},
        {"light.level", "1.5", "not whole"},
        {"light.level", "3e9", "out of range"},
        {"light.steps", "-1", "out of range"},
        {"light.on", "maybe", "true or false"},
        {"light.on", "2", "out of range"},
        {"light.label", "much too long", "at most 7"},
        {"light.target", "nobody", "nobody"},
        {"light.color.r", "1e39", "out of range"},
    };
    uint64_t before = kd_world_checksum(s->w);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        last_message[0] = 0;
        assert_int_not_equal(write_text(s, cases[i].path, cases[i].text), KD_OK);
        assert_non_null(strstr(last_message, cases[i].words));
        assert_true(kd_world_checksum(s->w) == before);
    }
}

static void writing_marks_the_component_as_changed(void **state)
{
    const scene *s = *state;
    kd_query *q = kd_query_make(s->w, &(kd_query_desc){.terms = {KD_READ(lamp)}});
    kd_iter it = kd_query_iter(q);
    it.changed_since = kd_world_version(s->w);
    assert_false(kd_iter_next(&it));
    assert_int_equal(write_text(s, "light.intensity", "5"), KD_OK);
    uint64_t since = it.changed_since;
    it = kd_query_iter(q);
    it.changed_since = since;
    assert_true(kd_iter_next(&it));
}

static void singleton_is_reached_without_an_entity(void **state)
{
    const scene *s = *state;
    kd_field_ref ref;
    double number;
    kd_singleton(s->w, health);
    assert_int_equal(kd_field_resolve(s->w, "health.now", &ref), KD_OK);
    assert_int_equal(kd_field_read(s->w, KD_NO_ENTITY, &ref, &number, 1), KD_OK);
    assert_true(number == 100);
    assert_int_equal(kd_field_write(s->w, KD_NO_ENTITY, &ref, (double[]){7}, 1), KD_OK);
    assert_int_equal(kd_singleton(s->w, health)->now, 7);
    assert_int_equal(kd_field_write(s->w, s->e, &ref, (double[]){7}, 1),
                     KD_NOT_FOUND); /* the entity has none */
    assert_non_null(strstr(last_message, "lamp.001"));
}

static void entities_have_functions_of_their_own(void **state)
{
    const scene *s = *state;
    kd_field_ref ref, other;
    kd_entity value;
    kd_field_resolve(s->w, "light.target", &ref);
    kd_field_resolve(s->w, "light.intensity", &other);
    assert_int_equal(kd_field_write_entity(s->w, s->e, &ref, 0, s->e), KD_OK);
    assert_int_equal(kd_field_read_entity(s->w, s->e, &ref, 0, &value), KD_OK);
    assert_entity(value, s->e);
    assert_int_equal(kd_field_read_entity(s->w, s->e, &ref, 1, &value), KD_OUT_OF_RANGE);
    assert_int_equal(kd_field_write_entity(s->w, s->e, &other, 0, s->e), KD_BAD_FORMAT);
    assert_int_equal(kd_field_write(s->w, s->e, &ref, (double[]){1}, 1), KD_BAD_FORMAT);
}

int main(void)
{
#define CASE(test) cmocka_unit_test_setup_teardown(test, make, drop)
    const struct CMUnitTest tests[] = {
        CASE(path_reaches_every_kind_of_field),
        CASE(path_that_leads_nowhere_is_told),
        CASE(path_with_an_entity_may_hold_dots_in_its_name),
        CASE(numbers_are_written_and_read_back),
        CASE(text_is_read_by_the_field_s_type),
        CASE(values_out_of_range_change_nothing_and_say_why),
        CASE(writing_marks_the_component_as_changed),
        CASE(singleton_is_reached_without_an_entity),
        CASE(entities_have_functions_of_their_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
