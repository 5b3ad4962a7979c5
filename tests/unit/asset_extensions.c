/* Extensions that change which nodes and materials there are: instancing, visibility, variants, and files of
 * several scenes. */

#include <math.h>

#include "tests/unit/asset_support.h"

#define TRIANGLE "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}"
static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* ---- EXT_mesh_gpu_instancing ---- */

#define INSTANCED(attributes, count)                                                                         \
    "{'asset':{'version':'2.0'},'extensionsUsed':['EXT_mesh_gpu_instancing'],"                               \
    "'nodes':[{'name':'grass','mesh':0,'translation':[10,0,0],'extensions':{'EXT_mesh_gpu_instancing':{"     \
    "'attributes':{" attributes "}}}}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"           \
    "'accessors':[" TRIANGLE ",{'bufferView':1,'componentType':5126,'count':" count ",'type':'VEC3'},"       \
    "{'bufferView':2,'componentType':5122,'normalized':true,'count':2,'type':'VEC4'},"                       \
    "{'bufferView':3,'componentType':5126,'count':2,'type':'VEC3'}],'bufferViews':["                         \
    "{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':24},"                             \
    "{'buffer':0,'byteOffset':60,'byteLength':16},{'buffer':0,'byteOffset':76,'byteLength':24}],"            \
    "'buffers':[{'uri':'data.bin','byteLength':100}]}"

struct copies {
    float triangle[9], translation[2][3];
    int16_t rotation[2][4];
    float scale[2][3];
};
static struct copies make_copies(void)
{
    struct copies c = {.translation = {{1, 2, 3}, {4, 5, 6}},
                       .rotation = {{0, 0, 0, 32767}, {0, 23170, 0, 23170}},
                       .scale = {{1, 1, 1}, {2, 3, 4}}};
    memcpy(c.triangle, triangle, sizeof triangle);
    return c;
}

static void copies_become_nodes(void **state)
{
    (void)state;
    struct copies c = make_copies();
    kd_model *m = load_good(INSTANCED("'TRANSLATION':1,'ROTATION':2,'SCALE':3", "2"), &c, sizeof c);
    assert_int_equal(m->warning_count, 0);
    assert_int_equal(m->node_count, 3);
    assert_int_equal(m->nodes[0].mesh, KD_NONE);
    for (uint32_t i = 1; i < 3; i++) {
        assert_int_equal(m->nodes[i].parent, 0);
        assert_int_equal(m->nodes[i].mesh, 0);
        assert_vec3(m->nodes[i].translation, c.translation[i - 1][0], c.translation[i - 1][1],
                    c.translation[i - 1][2], 0);
    }
    assert_vec3(m->nodes[2].scale, 2, 3, 4, 0);
    NEAR(m->nodes[2].rotation.y, sqrtf(0.5f), 1e-4f);
    assert_string_equal(m->nodes[2].name, "grass copy 1");
    assert_int_equal(m->triangle_count, 2);
    NEAR(m->bounds_max.y, 8, 1e-4f); /* the second copy: 5 + 3 * 1 */
    kd_model_destroy(m);
}

static void copies_with_one_part_keep_the_rest(void **state)
{
    (void)state;
    struct copies c = make_copies();
    kd_model *m = load_good(INSTANCED("'TRANSLATION':1", "2"), &c, sizeof c);
    assert_int_equal(m->node_count, 3);
    assert_vec3(m->nodes[2].scale, 1, 1, 1, 0);
    NEAR(m->nodes[2].rotation.w, 1, 0);
    kd_model_destroy(m);
}

static void bad_copies_are_refused(void **state)
{
    (void)state;
    struct copies c = make_copies();
    load_bad(INSTANCED("'TRANSLATION':1,'SCALE':3", "1"), &c, sizeof c, KD_BAD_FORMAT, "differ in length");
    load_bad(INSTANCED("'TRANSLATION':2", "2"), &c, sizeof c, KD_BAD_FORMAT, "type");
    load_bad(INSTANCED("'TRANSLATION':77", "2"), &c, sizeof c, KD_BAD_FORMAT, "no accessor 77");
}

/* ---- KHR_node_visibility ---- */

static void hidden_nodes_show_nothing_below(void **state)
{
    (void)state;
    kd_model *m = load_good(
        "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_node_visibility','KHR_lights_punctual'],"
        "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}},'cameras':[{'type':'perspective',"
        "'perspective':{'yfov':1,'znear':0.1}}],'nodes':[{'mesh':0},{'mesh':0,'children':[2,3],'extensions':{"
        "'KHR_node_visibility':{'visible':false}}},{'mesh':0,'extensions':{'KHR_node_visibility':{"
        "'visible':true}}},{'camera':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'accessors':[" TRIANGLE
        "],'bufferViews':[{'buffer':0,'byteLength':36}],'buffers':[{'uri':'data.bin','byteLength':36}]}",
        triangle, sizeof triangle);
    assert_int_equal(m->node_count, 4);
    assert_int_equal(m->nodes[0].mesh, 0);
    assert_int_equal(m->nodes[1].mesh, KD_NONE);
    assert_int_equal(m->nodes[2].mesh, KD_NONE);
    assert_int_equal(m->nodes[3].light, KD_NONE);
    assert_int_equal(m->nodes[3].camera, 0);
    assert_int_equal(m->triangle_count, 1);
    kd_model_destroy(m);
}

/* ---- KHR_materials_variants, scenes ---- */

#define CHOICES                                                                                              \
    "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_materials_variants'],'extensions':{"                  \
    "'KHR_materials_variants':{'variants':[{'name':'day'},{'name':'night'}]}},"                              \
    "'scene':1,'scenes':[{'name':'left','nodes':[0]},{'name':'right','nodes':[1]}],"                         \
    "'nodes':[{'name':'l','mesh':0},{'name':'r','mesh':0}],'materials':[{'name':'plain'},{'name':'sun'},"    \
    "{'name':'moon'}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0,'extensions':{"     \
    "'KHR_materials_variants':{'mappings':[{'material':1,'variants':[0]},{'material':%d,'variants':[1,9]}"   \
    "]}}}]}],'accessors':[" TRIANGLE                                                                         \
    "],'bufferViews':[{'buffer':0,'byteLength':36}],'buffers':[{'uri':'data.bin','byteLength':36}]}"

static kd_status load_choice(const char *scene, const char *variant, int moon, kd_model **out)
{
    char json[2048], *text = json;
    snprintf(json, sizeof json, CHOICES, moon);
    for (; *text; text++)
        *text = *text == '\'' ? '"' : *text;
    write_bytes(in_folder("case.gltf"), json, strlen(json));
    write_bytes(in_folder("data.bin"), triangle, sizeof triangle);
    watch_messages();
    return kd_model_load_with(in_folder("case.gltf"), &(kd_model_options){.scene = scene, .variant = variant},
                              out);
}

static void variants_choose_materials(void **state)
{
    static const char *const variants[] = {NULL, "day", "night"};
    kd_model *m;
    (void)state;
    for (uint32_t i = 0; i < 3; i++) {
        assert_int_equal(load_choice(NULL, variants[i], 2, &m), KD_OK);
        assert_int_equal(m->meshes[0].primitives[0].material, i);
        assert_string_equal(m->variants[1], "night");
        assert_null(m->variants[2]);
        kd_model_destroy(m);
    }
    assert_int_equal(load_choice(NULL, "nigth", 2, &m), KD_NOT_FOUND);
    assert_non_null(strstr(seen_messages.last_error, "'night'"));
    assert_int_equal(load_choice(NULL, "night", 7, &m), KD_BAD_FORMAT);
    assert_non_null(strstr(seen_messages.last_error, "no material 7"));
}

static void scenes_are_chosen_by_name(void **state)
{
    kd_model *m;
    (void)state;
    assert_int_equal(load_choice(NULL, NULL, 2, &m), KD_OK);
    assert_int_equal(m->scene, 1);
    assert_string_equal(m->nodes[0].name, "r");
    kd_model_destroy(m);
    assert_int_equal(load_choice("left", NULL, 2, &m), KD_OK);
    assert_int_equal(m->scene, 0);
    assert_int_equal(m->node_count, 1);
    assert_string_equal(m->nodes[0].name, "l");
    kd_model_destroy(m);
    assert_int_equal(load_choice("middle", NULL, 2, &m), KD_NOT_FOUND);
    assert_int_equal(seen_messages.errors, 1);
}

/* ---- KHR_animation_pointer ---- */

static void pointers_to_nodes_are_channels(void **state)
{
    struct {
        float triangle[9], times[2], values[2][3];
    } data = {.times = {0, 1}, .values = {{0, 0, 0}, {1, 2, 3}}};
    (void)state;
    memcpy(data.triangle, triangle, sizeof triangle);
    kd_model *m = load_good(
        "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_animation_pointer'],"
        "'extensionsRequired':['KHR_animation_pointer'],'nodes':[{'name':'a'},{'name':'b','mesh':0}],"
        "'animations':[{'samplers':[{'input':1,'output':2}],'channels':["
        "{'sampler':0,'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{"
        "'pointer':'/nodes/1/translation'}}}},"
        "{'sampler':0,'target':{'path':'pointer','extensions':{'KHR_animation_pointer':{"
        "'pointer':'/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/"
        "offset'"
        "}}}}]}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'accessors':[" TRIANGLE
        ",{'bufferView':1,'componentType':5126,'count':2,'type':'SCALAR','min':[0],'max':[1]},"
        "{'bufferView':2,'componentType':5126,'count':2,'type':'VEC3'}],'bufferViews':["
        "{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':8},"
        "{'buffer':0,'byteOffset':44,'byteLength':24}],'buffers':[{'uri':'data.bin','byteLength':68}]}",
        &data, sizeof data);
    assert_int_equal(m->clip_count, 1);
    assert_int_equal(m->clips[0].channel_count, 1);
    assert_int_equal(m->clips[0].channels[0].node, 1);
    assert_int_equal(m->clips[0].channels[0].path, KD_PATH_TRANSLATION);
    assert_memory_equal(m->clips[0].channels[0].values, data.values, sizeof data.values);
    assert_int_equal(m->warning_count, 1);
    assert_non_null(strstr(m->warnings[0], "KHR_texture_transform/offset'")); /* named whole, long as it is */
    kd_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copies_become_nodes),
        cmocka_unit_test(copies_with_one_part_keep_the_rest),
        cmocka_unit_test(bad_copies_are_refused),
        cmocka_unit_test(hidden_nodes_show_nothing_below),
        cmocka_unit_test(variants_choose_materials),
        cmocka_unit_test(scenes_are_chosen_by_name),
        cmocka_unit_test(pointers_to_nodes_are_channels),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
