/* Meshes from small files written here: topologies, types, sparse values, what is made and what is refused.
 */

#include <math.h>

#include "tests/unit/asset_support.h"

/* One mesh, one node; the test gives primitives, accessors and views over data.bin. */
#define FILE_OF(primitives, accessors, views, bytes)                                                         \
    "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"                    \
    "'meshes':[{'primitives':[" primitives "]}],'accessors':[" accessors "],'bufferViews':[" views "],"      \
    "'buffers':[{'uri':'data.bin','byteLength':" bytes "}]}"

#define VEC3(view, count)    "{'bufferView':" view ",'componentType':5126,'count':" count ",'type':'VEC3'}"
#define VEC2(view, count)    "{'bufferView':" view ",'componentType':5126,'count':" count ",'type':'VEC2'}"
#define VEC4(view, count)    "{'bufferView':" view ",'componentType':5126,'count':" count ",'type':'VEC4'}"
#define VIEW(offset, length) "{'buffer':0,'byteOffset':" offset ",'byteLength':" length "}"

static const kd_primitive_desc *first(const kd_model *m)
{
    return &m->meshes[0].primitives[0];
}

static kd_vec3 corner(const kd_primitive_desc *p, uint32_t i)
{
    return p->positions[p->indices[i]];
}

/* Five points whose x names them. */
static const float five[15] = {0, 0, 0, 1, 0, 0, 2, 1, 0, 3, 2, 0, 4, 1, 0};

static void assert_corners(const kd_primitive_desc *p, const int *x, uint32_t count)
{
    assert_int_equal(p->index_count, count);
    for (uint32_t i = 0; i < count; i++)
        assert_int_equal((int)corner(p, i).x, x[i]);
}

static void strips_unroll_with_alternating_winding(void **state)
{
    (void)state;
    kd_model *m = load_good(
        FILE_OF("{'mode':5,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"), "60"), five, 60);
    /* glTF 2.0, 3.7.2.1: p_i = {v_i, v_(i+(1+i%2)), v_(i+(2-i%2))} */
    assert_corners(first(m), (int[]){0, 1, 2, 1, 3, 2, 2, 3, 4}, 9);
    kd_model_destroy(m);
}

static void fans_unroll_round_their_first_vertex(void **state)
{
    (void)state;
    kd_model *m = load_good(
        FILE_OF("{'mode':6,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"), "60"), five, 60);
    /* p_i = {v_(i+1), v_(i+2), v_0} */
    assert_corners(first(m), (int[]){1, 2, 0, 2, 3, 0, 3, 4, 0}, 9);
    kd_model_destroy(m);
}

static void indices_of_each_width_are_read(void **state)
{
    (void)state;
    struct {
        float at[15];
        uint8_t u8[4];
        uint16_t u16[4];
        uint32_t u32[3];
    } data = {.u8 = {4, 3, 0}, .u16 = {3, 1, 2}, .u32 = {1, 0, 4}};
    memcpy(data.at, five, sizeof five);
    kd_model *m = load_good(
        FILE_OF("{'attributes':{'POSITION':0},'indices':1},{'attributes':{'POSITION':0},'indices':2},"
                "{'attributes':{'POSITION':0},'indices':3}",
                VEC3("0", "5") ",{'bufferView':1,'componentType':5121,'count':3,'type':'SCALAR'},"
                               "{'bufferView':2,'componentType':5123,'count':3,'type':'SCALAR'},"
                               "{'bufferView':3,'componentType':5125,'count':3,'type':'SCALAR'}",
                VIEW("0", "60") "," VIEW("60", "4") "," VIEW("64", "8") "," VIEW("72", "12"), "84"),
        &data, sizeof data);
    assert_corners(&m->meshes[0].primitives[0], (int[]){4, 3, 0}, 3);
    assert_corners(&m->meshes[0].primitives[1], (int[]){3, 1, 2}, 3);
    assert_corners(&m->meshes[0].primitives[2], (int[]){1, 0, 4}, 3);
    kd_model_destroy(m);
}

static void missing_normals_are_flat_and_split_the_vertices(void **state)
{
    (void)state;
    /* Two triangles that share an edge in a right angle: 4 points become 6 vertices with a normal a face. */
    struct {
        float at[12];
        uint16_t index[6];
    } data = {{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 1, 2, 0, 2, 3}};
    kd_model *m =
        load_good(FILE_OF("{'attributes':{'POSITION':0},'indices':1}",
                          VEC3("0", "4") ",{'bufferView':1,'componentType':5123,'count':6,'type':'SCALAR'}",
                          VIEW("0", "48") "," VIEW("48", "12"), "60"),
                  &data, sizeof data);
    const kd_primitive_desc *p = first(m);
    assert_int_equal(p->vertex_count, 6);
    for (uint32_t i = 0; i < 3; i++) {
        assert_vec3(p->normals[i], 0, 0, 1, 1e-6f);     /* x cross y */
        assert_vec3(p->normals[i + 3], 1, 0, 0, 1e-6f); /* y cross z */
    }
    kd_model_destroy(m);
}

static void a_shared_buffer_is_not_copied_whole(void **state)
{
    (void)state;
    struct {
        float at[15], normals[15];
        uint16_t index[4];
    } data = {.index = {4, 2, 3}};
    memcpy(data.at, five, sizeof five);
    for (int i = 0; i < 5; i++)
        data.normals[i * 3 + 2] = 2; /* not of unit length */
    kd_model *m =
        load_good(FILE_OF("{'attributes':{'POSITION':0,'NORMAL':1},'indices':2}",
                          VEC3("0", "5") "," VEC3(
                              "1", "5") ",{'bufferView':2,'componentType':5123,'count':3,'type':'SCALAR'}",
                          VIEW("0", "60") "," VIEW("60", "60") "," VIEW("120", "6"), "128"),
                  &data, sizeof data);
    const kd_primitive_desc *p = first(m);
    assert_int_equal(p->vertex_count, 3);
    assert_corners(p, (int[]){4, 2, 3}, 3);
    assert_vec3(p->normals[0], 0, 0, 1, 1e-6f);
    assert_vec3(p->bounds_min, 2, 1, 0, 0);
    assert_vec3(p->bounds_max, 4, 2, 0, 0);
    kd_model_destroy(m);
}

static void normals_without_length_are_mended_with_a_warning(void **state)
{
    (void)state;
    float data[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0}; /* the normals are zero */
    kd_model *m =
        load_good(FILE_OF("{'attributes':{'POSITION':0,'NORMAL':1}}", VEC3("0", "3") "," VEC3("1", "3"),
                          VIEW("0", "36") "," VIEW("36", "36"), "72"),
                  data, sizeof data);
    for (int i = 0; i < 3; i++)
        assert_vec3(first(m)->normals[i], 0, 0, 1, 1e-6f);
    assert_int_equal(m->warning_count, 1);
    assert_non_null(strstr(m->warnings[0], "meshes[0].primitives[0].NORMAL"));
    kd_model_destroy(m);
}

static void tangents_follow_u_and_flip_with_mirrored_uv(void **state)
{
    (void)state;
    /* u to the right, v down the picture; then the same with u to the left. */
    struct {
        float at[9], normal[9], uv[6], mirrored[6];
    } data = {
        {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {0, 1, 1, 1, 0, 0}, {1, 1, 0, 1, 1, 0}};
    kd_model *m = load_good(
        FILE_OF("{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2}},"
                "{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':3}}",
                VEC3("0", "3") "," VEC3("1", "3") "," VEC2("2", "3") "," VEC2("3", "3"),
                VIEW("0", "36") "," VIEW("36", "36") "," VIEW("72", "24") "," VIEW("96", "24"), "120"),
        &data, sizeof data);
    const kd_vec4 *t = m->meshes[0].primitives[0].tangents, *mirrored = m->meshes[0].primitives[1].tangents;
    for (int i = 0; i < 3; i++) {
        /* cross(normal, tangent) * w must point up the picture, here +y: z cross x = y, so w = 1; z cross -x
         * = -y, w = -1 */
        assert_vec3((kd_vec3){t[i].x, t[i].y, t[i].z}, 1, 0, 0, 1e-6f);
        assert_float_equal(t[i].w, 1, 0);
        assert_vec3((kd_vec3){mirrored[i].x, mirrored[i].y, mirrored[i].z}, -1, 0, 0, 1e-6f);
        assert_float_equal(mirrored[i].w, -1, 0);
    }
    kd_model_destroy(m);
}

static void quantised_attributes_are_widened(void **state)
{
    (void)state;
    struct {
        int16_t at[12];
        int8_t normal[12];
        uint16_t uv[6];
        uint8_t color[12];
        uint8_t plain[12];
    } data = {{-32768, 0, 0, 0, 32767, 0, 0, 0, 0, 16384, 0, 0},
              {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0},
              {0, 65535, 65535, 0, 32768, 0},
              {255, 0, 51, 255, 0, 0, 0, 255, 0, 0, 0, 255},
              {7, 0, 0, 0, 9, 0, 0, 0, 0, 200, 0, 0}};
    const char *json = FILE_OF(
        "{'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2,'COLOR_0':3}},{'attributes':{'POSITION':4}}",
        "{'bufferView':0,'componentType':5122,'normalized':true,'count':3,'type':'VEC3'},"
        "{'bufferView':1,'componentType':5120,'normalized':true,'count':3,'type':'VEC3'},"
        "{'bufferView':2,'componentType':5123,'normalized':true,'count':3,'type':'VEC2'},"
        "{'bufferView':3,'componentType':5121,'normalized':true,'count':3,'type':'VEC4'},"
        "{'bufferView':4,'componentType':5121,'count':3,'type':'VEC3'}",
        "{'buffer':0,'byteLength':24,'byteStride':8},{'buffer':0,'byteOffset':24,'byteLength':12,'byteStride'"
        ":4}," VIEW("36", "12") "," VIEW("48",
                                         "12") ",{'buffer':0,'byteOffset':60,'byteLength':12,'byteStride':4}",
        "72");
    kd_model *m = load_good(json, &data, sizeof data);
    const kd_primitive_desc *p = first(m);
    /* max(c / 32767, -1), c / 127, c / 65535, c / 255 (glTF 2.0, 3.6.2.2); 16384 stands at x of the third */
    assert_vec3(p->positions[0], -1, 0, 0, 0);
    assert_vec3(p->positions[1], 1, 0, 0, 0);
    assert_vec3(p->positions[2], 0, 16384 / 32767.0f, 0, 1e-7f);
    assert_vec3(p->normals[1], 0, 0, 1, 1e-6f);
    NEAR(p->uv0[0].y, 1, 0);
    NEAR(p->uv0[2].x, 32768 / 65535.0f, 1e-7f);
    NEAR(p->colors[0].z, 0.2f, 1e-7f); /* 51 / 255 */
    NEAR(p->colors[0].w, 1, 0);
    assert_vec3(m->meshes[0].primitives[1].positions[0], 7, 0, 0,
                0); /* integers that are not normalised stay */
    kd_model_destroy(m);
}

static void colours_without_alpha_are_opaque(void **state)
{
    (void)state;
    struct {
        float at[9];
        uint16_t color[12];
    } data = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {65535, 0, 13107, 0}};
    kd_model *m = load_good(
        FILE_OF(
            "{'attributes':{'POSITION':0,'COLOR_0':1}}",
            VEC3("0", "3") ",{'bufferView':1,'componentType':5123,'normalized':true,'count':3,'type':'VEC3'}",
            VIEW("0", "36") ",{'buffer':0,'byteOffset':36,'byteLength':24,'byteStride':8}", "60"),
        &data, sizeof data);
    const kd_vec4 *c = first(m)->colors;
    NEAR(c[0].x, 1, 0);
    NEAR(c[0].z, 0.2f, 1e-7f); /* 13107 / 65535 */
    NEAR(c[0].w, 1, 0);
    kd_model_destroy(m);
}

static void sparse_values_replace_a_base_or_zeros(void **state)
{
    (void)state;
    struct {
        float at[9], values[6];
        uint8_t index[4];
    } data = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {5, 0, 0, 0, 6, 0}, {1, 2}};
    const char *sparse =
        "'sparse':{'count':2,'indices':{'bufferView':2,'componentType':5121},'values':{'bufferView':1}}}";
    char json[2048];
    snprintf(json, sizeof json,
             FILE_OF("{'attributes':{'POSITION':0},'targets':[{'POSITION':1}]}",
                     "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3',%s,{'componentType':5126,'"
                     "count':3,'type':'VEC3',%s",
                     VIEW("0", "36") "," VIEW("36", "24") "," VIEW("60", "4"), "64"),
             sparse, sparse);
    kd_model *m = load_good(json, &data, sizeof data);
    const kd_primitive_desc *p = first(m);
    assert_vec3(p->positions[0], 0, 0, 0, 0);
    assert_vec3(p->positions[1], 5, 0, 0, 0);
    assert_vec3(p->positions[2], 0, 6, 0, 0);
    assert_vec3(p->morph_positions[0][0], 0, 0, 0, 0);
    assert_vec3(p->morph_positions[0][1], 5, 0, 0, 0);
    assert_vec3(p->morph_positions[0][2], 0, 6, 0, 0);
    kd_model_destroy(m);
    data.index[1] = 1; /* does not rise */
    load_bad(json, &data, sizeof data, KD_BAD_FORMAT, "sparse indices");
    data.index[1] = 3; /* past the count */
    load_bad(json, &data, sizeof data, KD_BAD_FORMAT, "sparse indices");
}

static void flat_normals_follow_a_morph_target(void **state)
{
    (void)state;
    /* The target lifts the third corner from y to z: the normal turns from +z to -y, a change of (0, -1, -1).
     */
    float data[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, -1, 1};
    kd_model *m =
        load_good(FILE_OF("{'attributes':{'POSITION':0},'targets':[{'POSITION':1}]}",
                          VEC3("0", "3") "," VEC3("1", "3"), VIEW("0", "36") "," VIEW("36", "36"), "72"),
                  data, sizeof data);
    assert_vec3(first(m)->morph_normals[0][0], 0, -1, -1, 1e-6f);
    kd_model_destroy(m);
}

static void the_four_largest_of_eight_weights_stay(void **state)
{
    (void)state;
    struct {
        float at[9];
        uint8_t j0[12], j1[12];
        float w0[12], w1[12];
    } data = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
              {0, 1, 2, 3},
              {4, 5, 6, 7},
              {0.1f, 0.3f, 0, 0.05f},
              {0.2f, 0.05f, 0.4f, 0}};
    for (int i = 1; i < 3; i++) {
        data.w0[i * 4] = 2; /* sums other than 1 are brought there */
        data.w1[i * 4] = 2;
    }
    kd_model *m = load_good(
        "{'asset':{'version':'2.0'},'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0,'skin':0}],'skins':[{'joints'"
        ":[0,0,0,0,0,0,0,0]}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'JOINTS_0':1,'JOINTS_1':2,'WEIGHTS_0':3,'"
        "WEIGHTS_1':4}}]}],"
        "'accessors':[" VEC3(
            "0",
            "3") ",{'bufferView':1,'componentType':5121,'count':3,'type':'VEC4'},"
                 "{'bufferView':2,'componentType':5121,'count':3,'type':'VEC4'}," VEC4("3", "3") "," VEC4(
                     "4", "3") "],"
                               "'bufferViews':[" VIEW("0", "36") "," VIEW("36", "12") "," VIEW(
                                   "48", "12") "," VIEW("60", "48") "," VIEW("108",
                                                                             "48") "],"
                                                                                   "'buffers':[{'uri':'data."
                                                                                   "bin','byteLength':156}]}",
        &data, sizeof data);
    const kd_primitive_desc *p = first(m);
    /* 0.4, 0.3, 0.2, 0.1 of joints 6, 1, 4, 0; their sum is 1. */
    static const uint16_t joints[4] = {6, 1, 4, 0};
    assert_memory_equal(p->joints[0], joints, sizeof joints);
    NEAR(p->weights[0].x, 0.4f, 1e-6f);
    NEAR(p->weights[0].y, 0.3f, 1e-6f);
    NEAR(p->weights[0].z, 0.2f, 1e-6f);
    NEAR(p->weights[0].w, 0.1f, 1e-6f);
    NEAR(p->weights[1].x + p->weights[1].y, 1, 1e-6f);
    kd_model_destroy(m);
    data.w0[0] = -0.1f;
    load_bad(
        "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'JOINTS_0':1,'WEIGHTS_0':2}}]}],"
        "'accessors':[" VEC3("0", "3") ",{'bufferView':1,'componentType':5121,'count':3,'type':'VEC4'}," VEC4(
            "2", "3") "],"
                      "'bufferViews':[" VIEW("0", "36") "," VIEW("36", "12") "," VIEW(
                          "60", "48") "],"
                                      "'buffers':[{'uri':'data.bin','byteLength':156}]}",
        &data, sizeof data, KD_BAD_FORMAT, "negative");
}

static void points_and_lines_are_dropped_with_a_warning(void **state)
{
    (void)state;
    kd_model *m =
        load_good(FILE_OF("{'mode':1,'attributes':{'POSITION':0}},{'mode':5,'attributes':{'POSITION':0}}",
                          VEC3("0", "5"), VIEW("0", "60"), "60"),
                  five, 60);
    assert_int_equal(m->meshes[0].primitive_count, 1);
    assert_int_equal(m->warning_count, 1);
    kd_model_destroy(m);
    load_bad(FILE_OF("{'mode':0,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"), "60"), five,
             60, KD_BAD_FORMAT, "no triangles");
}

/* Who only lists what a file holds asks for it all the same. */
static void files_without_triangles_can_be_listed(void **state)
{
    static const char *const files[] = {
        FILE_OF("{'mode':0,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"), "60"),
        FILE_OF("{'mode':3,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"), "60"),
        "{'asset':{'version':'2.0'},'nodes':[{'name':'alone'}]}",
    };
    (void)state;
    for (int i = 0; i < 3; i++) {
        kd_model *m;
        load_bad(files[i], five, 60, KD_BAD_FORMAT, "no triangles");
        watch_messages();
        assert_int_equal(
            kd_model_load_with(in_folder("case.gltf"), &(kd_model_options){.without_triangles = true}, &m),
            KD_OK);
        assert_int_equal(seen_messages.errors, 0);
        assert_int_equal(m->triangle_count, 0);
        assert_int_equal(m->node_count, 1);
        assert_int_equal(m->warning_count, i < 2);
        kd_model_destroy(m);
    }
}

static void broken_accessors_are_refused_by_name(void **state)
{
    (void)state;
    float bad[15];
    memcpy(bad, five, sizeof bad);
    bad[7] = NAN;
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"), "60"), bad,
             60, KD_BAD_FORMAT, "not finite (meshes[0].primitives[0].POSITION, element 2)");
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':0}}", VEC3("0", "6"), VIEW("0", "60"), "60"), five,
             60, KD_BAD_FORMAT, "beyond the buffer view (meshes[0].primitives[0].POSITION, accessor 0)");
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("4", "60"), "60"), five,
             60, KD_BAD_FORMAT, "bufferViews[0]");
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':0}}", VEC3("0", "5"),
                     VIEW("18446744073709551608", "16"), "60"),
             five, 60, KD_BAD_FORMAT, "bufferViews[0]");
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':0}}", VEC3("0", "6148914691236517206"),
                     VIEW("0", "60"), "60"),
             five, 60, KD_TOO_LARGE, "accessor 0"); /* 12 times this wraps to 8 in 64 bits */
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':0,'NORMAL':1}}", VEC3("0", "5") "," VEC3("0", "4"),
                     VIEW("0", "60"), "60"),
             five, 60, KD_BAD_FORMAT, "4 elements, but POSITION has 5");
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':7}}", VEC3("0", "5"), VIEW("0", "60"), "60"), five,
             60, KD_BAD_FORMAT, "no accessor 7");
    load_bad(FILE_OF("{'mode':9,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"), "60"), five,
             60, KD_BAD_FORMAT, "primitive mode");
    load_bad(FILE_OF("{'mode':5,'attributes':{'POSITION':0}}", VEC3("0", "5"), VIEW("0", "60"),
                     "9223372036854775807"),
             five, 60, KD_BAD_FORMAT, "buffers[0]");
    load_bad(
        FILE_OF("{'mode':5,'attributes':{'POSITION':0},'material':3}", VEC3("0", "5"), VIEW("0", "60"), "60"),
        five, 60, KD_BAD_FORMAT, "no material 3");
}

static void an_index_out_of_range_is_refused_with_its_place(void **state)
{
    (void)state;
    struct {
        float at[15];
        uint16_t index[4];
    } data = {.index = {0, 1, 5}};
    memcpy(data.at, five, sizeof five);
    load_bad(FILE_OF("{'attributes':{'POSITION':0},'indices':1}",
                     VEC3("0", "5") ",{'bufferView':1,'componentType':5123,'count':3,'type':'SCALAR'}",
                     VIEW("0", "60") "," VIEW("60", "6"), "68"),
             &data, sizeof data, KD_BAD_FORMAT,
             "index 5 at place 2 reaches beyond 5 vertices (meshes[0].primitives[0].indices, accessor 1)");
}

static void data_uris_are_decoded(void **state)
{
    (void)state;
    /* Nine floats 0 0 0, 1 0 0, 0 1 0: 1.0f is 00 00 80 3F. As base64 by hand: bytes 12-15 and 28-31 are not
     * zero. */
    kd_model *m =
        load_good("{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'"
                  "POSITION':0}}]}],"
                  "'accessors':[" VEC3("0", "3") "],'bufferViews':[" VIEW(
                      "0", "36") "],'buffers':[{'byteLength':36,'uri':"
                                 "'data:application/"
                                 "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA'}]}",
                  NULL, 0);
    assert_vec3(first(m)->positions[1], 1, 0, 0, 0);
    assert_vec3(first(m)->positions[2], 0, 1, 0, 0);
    kd_model_destroy(m);
    load_bad("{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'"
             "POSITION':0}}]}],"
             "'accessors':[" VEC3("0", "3") "],'bufferViews':[" VIEW(
                 "0", "36") "],'buffers':[{'byteLength':36,'uri':"
                            "'data:;base64,AAAA!AAA'}]}",
             NULL, 0, KD_BAD_FORMAT, "base64");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strips_unroll_with_alternating_winding),
        cmocka_unit_test(fans_unroll_round_their_first_vertex),
        cmocka_unit_test(indices_of_each_width_are_read),
        cmocka_unit_test(missing_normals_are_flat_and_split_the_vertices),
        cmocka_unit_test(a_shared_buffer_is_not_copied_whole),
        cmocka_unit_test(normals_without_length_are_mended_with_a_warning),
        cmocka_unit_test(tangents_follow_u_and_flip_with_mirrored_uv),
        cmocka_unit_test(quantised_attributes_are_widened),
        cmocka_unit_test(colours_without_alpha_are_opaque),
        cmocka_unit_test(sparse_values_replace_a_base_or_zeros),
        cmocka_unit_test(flat_normals_follow_a_morph_target),
        cmocka_unit_test(the_four_largest_of_eight_weights_stay),
        cmocka_unit_test(points_and_lines_are_dropped_with_a_warning),
        cmocka_unit_test(files_without_triangles_can_be_listed),
        cmocka_unit_test(broken_accessors_are_refused_by_name),
        cmocka_unit_test(an_index_out_of_range_is_refused_with_its_place),
        cmocka_unit_test(data_uris_are_decoded),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
