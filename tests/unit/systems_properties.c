/* What clips move besides nodes (KHR_animation_pointer): from the file to the store and the entities. */
#include "tests/unit/asset_support.h"

#include "tests/systems_fixture.h"

#include "components/camera.h"
#include "components/light.h"
#include "systems/animation/animation.h"
#include "systems/scene/scene.h"

#define EPSILON 1e-5f

/* One channel a property; sampler 0: floats 0, 1 … 3, sampler 1: vectors of 3, sampler 2: of 4. */
#define POINT(sampler, pointer)                                                                              \
    "{'sampler':" #sampler ",'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{"             \
    "'pointer':'" pointer "'}}}}"

#define LIGHTS   "/extensions/KHR_lights_punctual/lights/0"
#define STRENGTH "/extensions/KHR_materials_emissive_strength/emissiveStrength"
#define BEFORE                                                                                               \
    "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_animation_pointer','KHR_lights_punctual',"            \
    "'KHR_materials_emissive_strength'],"                                                                    \
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'spot','intensity':8,'spot':{}}]}},"             \
    "'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':0.1}}],"                               \
    "'materials':[{'emissiveFactor':[1,0.5,0],'extensions':{'KHR_materials_emissive_strength':{"             \
    "'emissiveStrength':4}}}],"                                                                              \
    "'nodes':[{'mesh':0},{'extensions':{'KHR_lights_punctual':{'light':0}}},{'camera':0}],"                  \
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],'animations':[{"                 \
    "'name':'all','samplers':[{'input':1,'output':2},{'input':1,'output':3},{'input':1,'output':4}],"        \
    "'channels':["
#define SECOND                                                                                               \
    "]},{'name':'rest','samplers':[{'input':1,'output':3}],'channels':[{'sampler':0,'target':{'node':0,"     \
    "'path':'translation'}}"
#define AFTER                                                                                                \
    "]}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','min':[0,0,0],"           \
    "'max':[1,1,0]},{'bufferView':1,'componentType':5126,'count':2,'type':'SCALAR','min':[0],'max':[1]},"    \
    "{'bufferView':2,'componentType':5126,'count':2,'type':'SCALAR'},"                                       \
    "{'bufferView':3,'componentType':5126,'count':2,'type':'VEC3'},"                                         \
    "{'bufferView':4,'componentType':5126,'count':2,'type':'VEC4'}],'bufferViews':["                         \
    "{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':8},"                              \
    "{'buffer':0,'byteOffset':44,'byteLength':8},{'buffer':0,'byteOffset':52,'byteLength':24},"              \
    "{'buffer':0,'byteOffset':76,'byteLength':32}],'buffers':[{'uri':'data.bin','byteLength':108}]}"

#define MATERIAL "/materials/0/pbrMetallicRoughness"

static const struct {
    float triangle[9], times[2], numbers[2], vectors[2][3], colors[2][4];
} data = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
          {0, 1},
          {0.2f, 0.6f},
          {{0, 0, 0}, {1, 0.5f, 0.25f}},
          {{0, 0, 0, 1}, {1, 1, 1, 0}}};

/* clang-format off */
static const char all[] = BEFORE
    POINT(2, MATERIAL "/baseColorFactor") ","
    POINT(0, MATERIAL "/metallicFactor") ","
    POINT(0, MATERIAL "/roughnessFactor") ","
    POINT(1, "/materials/0/emissiveFactor") ","
    POINT(0, "/materials/0" STRENGTH) ","
    POINT(1, LIGHTS "/color") ","
    POINT(0, LIGHTS "/intensity") ","
    POINT(0, LIGHTS "/range") ","
    POINT(0, LIGHTS "/spot/innerConeAngle") ","
    POINT(0, LIGHTS "/spot/outerConeAngle") ","
    POINT(0, "/cameras/0/perspective/yfov")
    SECOND AFTER;
static const char strength_alone[] = BEFORE POINT(0, "/materials/0" STRENGTH) SECOND AFTER;
static const char missing[] = BEFORE POINT(0, "/materials/1" STRENGTH) SECOND AFTER;
static const char too_wide[] = BEFORE POINT(1, LIGHTS "/range") SECOND AFTER;
/* clang-format on */

typedef struct stage {
    kd_jobs *jobs;
    kd_world *world;
    kd_schedule *schedule;
    kd_entity root;
} stage;

static void stage_init(stage *s, const char *json)
{
    uint32_t number;
    kd_model *model = load_good(json, &data, sizeof data);
    assert_int_equal(model->warning_count, 0);
    s->jobs = kd_jobs_make(1);
    s->world = kd_world_make();
    s->schedule = kd_schedule_make(s->world, s->jobs, NULL);
    assert_int_equal(kd_animation_import(s->schedule), KD_OK);
    assert_int_equal(kd_schedule_init(s->schedule), KD_OK);
    assert_int_equal(kd_scene_add_model(s->world, model, &number), KD_OK);
    assert_int_equal(kd_scene_instantiate(s->world, number, KD_NO_ENTITY, "hero", &s->root), KD_OK);
}

static void stage_fini(stage *s)
{
    kd_schedule_destroy(s->schedule);
    kd_world_destroy(s->world);
    kd_jobs_destroy(s->jobs);
}

static void show_at(stage *s, float time_s)
{
    kd_find_mut(s->world, s->root, kd_animation)->time_s = time_s;
    assert_int_equal(kd_schedule_run(s->schedule), KD_OK);
}

static const kd_material_desc *material(const stage *s)
{
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    return &store->materials[store->models[0].first_material].desc;
}

static kd_entity node(const stage *s, uint32_t index)
{
    const kd_scene_store *store = kd_singleton(s->world, kd_scene_store);
    return store->node_entities[kd_find(s->world, s->root, kd_animation)->first_node + index];
}

static void assert_three(kd_vec3 v, float x, float y, float z)
{
    assert_float_equal(v.x, x, EPSILON);
    assert_float_equal(v.y, y, EPSILON);
    assert_float_equal(v.z, z, EPSILON);
}

/* Half way numbers are 0.4, vectors (0.5, 0.25, 0.125); emission is factor times strength. */
static void materials_lights_and_cameras_are_moved(void **state)
{
    stage s;
    (void)state;
    stage_init(&s, all);
    show_at(&s, 0.5f);
    const kd_material_desc *m = material(&s);
    assert_three((kd_vec3){m->base_color.x, m->base_color.y, m->base_color.z}, 0.5f, 0.5f, 0.5f);
    assert_float_equal(m->base_color.w, 0.5f, EPSILON);
    assert_float_equal(m->metallic, 0.4f, EPSILON);
    assert_float_equal(m->roughness, 0.4f, EPSILON);
    assert_three(m->emissive, 0.2f, 0.1f, 0.05f);
    const kd_light *light = kd_find(s.world, node(&s, 1), kd_light);
    assert_three(light->color, 0.5f, 0.25f, 0.125f);
    assert_float_equal(light->intensity, 0.4f, EPSILON);
    assert_float_equal(light->range, 0.4f, EPSILON);
    assert_float_equal(light->inner_cone, 0.4f, EPSILON);
    assert_float_equal(light->outer_cone, 0.4f, EPSILON);
    assert_float_equal(kd_find(s.world, node(&s, 2), kd_camera)->fov_y, 0.4f, EPSILON);
    stage_fini(&s);
}

/* The factor at rest is (1, 0.5, 0); the strength goes from 0.2 to 0.6. */
static void a_strength_alone_scales_the_factor_at_rest(void **state)
{
    stage s;
    (void)state;
    stage_init(&s, strength_alone);
    for (int i = 0; i < 3; i++)
        show_at(&s, 0.5f);
    assert_three(material(&s)->emissive, 0.4f, 0.2f, 0);
    stage_fini(&s);
}

static void what_the_next_clip_leaves_alone_fades_to_rest(void **state)
{
    stage s;
    (void)state;
    stage_init(&s, all);
    show_at(&s, 0.5f);
    kd_singleton(s.world, kd_frame)->dt_s = 0.5f;
    assert_int_equal(kd_scene_play(s.world, s.root, "rest", true, 1, 1), KD_OK);
    for (int i = 0; i < 4; i++)
        assert_int_equal(kd_schedule_run(s.schedule), KD_OK);
    assert_three(material(&s)->emissive, 4, 2, 0);
    assert_float_equal(material(&s)->metallic, 1, EPSILON);
    assert_float_equal(kd_find(s.world, node(&s, 1), kd_light)->intensity, 8, EPSILON);
    assert_float_equal(kd_find(s.world, node(&s, 2), kd_camera)->fov_y, 1, EPSILON);
    stage_fini(&s);
}

static void materials_come_back_to_their_file(void **state)
{
    stage s;
    (void)state;
    stage_init(&s, all);
    show_at(&s, 0.5f);
    kd_scene_restore_materials(s.world);
    const kd_store_model *model = kd_singleton(s.world, kd_scene_store)->models;
    kd_material_desc rest = model->model->materials[0];
    assert_float_equal(material(&s)->base_color.x, 1, EPSILON);
    assert_float_equal(material(&s)->metallic, 1, EPSILON);
    assert_memory_equal(&material(&s)->emissive, &rest.emissive, sizeof rest.emissive);
    assert_int_equal(material(&s)->base_color_map.image, KD_NONE);
    stage_fini(&s);
}

static void bad_pointers_are_refused(void **state)
{
    (void)state;
    load_bad(missing, &data, sizeof data, KD_BAD_FORMAT, "points to what is not there");
    load_bad(too_wide, &data, sizeof data, KD_BAD_FORMAT, "values have a type");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_lights_and_cameras_are_moved),
        cmocka_unit_test(a_strength_alone_scales_the_factor_at_rest),
        cmocka_unit_test(what_the_next_clip_leaves_alone_fades_to_rest),
        cmocka_unit_test(materials_come_back_to_their_file),
        cmocka_unit_test(bad_pointers_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
