/* Meshes and pictures packed by the libraries' own encoders: Draco, meshoptimizer, WebP. What comes out is
 * what went in, up to the bits that were kept; broken bytes end in one message. */

#include <math.h>

#include <meshoptimizer.h>
#include <webp/encode.h>

#include "tests/draco_encode.h"
#include "tests/unit/asset_support.h"

static kd_model *make_sphere(void)
{
    kd_model *m;
    assert_int_equal(kd_model_make_shape(KD_SHAPE_SPHERE, (kd_vec3){2, 2, 2}, 16, NULL, &m), KD_OK);
    return m;
}

/* The sum over triangles of area, and of volume below them: wrong corners or windings change it. */
static void measure(const kd_primitive_desc *p, double *area, double *volume)
{
    *area = *volume = 0;
    for (uint32_t i = 0; i < p->index_count; i += 3) {
        kd_vec3 a = p->positions[p->indices[i]], b = p->positions[p->indices[i + 1]],
                c = p->positions[p->indices[i + 2]];
        kd_vec3 normal = kd_vec3_cross(kd_vec3_sub(b, a), kd_vec3_sub(c, a));
        *area += (double)kd_vec3_length(normal) / 2;
        *volume += (double)kd_vec3_dot(a, normal) / 6;
    }
}

static void assert_same_surface(const kd_primitive_desc *p, const kd_primitive_desc *expected)
{
    double area, volume, expected_area, expected_volume;
    measure(p, &area, &volume);
    measure(expected, &expected_area, &expected_volume);
    assert_true(fabs(area / expected_area - 1) < 2e-3);
    assert_true(fabs(volume / expected_volume - 1) < 2e-3);
}

/* ---- Draco ---- */

#define DRACO_FILE                                                                                           \
    "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_draco_mesh_compression'],"                            \
    "'extensionsRequired':['KHR_draco_mesh_compression'],'nodes':[{'mesh':0}],'meshes':[{'primitives':[{"    \
    "'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2},'indices':3,'extensions':{"                       \
    "'KHR_draco_mesh_compression':{'bufferView':0,'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':%d}}}"  \
    "}]}],'accessors':[{'componentType':5126,'count':%u,'type':'VEC3'},"                                     \
    "{'componentType':5126,'count':%u,'type':'VEC3'},{'componentType':5126,'count':%u,'type':'VEC2'},"       \
    "{'componentType':5123,'count':%u,'type':'SCALAR'}],'bufferViews':[{'buffer':0,'byteLength':%zu}],"      \
    "'buffers':[{'uri':'data.bin','byteLength':%zu}]}"

typedef struct draco_case {
    char json[2048];
    uint8_t *bytes;
    size_t size;
    kd_model *sphere;
    uint32_t points, indices;
} draco_case;

/* How many points the packed mesh has: those of the sphere that differ, which the encoder joins. */
static uint32_t count_points(const kd_primitive_desc *p)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        bool known = false, used = false;
        for (uint32_t k = 0; k < p->index_count; k++)
            used = used || p->indices[k] == i;
        for (uint32_t k = 0; k < i; k++)
            known = known || (memcmp(&p->positions[i], &p->positions[k], sizeof(kd_vec3)) == 0 &&
                              memcmp(&p->normals[i], &p->normals[k], sizeof(kd_vec3)) == 0 &&
                              memcmp(&p->uv0[i], &p->uv0[k], sizeof(kd_vec2)) == 0);
        count += used && !known;
    }
    return count;
}

static void write_draco(draco_case *c, int uv_id, uint32_t points)
{
    snprintf(c->json, sizeof c->json, DRACO_FILE, uv_id, points, points, points, c->indices, c->size,
             c->size);
}

static draco_case open_draco(void)
{
    draco_case c = {.sphere = make_sphere()};
    const kd_primitive_desc *p = &c.sphere->meshes[0].primitives[0];
    c.bytes = draco_encode(p, &c.size);
    assert_non_null(c.bytes);
    c.points = count_points(p);
    c.indices = p->index_count;
    write_draco(&c, 2, c.points);
    return c;
}

static void close_draco(draco_case *c)
{
    free(c->bytes);
    kd_model_destroy(c->sphere);
}

static void draco_gives_the_surface_back(void **state)
{
    (void)state;
    draco_case c = open_draco();
    kd_model *m = load_good(c.json, c.bytes, c.size);
    const kd_primitive_desc *p = &m->meshes[0].primitives[0];
    assert_int_equal(m->warning_count, 0);
    assert_int_equal(p->index_count, c.indices);
    assert_same_surface(p, &c.sphere->meshes[0].primitives[0]);
    for (uint32_t i = 0; i < p->vertex_count; i++) { /* of a ball the normal is the direction of the place */
        NEAR(kd_vec3_length(p->positions[i]), 1, 1e-3);
        assert_true(kd_vec3_dot(p->positions[i], p->normals[i]) > 0.99f);
        assert_true(p->uv0[i].x > -1e-3f && p->uv0[i].x < 1.001f);
    }
    kd_model_destroy(m);
    close_draco(&c);
}

static void broken_draco_is_refused(void **state)
{
    (void)state;
    draco_case c = open_draco();
    const char *extension = "KHR_draco_mesh_compression";
    write_draco(&c, 9, c.points);
    load_bad(c.json, c.bytes, c.size, KD_BAD_FORMAT, extension);
    write_draco(&c, 2, c.points + 1);
    load_bad(c.json, c.bytes, c.size, KD_BAD_FORMAT, extension);
    size_t whole = c.size;
    for (c.size = 1; c.size < whole; c.size += c.size < 64 ? 1 : 97) {
        write_draco(&c, 2, c.points);
        load_bad(c.json, c.bytes, c.size, KD_BAD_FORMAT, "Draco");
    }
    c.size = whole;
    write_draco(&c, 2, c.points);
    for (size_t at = 0; at < whole; at += at < 64 ? 3 : 151) { /* flipped bytes: anything but a crash */
        kd_model *m = NULL;
        c.bytes[at] ^= 0x5a;
        if (load_case(c.json, c.bytes, whole, &m) == KD_OK)
            kd_model_destroy(m);
        else
            assert_int_equal(seen_messages.errors, 1);
        c.bytes[at] ^= 0x5a;
    }
    close_draco(&c);
}

/* ---- meshoptimizer ---- */

#define MESHOPT_FILE                                                                                         \
    "{'asset':{'version':'2.0'},'extensionsUsed':['EXT_meshopt_compression','KHR_mesh_quantization'],"       \
    "'extensionsRequired':['EXT_meshopt_compression','KHR_mesh_quantization'],'nodes':[{'mesh':0}],"         \
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1},'indices':2}]}],"                      \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':%u,'type':'VEC3'},"                           \
    "{'bufferView':1,'componentType':5120,'normalized':true,'count':%u,'type':'VEC3'},"                      \
    "{'bufferView':2,'componentType':5125,'count':%u,'type':'SCALAR'}],'bufferViews':["                      \
    "{'buffer':1,'byteLength':%u,'byteStride':12,'extensions':{'EXT_meshopt_compression':{'buffer':0,"       \
    "'byteOffset':0,'byteLength':%zu,'byteStride':12,'count':%u,'mode':'ATTRIBUTES','filter':'%s'}}},"       \
    "{'buffer':1,'byteLength':%u,'byteStride':4,'extensions':{'EXT_meshopt_compression':{'buffer':0,"        \
    "'byteOffset':%zu,'byteLength':%zu,'byteStride':4,'count':%u,'mode':'ATTRIBUTES',"                       \
    "'filter':'OCTAHEDRAL'}}},"                                                                              \
    "{'buffer':1,'byteLength':%u,'extensions':{'EXT_meshopt_compression':{'buffer':0,'byteOffset':%zu,"      \
    "'byteLength':%zu,'byteStride':4,'count':%u,'mode':'%s'}}}],"                                            \
    "'buffers':[{'uri':'data.bin','byteLength':%zu},{'byteLength':1000000,'extensions':{"                    \
    "'EXT_meshopt_compression':{'fallback':true}}}]}"

typedef struct meshopt_case {
    char json[3072];
    uint8_t bytes[1 << 16];
    size_t position_size, normal_size, index_size, size;
    uint32_t vertices, indices;
    kd_model *sphere;
} meshopt_case;

static void write_meshopt(meshopt_case *c, const char *filter, const char *mode)
{
    snprintf(c->json, sizeof c->json, MESHOPT_FILE, c->vertices, c->vertices, c->indices, c->vertices * 12,
             c->position_size, c->vertices, filter, c->vertices * 4, c->position_size, c->normal_size,
             c->vertices, c->indices * 4, c->position_size + c->normal_size, c->index_size, c->indices, mode,
             c->size);
}

static meshopt_case *open_meshopt(void)
{
    meshopt_case *c = calloc(1, sizeof *c);
    c->sphere = make_sphere();
    const kd_primitive_desc *p = &c->sphere->meshes[0].primitives[0];
    c->vertices = p->vertex_count;
    c->indices = p->index_count;
    float *exact = malloc(c->vertices * 12), *normals = calloc(c->vertices, 16);
    int8_t *octahedral = malloc(c->vertices * 4);
    meshopt_encodeFilterExp(exact, c->vertices, 12, 20, (const float *)p->positions);
    for (uint32_t i = 0; i < c->vertices; i++)
        memcpy(normals + 4 * i, &p->normals[i], 12);
    meshopt_encodeFilterOct(octahedral, c->vertices, 4, 8, normals);
    size_t room = sizeof c->bytes;
    c->position_size = meshopt_encodeVertexBuffer(c->bytes, room, exact, c->vertices, 12);
    c->normal_size = meshopt_encodeVertexBuffer(c->bytes + c->position_size, room - c->position_size,
                                                octahedral, c->vertices, 4);
    c->size = c->position_size + c->normal_size;
    c->index_size = meshopt_encodeIndexBuffer(c->bytes + c->size, room - c->size, p->indices, c->indices);
    c->size += c->index_size;
    assert_true(c->position_size && c->normal_size && c->index_size);
    free(exact);
    free(normals);
    free(octahedral);
    write_meshopt(c, "EXPONENTIAL", "TRIANGLES");
    return c;
}

static void close_meshopt(meshopt_case *c)
{
    kd_model_destroy(c->sphere);
    free(c);
}

static void meshopt_gives_the_surface_back(void **state)
{
    (void)state;
    meshopt_case *c = open_meshopt();
    kd_model *m = load_good(c->json, c->bytes, c->size);
    const kd_primitive_desc *p = &m->meshes[0].primitives[0];
    assert_int_equal(m->warning_count, 0);
    assert_int_equal(p->index_count, c->indices);
    assert_same_surface(p, &c->sphere->meshes[0].primitives[0]);
    for (uint32_t i = 0; i < p->vertex_count; i++)
        assert_true(kd_vec3_dot(p->positions[i], p->normals[i]) > 0.98f);
    kd_model_destroy(m);
    close_meshopt(c);
}

static void broken_meshopt_is_refused(void **state)
{
    (void)state;
    meshopt_case *c = open_meshopt();
    const char *extension = "EXT_meshopt_compression";
    write_meshopt(c, "WAVES", "TRIANGLES");
    load_bad(c->json, c->bytes, c->size, KD_BAD_FORMAT, "filter");
    write_meshopt(c, "QUATERNION", "TRIANGLES");
    load_bad(c->json, c->bytes, c->size, KD_BAD_FORMAT, "filter");
    write_meshopt(c, "EXPONENTIAL", "RIDDLES");
    load_bad(c->json, c->bytes, c->size, KD_BAD_FORMAT, "mode");
    write_meshopt(c, "EXPONENTIAL", "INDICES"); /* another packing */
    load_bad(c->json, c->bytes, c->size, KD_BAD_FORMAT, extension);
    size_t whole = c->index_size;
    for (c->index_size = 0; c->index_size < whole; c->index_size += 5) {
        c->size = c->position_size + c->normal_size + c->index_size;
        write_meshopt(c, "EXPONENTIAL", "TRIANGLES");
        load_bad(c->json, c->bytes, c->size, KD_BAD_FORMAT, extension);
    }
    c->index_size = whole;
    c->size = c->position_size + c->normal_size + c->index_size;
    write_meshopt(c, "EXPONENTIAL", "TRIANGLES");
    for (size_t at = 0; at < c->size; at += 13) {
        kd_model *m = NULL;
        c->bytes[at] ^= 0x81;
        if (load_case(c->json, c->bytes, c->size, &m) == KD_OK)
            kd_model_destroy(m);
        else
            assert_int_equal(seen_messages.errors, 1);
        c->bytes[at] ^= 0x81;
    }
    close_meshopt(c);
}

/* ---- WebP ---- */

#define WEBP_FILE                                                                                            \
    "{'asset':{'version':'2.0'},'extensionsUsed':['EXT_texture_webp'],'nodes':[{'mesh':0}],"                 \
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1},'material':0}]}],"                 \
    "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}],"                               \
    "'textures':[{'extensions':{'EXT_texture_webp':{'source':0}}}],"                                         \
    "'images':[{'bufferView':2,'mimeType':'image/webp'}],"                                                   \
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'},"                            \
    "{'bufferView':1,'componentType':5126,'count':3,'type':'VEC2'}],'bufferViews':["                         \
    "{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':24},"                             \
    "{'buffer':0,'byteOffset':60,'byteLength':%zu}],'buffers':[{'uri':'data.bin','byteLength':%zu}]}"

static void webp_textures_are_read(void **state)
{
    enum { SIDE = 8 };
    static const float triangle[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
    uint8_t rgba[SIDE * SIDE][4], *packed = NULL, *file;
    char json[2048];
    (void)state;
    for (int i = 0; i < SIDE * SIDE; i++)
        memcpy(rgba[i], (uint8_t[4]){(uint8_t)(i * 3), (uint8_t)(255 - i), (uint8_t)(i % 7 * 30), 200}, 4);
    size_t size = WebPEncodeLosslessRGBA(rgba[0], SIDE, SIDE, SIDE * 4, &packed);
    assert_true(size > 0);
    file = malloc(60 + size);
    memcpy(file, triangle, 60);
    memcpy(file + 60, packed, size);
    snprintf(json, sizeof json, WEBP_FILE, size, 60 + size);
    kd_model *m = load_good(json, file, 60 + size);
    assert_int_equal(m->warning_count, 0);
    assert_int_equal(m->image_count, 1);
    assert_int_equal(m->images[0].width, SIDE);
    assert_memory_equal(m->images[0].rgba, rgba, sizeof rgba);
    assert_int_equal(m->materials[0].base_color_map.image, 0);
    kd_model_destroy(m);
    for (size_t cut = 16; cut < size; cut += 3) {
        snprintf(json, sizeof json, WEBP_FILE, cut, 60 + cut);
        load_bad(json, file, 60 + cut, KD_BAD_FORMAT, "WebP");
    }
    free(file);
    WebPFree(packed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draco_gives_the_surface_back),   cmocka_unit_test(broken_draco_is_refused),
        cmocka_unit_test(meshopt_gives_the_surface_back), cmocka_unit_test(broken_meshopt_is_refused),
        cmocka_unit_test(webp_textures_are_read),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
