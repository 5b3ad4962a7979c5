/* Nodes, skins, clips, cameras, lights and extensions from small files written here. */

#include <math.h>

#include "tests/unit/asset_support.h"

/* A triangle at mesh 0, so that there is something to draw; `rest` brings nodes and what else a test is
 * about. Its accessor is 0, its 36 bytes come first in data.bin. */
#define FILE_WITH(rest, accessors, views, bytes)                                                             \
    "{'asset':{'version':'2.0'}," rest ",'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],"         \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}" accessors "],"              \
    "'bufferViews':[{'buffer':0,'byteLength':36}" views "],'buffers':[{'uri':'data.bin','byteLength':" bytes \
    "}]}"
#define PLAIN(rest) FILE_WITH(rest, "", "", "36"), triangle, sizeof triangle

static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

/* ---- nodes ---- */

static void nodes_come_parents_first_with_names(void **state)
{
    (void)state;
    kd_model *m = load_good(PLAIN("'scene':0,'scenes':[{'nodes':[2]}],'nodes':[{'mesh':0,'name':'leaf'},{'"
                                  "children':[0]},{'children':[1]},{'mesh':0}]"));
    assert_int_equal(m->node_count, 3); /* the fourth is in no scene */
    assert_int_equal(m->triangle_count, 1);
    assert_int_equal(m->nodes[0].parent, KD_NONE);
    assert_int_equal(m->nodes[1].parent, 0);
    assert_int_equal(m->nodes[2].parent, 1);
    assert_string_equal(m->nodes[2].name, "leaf");
    assert_string_equal(m->nodes[0].name, "node 2"); /* made from its place in the file */
    kd_model_destroy(m);
}

static void graphs_that_are_no_forest_are_refused(void **state)
{
    (void)state;
    load_bad(PLAIN("'nodes':[{'children':[1]},{'children':[0],'mesh':0}]"), KD_BAD_FORMAT, "own ancestor");
    load_bad(PLAIN("'nodes':[{'children':[0],'mesh':0}]"), KD_BAD_FORMAT, "own ancestor");
    load_bad(PLAIN("'nodes':[{'mesh':0},{'children':[2]},{'children':[3]},{'children':[1]}]"), KD_BAD_FORMAT,
             "own ancestor");
    load_bad(PLAIN("'nodes':[{'children':[2]},{'children':[2]},{'mesh':0}]"), KD_BAD_FORMAT, "two parents");
    load_bad(PLAIN("'nodes':[{'children':[1,1]},{'mesh':0}]"), KD_BAD_FORMAT, "two parents");
    load_bad(PLAIN("'nodes':[{'children':[9],'mesh':0}]"), KD_BAD_FORMAT, "no node 9 (nodes[0].children[0])");
    load_bad(PLAIN("'scene':0,'scenes':[{'nodes':[1]}],'nodes':[{'children':[1]},{'mesh':0}]"), KD_BAD_FORMAT,
             "no root");
    load_bad(PLAIN("'scene':4,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}]"), KD_BAD_FORMAT, "no scene 4");
    load_bad(PLAIN("'nodes':[{'mesh':0,'scale':[1e39,1,1]}]"), KD_BAD_FORMAT,
             "nodes[0].scale"); /* infinite as a float */
    load_bad(PLAIN("'nodes':[{'mesh':0,'translation':[1,2]}]"), KD_BAD_FORMAT, "nodes[0].translation");
}

static void matrices_are_split_into_turn_and_scale(void **state)
{
    (void)state;
    /* A quarter turn round z times scale (2, 3, 4), moved by (5, 6, 7): columns 2y, -3x, 4z. */
    kd_model *m = load_good(PLAIN("'nodes':[{'mesh':0,'matrix':[0,2,0,0,-3,0,0,0,0,0,4,0,5,6,7,1]}]"));
    const kd_node_desc *n = &m->nodes[0];
    assert_false(n->has_matrix);
    assert_vec3(n->scale, 2, 3, 4, 1e-6f);
    assert_vec3(n->translation, 5, 6, 7, 0);
    NEAR(fabsf(n->rotation.z), sqrtf(0.5f), 1e-6f); /* sin 45 degrees */
    NEAR(n->rotation.z, n->rotation.w, 1e-6f);
    kd_model_destroy(m);
}

static void every_split_matrix_composes_again(void **state)
{
    (void)state;
    /* Half turns and mirrors take each branch of the split. */
    static const char *const matrices[] = {"1,0,0,0,0,-1,0,0,0,0,-1,0", "-1,0,0,0,0,1,0,0,0,0,-1,0",
                                           "-1,0,0,0,0,-1,0,0,0,0,1,0", "-1,0,0,0,0,1,0,0,0,0,1,0",
                                           "0,0,1,0,0,2,0,0,3,0,0,0",   "-1,0,0,0,0,-1,0,0,0,0,-1,0"};
    for (size_t i = 0; i < sizeof matrices / sizeof *matrices; i++) {
        char json[1024];
        snprintf(json, sizeof json, FILE_WITH("'nodes':[{'mesh':0,'matrix':[%s,0,0,0,1]}]", "", "", "36"),
                 matrices[i]);
        kd_model *m = load_good(json, triangle, sizeof triangle);
        const kd_node_desc *n = &m->nodes[0];
        assert_false(n->has_matrix);
        kd_mat4 again = kd_mat4_from_trs(n->translation, n->rotation, n->scale);
        for (int k = 0; k < 16; k++)
            NEAR(again.m[k], n->matrix.m[k], 1e-6f);
        kd_model_destroy(m);
    }
}

static void sheared_matrices_stay_matrices(void **state)
{
    (void)state;
    kd_model *m = load_good(PLAIN("'nodes':[{'mesh':0,'matrix':[1,0,0,0,0.5,1,0,0,0,0,1,0,0,0,0,1]}]"));
    assert_true(m->nodes[0].has_matrix);
    NEAR(m->nodes[0].matrix.m[4], 0.5f, 0);
    assert_vec3(m->bounds_max, 1, 1, 0, 1e-6f); /* corner (0, 1) moves to (0.5, 1) */
    kd_model_destroy(m);
}

/* ---- skins ---- */

static const char skin_format[] =
    "{'asset':{'version':'2.0'},'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'skin':0,'translation':[100,0,0]}"
    ",{'children':[2]},"
    "{'translation':[0,1,0]}],'skins':[{'joints':[%s]%s}],'meshes':[{'primitives':[{'attributes':{'POSITION':"
    "0,'JOINTS_0':1,"
    "'WEIGHTS_0':2}}]}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"
    "{'bufferView':1,'componentType':5121,'count':3,'type':'VEC4'},{'bufferView':2,'componentType':5121,'"
    "normalized':true,'count':3,'type':'VEC4'},"
    "{'bufferView':3,'componentType':5126,'count':1,'type':'MAT4'}],'bufferViews':[{'buffer':0,'byteLength':"
    "36},"
    "{'buffer':0,'byteOffset':36,'byteLength':12},{'buffer':0,'byteOffset':48,'byteLength':12},{'buffer':0,'"
    "byteOffset':60,'byteLength':64}],"
    "'buffers':[{'uri':'data.bin','byteLength':124}]}";

typedef struct skin_data {
    float at[9];
    uint8_t joints[12], weights[12];
    float matrix[16];
} skin_data;
static const skin_data two_joints = {
    {0, 0, 0, 1, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {255, 0, 0, 0, 255, 0, 0, 0, 255}, {0}};

static void skins_bring_their_joints_and_pose_the_bounds(void **state)
{
    (void)state;
    char json[2048];
    snprintf(json, sizeof json, skin_format, "1,2", "");
    kd_model *m = load_good(json, &two_joints, sizeof two_joints);
    assert_int_equal(m->node_count, 3); /* the joints stand outside the scene and are brought in */
    assert_int_equal(m->skins[0].joint_count, 2);
    assert_int_equal(m->skins[0].joints[0], 1);
    assert_int_equal(m->nodes[m->skins[0].joints[1]].parent, 1);
    NEAR(m->skins[0].inverse_bind[1].m[0], 1, 0); /* none in the file: identity */
    /* All vertices follow joint 1, which stands at y = 1; the node's own place does not count
     * (glTF 2.0, 3.7.3.3). */
    assert_vec3(m->bounds_min, 0, 1, 0, 1e-6f);
    assert_vec3(m->bounds_max, 1, 2, 0, 1e-6f);
    kd_model_destroy(m);
}

static void skins_that_do_not_fit_are_refused(void **state)
{
    (void)state;
    char json[2048];
    snprintf(json, sizeof json, skin_format, "1", "");
    load_bad(json, &two_joints, sizeof two_joints, KD_BAD_FORMAT, "uses joint 1, but skins[0] has 1");
    snprintf(json, sizeof json, skin_format, "1,8", "");
    load_bad(json, &two_joints, sizeof two_joints, KD_BAD_FORMAT, "no node 8 (skins[0].joints[1])");
    snprintf(json, sizeof json, skin_format, "1,2", ",'inverseBindMatrices':3");
    load_bad(json, &two_joints, sizeof two_joints, KD_BAD_FORMAT, "1 matrices for 2 joints");
    snprintf(json, sizeof json, skin_format, "1,2", ",'inverseBindMatrices':0");
    load_bad(json, &two_joints, sizeof two_joints, KD_BAD_FORMAT, "not float matrices");
    skin_data infinite = two_joints;
    infinite.matrix[5] = INFINITY;
    snprintf(json, sizeof json, skin_format, "1", ",'inverseBindMatrices':3");
    infinite.joints[0] = infinite.joints[4] = infinite.joints[8] = 0;
    load_bad(json, &infinite, sizeof infinite, KD_BAD_FORMAT, "not finite (skins[0].inverseBindMatrices");
}

/* ---- clips ---- */

#define ANIMATED(path, interpolation, value_type, value_count)                                               \
    FILE_WITH(                                                                                               \
        "'nodes':[{'mesh':0}],'animations':[{'name':'move','channels':[{'sampler':0,'target':{'node':0,'"    \
        "path':'" path "'}}],'samplers':[{'input':1,'output':2,'interpolation':'" interpolation "'}]}]",     \
        ",{'bufferView':1,'componentType':5126,'count':2,'type':'SCALAR'},"                                  \
        "{'bufferView':2,'componentType':5126,'count':" value_count ",'type':'" value_type "'}",             \
        ",{'buffer':0,'byteOffset':36,'byteLength':8},{'buffer':0,'byteOffset':44,'byteLength':96}", "140")

typedef struct clip_data {
    float at[9], times[2], values[24];
} clip_data;

static void clips_of_each_interpolation_are_read(void **state)
{
    (void)state;
    clip_data data = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0.5f, 2}, {0}};
    for (int i = 0; i < 24; i++)
        data.values[i] = (float)i;
    kd_model *m = load_good(ANIMATED("translation", "STEP", "VEC3", "2"), &data, sizeof data);
    const kd_channel_desc *c = &m->clips[0].channels[0];
    assert_string_equal(m->clips[0].name, "move");
    NEAR(m->clips[0].duration, 2, 0);
    assert_int_equal(c->interpolation, KD_INTERPOLATE_STEP);
    assert_int_equal(c->key_count, 2);
    NEAR(c->values[5], 5, 0);
    kd_model_destroy(m);
    m = load_good(ANIMATED("scale", "LINEAR", "VEC3", "2"), &data, sizeof data);
    assert_int_equal(m->clips[0].channels[0].path, KD_PATH_SCALE);
    assert_int_equal(m->clips[0].channels[0].interpolation, KD_INTERPOLATE_LINEAR);
    kd_model_destroy(m);
    m = load_good(ANIMATED("rotation", "CUBICSPLINE", "VEC4", "6"), &data, sizeof data);
    c = &m->clips[0].channels[0];
    assert_int_equal(c->interpolation, KD_INTERPOLATE_CUBIC);
    assert_int_equal(c->width, 4);
    NEAR(c->values[0], 0, 0); /* the in-tangent 0 1 2 3 stays */
    NEAR(c->values[3], 3, 0);
    NEAR(c->values[4], 4 / sqrtf(16 + 25 + 36 + 49), 1e-6f); /* the value 4 5 6 7 is normalised */
    NEAR(c->values[8], 8, 0);                                /* the out-tangent stays */
    kd_model_destroy(m);
}

static void clips_that_do_not_fit_are_refused(void **state)
{
    (void)state;
    clip_data data = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0.5f, 2}, {0}};
    load_bad(ANIMATED("translation", "LINEAR", "VEC3", "3"), &data, sizeof data, KD_BAD_FORMAT,
             "3 values where 2 are wanted");
    load_bad(ANIMATED("translation", "CUBICSPLINE", "VEC3", "2"), &data, sizeof data, KD_BAD_FORMAT,
             "2 values where 6 are wanted");
    load_bad(ANIMATED("rotation", "LINEAR", "VEC3", "2"), &data, sizeof data, KD_BAD_FORMAT, "type");
    load_bad(ANIMATED("translation", "SMOOTH", "VEC3", "2"), &data, sizeof data, KD_BAD_FORMAT,
             "'SMOOTH' is no interpolation");
    data.values[1] = NAN;
    load_bad(ANIMATED("translation", "LINEAR", "VEC3", "2"), &data, sizeof data, KD_BAD_FORMAT,
             "not finite (animations[0].samplers[0]");
    data.values[1] = 0;
    data.times[1] = 0.5f;
    load_bad(ANIMATED("translation", "LINEAR", "VEC3", "2"), &data, sizeof data, KD_BAD_FORMAT,
             "key 1 does not follow");
    data.times[1] = INFINITY;
    load_bad(ANIMATED("translation", "LINEAR", "VEC3", "2"), &data, sizeof data, KD_BAD_FORMAT, "not finite");
}

static void channels_that_move_nothing_are_left_out(void **state)
{
    (void)state;
    clip_data data = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1}, {0}};
    kd_model *m = load_good(ANIMATED("weights", "LINEAR", "SCALAR", "2"), &data,
                            sizeof data); /* no morph targets there */
    assert_int_equal(m->clips[0].channel_count, 0);
    assert_int_equal(m->warning_count, 1);
    kd_model_destroy(m);
    m = load_good(ANIMATED("pointer", "LINEAR", "SCALAR", "2"), &data, sizeof data);
    assert_int_equal(m->clips[0].channel_count, 0);
    assert_non_null(strstr(m->warnings[0], "'pointer'"));
    kd_model_destroy(m);
}

/* ---- cameras and lights ---- */

static void cameras_are_checked(void **state)
{
    (void)state;
    kd_model *m =
        load_good(PLAIN("'nodes':[{'mesh':0,'camera':1}],'cameras':[{'type':'perspective','perspective':{'"
                        "yfov':1,'znear':0.1}},"
                        "{'type':'orthographic','orthographic':{'xmag':2,'ymag':3,'znear':0,'zfar':9}}]"));
    NEAR(m->cameras[0].fov_y, 1, 0);
    NEAR(m->cameras[0].z_far, 0, 0);
    NEAR(m->cameras[0].aspect, 0, 0);
    assert_true(m->cameras[1].orthographic);
    NEAR(m->cameras[1].y_mag, 3, 0);
    assert_int_equal(m->nodes[0].camera, 1);
    kd_model_destroy(m);
    static const char *const bad[] = {"'yfov':0,'znear':0.1",        "'yfov':-1,'znear':0.1",
                                      "'yfov':4,'znear':1",          "'yfov':1,'znear':0",
                                      "'yfov':1,'znear':2,'zfar':1", "'yfov':1,'znear':0.1,'aspectRatio':-2"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char json[1024];
        snprintf(json, sizeof json,
                 FILE_WITH("'nodes':[{'mesh':0}],'cameras':[{'type':'perspective','perspective':{%s}}]", "",
                           "", "36"),
                 bad[i]);
        load_bad(json, triangle, sizeof triangle, KD_BAD_FORMAT, "cameras[0]");
    }
}

#define LIT(light)                                                                                           \
    "'nodes':[{'mesh':0,'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensionsUsed':['KHR_lights_"   \
    "punctual'],"                                                                                            \
    "'extensions':{'KHR_lights_punctual':{'lights':[" light "]}}"

static void lights_are_read_with_their_defaults(void **state)
{
    (void)state;
    kd_model *m =
        load_good(PLAIN(LIT("{'type':'spot','intensity':5,'color':[1,0.5,0],'range':3,'spot':{}}")));
    const kd_model_light *light = &m->lights[0];
    assert_int_equal(light->type, KD_LIGHT_SPOT);
    assert_vec3(light->color, 1, 0.5f, 0, 0);
    NEAR(light->intensity, 5, 0);
    NEAR(light->range, 3, 0);
    NEAR(light->outer_cone, 0.78539816f, 1e-6f); /* a quarter of pi by default */
    assert_int_equal(m->nodes[0].light, 0);
    kd_model_destroy(m);
    load_bad(PLAIN(LIT("{'type':'laser'}")), KD_BAD_FORMAT, "'laser' is no light type");
    load_bad(PLAIN(LIT("{'type':'point','intensity':-1}")), KD_BAD_FORMAT, "not negative");
    load_bad(PLAIN(LIT("{'type':'spot','spot':{'innerConeAngle':1,'outerConeAngle':0.5}}")), KD_BAD_FORMAT,
             "inner < outer");
    load_bad(PLAIN(LIT("")), KD_BAD_FORMAT, "nodes[0].light");
}

/* ---- the head of the file ---- */

static void required_extensions_are_refused_by_name(void **state)
{
    (void)state;
    load_bad(PLAIN("'nodes':[{'mesh':0}],'extensionsUsed':['KHR_texture_basisu'],'extensionsRequired'"
                   ":['KHR_texture_basisu']"),
             KD_UNSUPPORTED, "'KHR_texture_basisu'");
    /* what the extension leaves out looks like mistakes to a reader that does not know it */
    load_bad("{'asset':{'version':'2.0'},'extensionsRequired':['KHR_mesh_quantization','KHR_other'],"
             "'accessors':[{'bufferView':'none'}],'buffers':[{}]}",
             NULL, 0, KD_UNSUPPORTED, "'KHR_other'");
    load_bad("{'asset':{'version':'2.0'},'extensionsRequired':[],'accessors':[{'bufferView':'none'}]}", NULL,
             0, KD_BAD_FORMAT, "Accessor");
    kd_model *m = load_good(PLAIN("'nodes':[{'mesh':0}],'extensionsUsed':['KHR_materials_sheen','KHR_mesh_"
                                  "quantization'],'extensionsRequired':['KHR_mesh_quantization']"));
    assert_int_equal(m->warning_count, 1);
    assert_non_null(strstr(m->warnings[0], "KHR_materials_sheen"));
    assert_string_equal(m->extensions_used[1], "KHR_mesh_quantization");
    assert_null(m->extensions_used[2]);
    kd_model_destroy(m);
}

static void versions_other_than_2_are_refused(void **state)
{
    (void)state;
    load_bad("{'asset':{'version':'1.0'},'buffers':{},'meshes':{}}", NULL, 0, KD_UNSUPPORTED, "glTF '1.0'");
    load_bad("{'asset':{'version':'3.0'}}", NULL, 0, KD_UNSUPPORTED, "glTF '3.0'");
    load_bad("{'asset':{'version':'2.1','minVersion':'2.1'}}", NULL, 0, KD_UNSUPPORTED, "minVersion");
    load_bad("{'asset':{}}", NULL, 0, KD_BAD_FORMAT, "asset");
    load_bad("hello", NULL, 0, KD_BAD_FORMAT, "case.gltf");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_come_parents_first_with_names),
        cmocka_unit_test(graphs_that_are_no_forest_are_refused),
        cmocka_unit_test(matrices_are_split_into_turn_and_scale),
        cmocka_unit_test(every_split_matrix_composes_again),
        cmocka_unit_test(sheared_matrices_stay_matrices),
        cmocka_unit_test(skins_bring_their_joints_and_pose_the_bounds),
        cmocka_unit_test(skins_that_do_not_fit_are_refused),
        cmocka_unit_test(clips_of_each_interpolation_are_read),
        cmocka_unit_test(clips_that_do_not_fit_are_refused),
        cmocka_unit_test(channels_that_move_nothing_are_left_out),
        cmocka_unit_test(cameras_are_checked),
        cmocka_unit_test(lights_are_read_with_their_defaults),
        cmocka_unit_test(required_extensions_are_refused_by_name),
        cmocka_unit_test(versions_other_than_2_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
