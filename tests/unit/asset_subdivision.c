/* Cages in `extras`: the limit surface they become, by values that the rules give on paper, and what is
 * refused. */

#include <math.h>

#include "tests/unit/asset_support.h"

#define FILE_OF(attributes, extras, accessors, views, bytes)                                                 \
    "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}],"                    \
    "'meshes':[{'primitives':[{'attributes':{" attributes "},'extras':{" extras "}}]}],"                     \
    "'accessors':[" accessors "],'bufferViews':[" views "],"                                                 \
    "'buffers':[{'uri':'data.bin','byteLength':" bytes "}]}"
#define VEC3(view, count)    "{'bufferView':" view ",'componentType':5126,'count':" count ",'type':'VEC3'}"
#define VIEW(offset, length) "{'buffer':0,'byteOffset':" offset ",'byteLength':" length "}"

#define CUBE_FACES                                                                                           \
    "'faceVertexCounts':[4,4,4,4,4,4],"                                                                      \
    "'faceVertexIndices':[0,3,2,1, 4,5,6,7, 0,1,5,4, 1,2,6,5, 2,3,7,6, 3,0,4,7]"
#define CUBE(extras) FILE_OF("'POSITION':0", extras, VEC3("0", "8"), VIEW("0", "96"), "96")

static const float cube[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                               -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};

static const kd_primitive_desc *first(const kd_model *m)
{
    return &m->meshes[0].primitives[0];
}

static kd_model *load_cube(const char *json)
{
    kd_model *m = load_good(json, cube, sizeof cube);
    assert_non_null(first(m)->subdivision);
    return m;
}

/* Vertices within 1e-4 of a place; *normal is the last one's. */
static int vertices_at(const kd_primitive_desc *p, kd_vec3 place, kd_vec3 *normal)
{
    int found = 0;
    for (uint32_t v = 0; v < p->vertex_count; v++)
        if (kd_vec3_length(kd_vec3_sub(p->positions[v], place)) < 1e-4f) {
            *normal = p->normals[v];
            found++;
        }
    return found;
}

/* Closed and welded: each edge has two triangles that run along it in opposite ways. */
static void assert_closed(const kd_primitive_desc *p)
{
    for (uint32_t i = 0; i < p->index_count; i++) {
        uint32_t a = p->indices[i], b = p->indices[i % 3 == 2 ? i - 2 : i + 1];
        int mates = 0;
        for (uint32_t k = 0; k < p->index_count; k++)
            mates += p->indices[k] == b && p->indices[k % 3 == 2 ? k - 2 : k + 1] == a;
        assert_int_equal(mates, 1);
    }
}

static void a_cube_becomes_the_round_surface_that_the_rules_give(void **state)
{
    (void)state;
    kd_model *m = load_cube(CUBE(CUBE_FACES));
    const kd_primitive_desc *p = first(m);
    kd_vec3 n;
    /* level 3: 6 faces of 8 x 8 squares, V = F + 2 */
    assert_int_equal(p->index_count, 6 * 64 * 2 * 3);
    assert_int_equal(p->vertex_count, 6 * 64 + 2);
    assert_closed(p);
    /* Catmull-Clark's limit at a vertex of valence 3 is (9 v + 4 sum of edge neighbours + sum of the faces'
     * other corners) / 24: for (1,1,1) that is (9 + 4 - 1) / 24 = 1/2 on each axis. */
    assert_int_equal(vertices_at(p, (kd_vec3){0.5f, 0.5f, 0.5f}, &n), 1);
    assert_vec3(n, sqrtf(1 / 3.0f), sqrtf(1 / 3.0f), sqrtf(1 / 3.0f), 1e-4f);
    /* One step gives the face point (0,0,1), edge points (3/4, 0, 3/4) and corners 5/9; the face point has
     * valence 4 and the limit (16 f + 4 sum of edges + sum of corners) / 36: z = (16 + 12 + 20/9) / 36. */
    assert_int_equal(vertices_at(p, (kd_vec3){0, 0, (28 + 20.0f / 9) / 36}, &n), 1);
    assert_vec3(n, 0, 0, 1, 1e-4f);
    for (uint32_t v = 0; v < p->vertex_count; v++) /* normals point out, and are unit */
        assert_true(kd_vec3_dot(p->normals[v], p->positions[v]) > 0.7f * kd_vec3_length(p->positions[v]));
    kd_model_destroy(m);
}

static void infinitely_sharp_edges_stay_and_part_the_normals(void **state)
{
    (void)state;
    /* All twelve edges: the cube itself comes back, each face flat. */
    kd_model *m =
        load_cube(CUBE(CUBE_FACES ",'creaseIndices':[0,1,2,3,0, 4,5,6,7,4, 0,4, 1,5, 2,6, 3,7],"
                                  "'creaseLengths':[5,5,2,2,2,2],'creaseSharpnesses':[10,10,10,10,10,10]"));
    const kd_primitive_desc *p = first(m);
    kd_vec3 n;
    assert_int_equal(p->vertex_count, 6 * 81); /* nothing is shared between faces */
    assert_int_equal(vertices_at(p, (kd_vec3){1, 1, 1}, &n), 3);
    assert_int_equal(vertices_at(p, (kd_vec3){1, 1, 0}, &n), 2);
    for (uint32_t i = 0; i < p->index_count; i += 3) {
        kd_vec3 q = p->positions[p->indices[i]], axis = p->normals[p->indices[i]];
        NEAR(fabsf(axis.x) + fabsf(axis.y) + fabsf(axis.z), 1, 1e-4f);
        NEAR(kd_vec3_dot(q, axis), 1, 1e-4f);
    }
    kd_model_destroy(m);
}

#define BAD_CUBE(extras, status, part) load_bad(CUBE(extras), cube, sizeof cube, status, part)

static void what_is_wrong_is_named_once(void **state)
{
    (void)state;
    BAD_CUBE("'faceVertexCounts':[]", KD_BAD_FORMAT, "the cage has no faces");
    BAD_CUBE("'faceVertexCounts':[4],'faceVertexIndices':[0,1,2]", KD_BAD_FORMAT,
             "fewer than the faces count");
    BAD_CUBE("'faceVertexCounts':[3],'faceVertexIndices':[0,1,2,3]", KD_BAD_FORMAT,
             "more than the faces count, 3");
    BAD_CUBE("'faceVertexCounts':[2],'faceVertexIndices':[0,1]", KD_BAD_FORMAT, "face 0 has 2 vertices");
    BAD_CUBE("'faceVertexCounts':[4],'faceVertexIndices':[0,1,2,8]", KD_BAD_FORMAT, "names vertex 8 of 8");
    BAD_CUBE("'faceVertexCounts':[4],'faceVertexIndices':[0,1,2,-1]", KD_BAD_FORMAT,
             "no index or count at place 3");
    BAD_CUBE("'faceVertexCounts':[4],'faceVertexIndices':[0,1,2,1]", KD_BAD_FORMAT, "uses vertex 1 twice");
    BAD_CUBE("'faceVertexCounts':[3,3,3],'faceVertexIndices':[0,1,2, 1,0,3, 0,1,4]", KD_BAD_FORMAT,
             "more than two faces share the edge of vertices 0 and 1");
    BAD_CUBE("'faceVertexCounts':[3,3],'faceVertexIndices':[0,1,2, 0,1,3]", KD_BAD_FORMAT, "turn one over");
    BAD_CUBE("'faceVertexCounts':4", KD_BAD_FORMAT, "'faceVertexCounts' is not a list");
    BAD_CUBE(CUBE_FACES ",'subdivisionScheme':'loop'", KD_BAD_FORMAT, "takes triangles only");
    BAD_CUBE(CUBE_FACES ",'subdivisionScheme':'bilinear'", KD_BAD_FORMAT,
             "'bilinear' is no subdivisionScheme");
    BAD_CUBE(CUBE_FACES ",'interpolateBoundary':'some'", KD_BAD_FORMAT, "'some' is no interpolateBoundary");
    BAD_CUBE(CUBE_FACES ",'creaseIndices':[0,1],'creaseLengths':[2]", KD_BAD_FORMAT,
             "0 values are neither one");
    BAD_CUBE(CUBE_FACES ",'creaseIndices':[0,6],'creaseLengths':[2],'creaseSharpnesses':[1]", KD_BAD_FORMAT,
             "from vertex 0 to 6, where the cage has no edge");
    BAD_CUBE(CUBE_FACES ",'creaseIndices':[0,1],'creaseLengths':[3],'creaseSharpnesses':[1]", KD_BAD_FORMAT,
             "crease 0 has 3 vertices of 2");
    BAD_CUBE(CUBE_FACES ",'creaseIndices':[0,1],'creaseLengths':[2],'creaseSharpnesses':[-1]", KD_BAD_FORMAT,
             "the sharpness -1");
    BAD_CUBE(CUBE_FACES ",'creaseIndices':[0,1],'creaseLengths':[2],'creaseSharpnesses':[NaN]", KD_BAD_FORMAT,
             "not valid JSON");
    BAD_CUBE(CUBE_FACES ",'cornerIndices':[9],'cornerSharpnesses':[1]", KD_BAD_FORMAT,
             "a corner names vertex 9");
    BAD_CUBE(CUBE_FACES ",'cornerIndices':[1],'cornerSharpnesses':[]", KD_BAD_FORMAT,
             "0 values for 1 corners");
    BAD_CUBE(CUBE_FACES ",'st':[0,0],'stIndices':[0]", KD_BAD_FORMAT, "do not give each corner");
    BAD_CUBE(CUBE_FACES ",'level':7", KD_TOO_LARGE, "level 7 is more than 6");
    BAD_CUBE(CUBE_FACES ",'level':0", KD_BAD_FORMAT, "'level' is no positive integer");
}

static void other_extras_are_passed_over(void **state)
{
    (void)state;
    kd_model *m = load_good(
        FILE_OF("'POSITION':0", "'note':{'faceVertexCounts':[1]}", VEC3("0", "6"), VIEW("0", "72"), "72"),
        cube, 72);
    assert_null(first(m)->subdivision);
    kd_model_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_becomes_the_round_surface_that_the_rules_give),
        cmocka_unit_test(infinitely_sharp_edges_stay_and_part_the_normals),
        cmocka_unit_test(what_is_wrong_is_named_once),
        cmocka_unit_test(other_extras_are_passed_over),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
