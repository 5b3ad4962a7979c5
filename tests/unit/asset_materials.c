/* Materials and their pictures from small files written here. */

#include <spng.h>

#include "tests/unit/asset_support.h"

static const uint8_t pixels[8] = {255, 0, 0, 128, 0, 0, 255, 255};

/* Two pixels, red half transparent and blue: PNG from libspng, which reads it back. */
static void *make_png(size_t *size)
{
    struct spng_ihdr header = {
        .width = 2, .height = 1, .bit_depth = 8, .color_type = SPNG_COLOR_TYPE_TRUECOLOR_ALPHA};
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    int code;
    assert_int_equal(spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1), 0);
    assert_int_equal(spng_set_ihdr(png, &header), 0);
    assert_int_equal(spng_encode_image(png, pixels, sizeof pixels, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
    void *bytes = spng_get_png_buffer(png, size, &code);
    assert_non_null(bytes);
    spng_ctx_free(png);
    return bytes;
}

/* The triangle and the picture behind it, as the JSON has them. */
static uint8_t *make_data(size_t *png_size)
{
    static const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    void *png = make_png(png_size);
    uint8_t *data = malloc(36 + *png_size);
    assert_non_null(data);
    memcpy(data, triangle, 36);
    memcpy(data + 36, png, *png_size);
    free(png);
    return data;
}

static const char material_json[] =
    "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'POSITION':0},'"
    "material':0}]}],"
    "'extensionsUsed':['KHR_texture_transform','KHR_materials_emissive_strength','KHR_materials_unlit'],"
    "'materials':[{'name':'paint','alphaMode':'MASK','alphaCutoff':0.25,'doubleSided':true,'emissiveFactor':["
    "1,0.5,0],"
    "'extensions':{'KHR_materials_emissive_strength':{'emissiveStrength':4},'KHR_materials_unlit':{}},"
    "'occlusionTexture':{'index':0,'strength':0.5},"
    "'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,0.4],'metallicFactor':0.5,'roughnessFactor':2,"
    "'baseColorTexture':{'index':0,'extensions':{'KHR_texture_transform':{'offset':[0.5,0.25],'scale':[2,3],'"
    "rotation':1.5,'texCoord':1}}}}}],"
    "'textures':[{'source':1,'sampler':0}],'samplers':[{'magFilter':9728,'wrapS':33071,'wrapT':33648}],"
    "'images':[{'uri':'missing.png'},{'bufferView':1,'mimeType':'image/png'}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],'bufferViews':[{'buffer':0,'"
    "byteLength':36},"
    "{'buffer':0,'byteOffset':36,'byteLength':%zu}],'buffers':[{'uri':'data.bin','byteLength':%zu}]}";

static void materials_are_read_whole(void **state)
{
    (void)state;
    char json[4096];
    size_t size;
    uint8_t *data = make_data(&size);
    snprintf(json, sizeof json, material_json, size, 36 + size);
    kd_model *m = load_good(json, data, 36 + size);
    const kd_material_desc *p = &m->materials[0];
    assert_string_equal(p->name, "paint");
    NEAR(p->base_color.w, 0.4f, 0);
    NEAR(p->metallic, 0.5f, 0);
    NEAR(p->roughness, 1, 0); /* 2 is clamped, with a warning */
    assert_int_equal(m->warning_count, 1);
    assert_non_null(strstr(m->warnings[0], "materials[0].roughnessFactor"));
    assert_vec3(p->emissive, 4, 2, 0, 0);
    assert_int_equal(p->alpha_mode, KD_ALPHA_MASK);
    NEAR(p->alpha_cutoff, 0.25f, 0);
    NEAR(p->occlusion_strength, 0.5f, 0);
    assert_true(p->double_sided && p->unlit);
    const kd_texture_ref *map = &p->base_color_map;
    assert_int_equal(map->image,
                     0); /* the only picture in use; the missing one is not, and nobody asks for it */
    assert_int_equal(map->uv_set, 1);
    assert_true(map->nearest && map->wrap_s == KD_WRAP_CLAMP && map->wrap_t == KD_WRAP_MIRROR);
    NEAR(map->offset.x, 0.5f, 0);
    NEAR(map->scale.y, 3, 0);
    NEAR(map->rotation, 1.5f, 0);
    assert_int_equal(p->normal_map.image, KD_NONE);
    assert_int_equal(m->image_count, 1);
    assert_memory_equal(m->images[0].rgba, pixels, sizeof pixels);
    kd_model_destroy(m);
    free(data);
}

static void broken_pictures_are_refused(void **state)
{
    (void)state;
    char json[4096];
    size_t size;
    uint8_t *data = make_data(&size);
    for (size_t cut = 0; cut < size; cut++) {
        snprintf(json, sizeof json, material_json, cut, 36 + size);
        kd_model *none = NULL;
        kd_status status = load_case(json, data, 36 + size, &none);
        if (!status) /* only the closing chunk may be missing: libspng has all pixels by then */
            assert_memory_equal(none->images[0].rgba, pixels, sizeof pixels);
        assert_int_equal(seen_messages.errors, status != KD_OK);
        assert_true(status || cut + 16 >= size);
        kd_model_destroy(none);
    }
    memset(data + 36, 'x', size);
    snprintf(json, sizeof json, material_json, size, 36 + size);
    load_bad(json, data, 36 + size, KD_UNSUPPORTED, "neither PNG, JPEG nor WebP");
    free(data);
}

/* A triangle of one material; the texture is the two pixels above: means of red 0.5, of blue 0.5, of alpha
 * (128 + 255) / 510, and of the sRGB colours the same since 0 and 255 stand for 0 and 1. */
static kd_model *load_lobes(const char *material, uint8_t *data, size_t size)
{
    char json[2048];
    snprintf(json, sizeof json,
             "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{'"
             "POSITION':0},"
             "'material':0}]}],'materials':[%s],'textures':[{'source':0}],"
             "'images':[{'bufferView':1,'mimeType':'image/png'}],"
             "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],'bufferViews':["
             "{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'byteLength':%zu}],"
             "'buffers':[{'uri':'data.bin','byteLength':%zu}]}",
             material, size, 36 + size);
    return load_good(json, data, 36 + size);
}

static void further_ways_to_reflect_are_read(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_data(&size);
    kd_model *m =
        load_lobes("{'extensions':{'KHR_materials_ior':{'ior':2.5},"
                   "'KHR_materials_specular':{'specularFactor':0.5,'specularColorFactor':[1,0.5,3],'"
                   "specularTexture':{'index':0},"
                   "'specularColorTexture':{'index':0}},"
                   "'KHR_materials_clearcoat':{'clearcoatFactor':0.5,'clearcoatTexture':{'index':0},"
                   "'clearcoatRoughnessFactor':0.25,'clearcoatNormalTexture':{'index':0}},"
                   "'KHR_materials_transmission':{'transmissionFactor':0.75}}}",
                   data, size);
    const kd_material_desc *p = &m->materials[0];
    NEAR(p->ior, 2.5f, 0);
    NEAR(p->specular, 0.5f * 383 / 510, 1e-6f);
    assert_vec3(p->specular_color, 0.5f, 0, 1.5f, 1e-6f);
    NEAR(p->clearcoat, 0.25f, 1e-6f);
    NEAR(p->clearcoat_roughness, 0.25f, 0);
    NEAR(p->transmission, 0.75f, 0);
    assert_true(p->alpha_mode == KD_ALPHA_BLEND && p->alpha_ignored);
    assert_int_equal(m->warning_count, 4); /* three maps that stand for their mean, one that is not read */
    kd_model_destroy(m);
    free(data);
}

/* The archived extension as a dielectric below a tinted reflection; means as above. Where there are maps of
 * metallic-roughness as well, these are taken. */
static void specular_glossiness_is_read_as_a_dielectric(void **state)
{
    static const char old[] =
        "{%s'extensions':{'KHR_materials_pbrSpecularGlossiness':{'diffuseFactor':[0.2,0.4,0.6,1],"
        "'specularFactor':[0.08,0.5,0.02],'glossinessFactor':0.8,'specularGlossinessTexture':{'index':0},"
        "'diffuseTexture':{'index':0,'texCoord':1,'extensions':{'KHR_texture_transform':{'scale':[2,3]}}}}}}";
    char material[512];
    (void)state;
    size_t size;
    uint8_t *data = make_data(&size);
    snprintf(material, sizeof material, old, "");
    kd_model *m = load_lobes(material, data, size);
    const kd_material_desc *p = &m->materials[0];
    NEAR(p->base_color.y, 0.4f, 1e-6f);
    NEAR(p->metallic, 0, 0);
    NEAR(p->roughness, 1 - 0.8f * 383 / 510, 1e-6f);
    assert_vec3(p->specular_color, 1, 0, 0.25f, 1e-5f);
    assert_int_equal(p->base_color_map.uv_set, 1);
    NEAR(p->base_color_map.scale.y, 3, 0);
    assert_int_equal(m->warning_count, 2); /* one map, of which two means are taken */
    kd_model_destroy(m);
    snprintf(material, sizeof material, old,
             "'pbrMetallicRoughness':{'baseColorTexture':{'index':0},'metallicFactor':0.5},");
    m = load_lobes(material, data, size);
    NEAR(m->materials[0].metallic, 0.5f, 0);
    NEAR(m->materials[0].base_color.y, 1, 0);
    kd_model_destroy(m);
    free(data);
}

static void specular_glossiness_of_a_wrong_type_is_refused(void **state)
{
    static const char *const wrong[] = {"'diffuseFactor':[1,1,1]", "'specularFactor':'red'",
                                        "'specularFactor':[1,{},1]", "'diffuseTexture':{'index':7}",
                                        "'specularGlossinessTexture':{'index':7}"};
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char json[1024];
        float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        snprintf(
            json, sizeof json,
            "{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'meshes':[{'primitives':[{'attributes':{"
            "'POSITION':0},'material':0}]}],'materials':[{'extensions':{"
            "'KHR_materials_pbrSpecularGlossiness':{%s}}}],"
            "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"
            "'bufferViews':[{'buffer':0,'byteLength':36}],'buffers':[{'uri':'data.bin','byteLength':36}]}",
            wrong[i]);
        load_bad(json, triangle, 36, KD_BAD_FORMAT, i < 3 ? "pbrSpecularGlossiness" : "materials[0]");
    }
}

static void odd_ways_to_reflect_are_mended_or_refused(void **state)
{
    (void)state;
    size_t size;
    uint8_t *data = make_data(&size);
    kd_model *m = load_lobes("{'extensions':{'KHR_materials_ior':{'ior':0.5},"
                             "'KHR_materials_clearcoat':{'clearcoatFactor':-1},"
                             "'KHR_materials_transmission':{'transmissionFactor':1e30}},'alphaMode':'MASK'}",
                             data, size);
    NEAR(m->materials[0].ior, 1, 0);
    NEAR(m->materials[0].clearcoat, 0, 0);
    NEAR(m->materials[0].transmission, 0,
         0); /* clamped, and then left out: a mask does not let light through */
    assert_int_equal(m->warning_count, 4);
    kd_model_destroy(m);
    m = load_lobes("{'extensions':{'KHR_materials_ior':{'ior':0},'KHR_materials_unlit':{},"
                   "'KHR_materials_transmission':{'transmissionFactor':1}}}",
                   data, size);
    assert_true(m->materials[0].unlit && m->materials[0].transmission == 0);
    kd_model_destroy(m);
    free(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_are_read_whole),
        cmocka_unit_test(broken_pictures_are_refused),
        cmocka_unit_test(further_ways_to_reflect_are_read),
        cmocka_unit_test(specular_glossiness_is_read_as_a_dielectric),
        cmocka_unit_test(specular_glossiness_of_a_wrong_type_is_refused),
        cmocka_unit_test(odd_ways_to_reflect_are_mended_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
