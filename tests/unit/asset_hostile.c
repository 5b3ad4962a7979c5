/* Whatever a file holds, a load ends soon in a model or in exactly one message. Meant to run under sanitizers
 * too. */

#include <sys/resource.h>

#include "tests/unit/asset_support.h"

#define ASSETS KD_SOURCE_DIR "/../shared/assets/"

/* A load that hangs ends the test: no single file here takes a second of processor time. */
static void limit_seconds(unsigned seconds)
{
    alarm(seconds);
}

/* Load, and hold the outcome to the promise. Returns whether a model came. */
static bool load_any(const char *path)
{
    kd_model *model = NULL;
    watch_messages();
    kd_status status = kd_model_load(path, &model);
    if ((status == KD_OK) != (model != NULL) || seen_messages.errors != (status != KD_OK))
        fail_msg("%s: status %d, %d errors, last: %s", path, status, seen_messages.errors,
                 seen_messages.last_error);
    kd_model_destroy(model);
    return status == KD_OK;
}

static void every_hostile_file_loads_or_gives_one_message(void **state)
{
    (void)state;
    FILE *list = fopen(ASSETS "hostile/expected.tsv", "r");
    if (!list) {
        print_message("skipped: there is no folder of hostile files at %s\n", ASSETS);
        skip();
    }
    char line[1024], path[1400];
    int files = 0;
    assert_non_null(fgets(line, sizeof line, list)); /* the head of the table */
    while (fgets(line, sizeof line, list)) {
        line[strcspn(line, "\t")] = 0;
        snprintf(path, sizeof path, "%shostile/%s", ASSETS, line);
        limit_seconds(10);
        load_any(path);
        files++;
    }
    fclose(list);
    assert_true(files >= 252);
}

/* ---- a small GLB of our own, cut and bent ---- */

static const char glb_json[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,"
    "\"skin\":0,"
    "\"children\":[1]},{\"rotation\":[0,0,0,1]}],\"skins\":[{\"joints\":[0,1]}],\"meshes\":[{\"primitives\":["
    "{"
    "\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,\"WEIGHTS_0\":2},\"targets\":[{\"POSITION\":4}]}]}],"
    "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"translation\"}}],"
    "\"samplers\":[{"
    "\"input\":3,\"output\":0}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
    "\"type\":\"VEC3\"},"
    "{\"bufferView\":1,\"componentType\":5121,\"count\":3,\"type\":\"VEC4\"},{\"bufferView\":2,"
    "\"componentType\":5126,"
    "\"count\":3,\"type\":\"VEC4\"},{\"bufferView\":3,\"componentType\":5126,\"count\":3,\"type\":\"SCALAR\"}"
    ",{"
    "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{"
    "\"bufferView\":4,"
    "\"componentType\":5121},\"values\":{\"bufferView\":0}}}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":"
    "36},{"
    "\"buffer\":0,\"byteOffset\":36,\"byteLength\":12},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":48},{"
    "\"buffer\":0,"
    "\"byteOffset\":96,\"byteLength\":12},{\"buffer\":0,\"byteOffset\":108,\"byteLength\":4}],\"buffers\":[{"
    "\"byteLength\":112}]}";

typedef struct glb_body {
    float positions[9];
    uint8_t joints[12];
    float weights[12], times[3];
    uint8_t sparse_index[4];
} glb_body;

static const glb_body body = {
    {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0.5f, 1}, {2}};

static void put_u32(uint8_t *p, size_t value)
{
    for (int i = 0; i < 4; i++)
        p[i] = (uint8_t)(value >> (8 * i));
}

/* Returns the size of the file written to out. */
static size_t make_glb(uint8_t *out)
{
    size_t json = (sizeof glb_json - 1 + 3) / 4 * 4, size = 12 + 8 + json + 8 + sizeof body;
    memset(out, ' ', size);
    memcpy(out, "glTF", 4);
    put_u32(out + 4, 2);
    put_u32(out + 8, size);
    put_u32(out + 12, json);
    memcpy(out + 16, "JSON", 4);
    memcpy(out + 20, glb_json, sizeof glb_json - 1);
    put_u32(out + 20 + json, sizeof body);
    memcpy(out + 24 + json, "BIN\0", 4);
    memcpy(out + 28 + json, &body, sizeof body);
    return size;
}

static void small_glb_loads_whole(void **state)
{
    (void)state;
    uint8_t bytes[4096];
    size_t size = make_glb(bytes);
    write_bytes(in_folder("case.glb"), bytes, size);
    assert_true(load_any(in_folder("case.glb")));
}

static void every_truncation_gives_one_message(void **state)
{
    (void)state;
    uint8_t bytes[4096];
    size_t size = make_glb(bytes);
    limit_seconds(120);
    for (size_t cut = 0; cut < size; cut++) {
        write_bytes(in_folder("case.glb"), bytes, cut);
        assert_false(
            load_any(in_folder("case.glb"))); /* the header's length says that something is missing */
    }
}

/* The same cut with a header that agrees with it, so that the cut reaches the chunks. */
static void every_truncation_with_a_true_header_gives_one_message(void **state)
{
    (void)state;
    uint8_t bytes[4096];
    size_t size = make_glb(bytes);
    limit_seconds(120);
    for (size_t cut = 20; cut < size; cut++) {
        put_u32(bytes + 8, cut);
        write_bytes(in_folder("case.glb"), bytes, cut);
        assert_false(load_any(in_folder("case.glb")));
    }
}

/* Marsaglia 2003, "Xorshift RNGs": the same bends in every run. */
static uint32_t next_random(uint32_t *s)
{
    *s ^= *s << 13;
    *s ^= *s >> 17;
    return *s ^= *s << 5;
}

static void bent_bytes_give_a_model_or_one_message(void **state)
{
    (void)state;
    uint8_t bytes[4096], bent[4096];
    size_t size = make_glb(bytes);
    uint32_t seed = 2463534242u, loaded = 0;
    limit_seconds(300);
    for (int round = 0; round < 3000; round++) {
        memcpy(bent, bytes, size);
        for (uint32_t n = 1 + next_random(&seed) % 3; n; n--)
            bent[next_random(&seed) % size] = (uint8_t)next_random(&seed);
        write_bytes(in_folder("case.glb"), bent, size);
        loaded += load_any(in_folder("case.glb"));
    }
    assert_true(loaded > 0); /* bends in spaces and in the low bits of floats do no harm */
}

/* Each number of the JSON in turn becomes one that is hard to digest. */
static void bent_numbers_give_a_model_or_one_message(void **state)
{
    (void)state;
    static const char *const numbers[] = {"-1",
                                          "0",
                                          "7",
                                          "255",
                                          "2147483647",
                                          "4294967295",
                                          "9223372036854775807",
                                          "18446744073709551615",
                                          "1e300",
                                          "1.5",
                                          "null",
                                          "\"x\"",
                                          "[]",
                                          "{}"};
    uint8_t bytes[4096];
    char json[4096];
    make_glb(bytes);
    limit_seconds(300);
    write_bytes(in_folder("data.bin"), &body, sizeof body);
    for (size_t i = 0; i + 1 < sizeof glb_json; i++) {
        bool digit = glb_json[i] >= '0' && glb_json[i] <= '9',
             before = strchr(":[,", glb_json[i - (i > 0)]) != NULL;
        if (!digit || !before)
            continue;
        size_t end = i + strspn(glb_json + i, "0123456789");
        for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++) {
            int length =
                snprintf(json, sizeof json, "%.*s%s%s", (int)i, glb_json, numbers[n], glb_json + end);
            char *buffer = strstr(
                json, "\"buffers\":[{"); /* the body stands beside, so that offsets still mean something */
            assert_non_null(buffer);
            char tail[256];
            snprintf(tail, sizeof tail, "%s", buffer + 12);
            length = (int)(buffer + 12 - json);
            length += snprintf(buffer + 12, sizeof json - (size_t)length, "\"uri\":\"data.bin\",%s", tail);
            write_bytes(in_folder("case.gltf"), json, (size_t)length);
            load_any(in_folder("case.gltf"));
        }
    }
}

/* ---- costs ---- */

static char *repeat(const char *head, const char *piece, size_t count, const char *tail)
{
    size_t n = strlen(piece), at = strlen(head);
    char *text = malloc(at + n * count + strlen(tail) + 1);
    assert_non_null(text);
    memcpy(text, head, at);
    for (size_t i = 0; i < count; i++, at += n)
        memcpy(text + at, piece, n);
    strcpy(text + at, tail);
    return text;
}

static void expect_refusal(char *text, kd_status expected)
{
    kd_model *model = NULL;
    limit_seconds(60);
    assert_int_equal(load_case(text, NULL, 0, &model), expected);
    assert_int_equal(seen_messages.errors, 1);
    free(text);
}

static void costly_texts_are_refused(void **state)
{
    (void)state;
    expect_refusal(repeat("{'asset':{'version':'2.0'},'extensions':", "[", 100000, ""), KD_TOO_LARGE);
    expect_refusal(repeat("{'asset':{'version':'2.0'},'extensions':{'x':[", "{'a':", 63, "}"), KD_TOO_LARGE);
    expect_refusal(repeat("{'asset':{'version':'2.0'},'materials':[{}", ",{}", 70000, "]}"), KD_TOO_LARGE);
    expect_refusal(repeat("{'asset':{'version':'2.0'},'images':[{}", ",{}", 70000, "]}"), KD_TOO_LARGE);
    expect_refusal(repeat("{'asset':{'version':'2.0'},'nodes':[{}", ",{}", 1100000, "]}"), KD_TOO_LARGE);
    expect_refusal(repeat("{'asset':{'version':'2.0'},'extensions':{'x':[0", ",[]", 4300000, "]}}"),
                   KD_TOO_LARGE);
    expect_refusal(repeat("{'asset':{'version':'2.0'},'scenes':[{}]", " ", 70u << 20, "}"), KD_TOO_LARGE);
}

/* An accessor without a view is zeros, which cost the file nothing: a short file must not unfold to
 * gigabytes. */
static void short_files_do_not_unfold_to_gigabytes(void **state)
{
    (void)state;
    expect_refusal(repeat("{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'accessors':[{'componentType':"
                          "5126,'type':'VEC3',"
                          "'count':60000000}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}",
                          "", 0, "]}]}"),
                   KD_TOO_LARGE);
    expect_refusal(repeat("{'asset':{'version':'2.0'},'nodes':[{'mesh':0}],'accessors':[{'componentType':"
                          "5126,'type':'VEC3',"
                          "'count':300000}],'meshes':[{'primitives':[{'attributes':{'POSITION':0}}",
                          ",{'attributes':{'POSITION':0}}", 1000, "]}]}"),
                   KD_TOO_LARGE);
}

/* `extras` may hold anything at any size: they are blanked, not parsed. */
static void large_extras_cost_nothing(void **state)
{
    (void)state;
    struct rusage before, after;
    char *text = repeat("{'asset':{'version':'2.0'},'extras':{'x':[0", ",0", 5000000, "]}}");
    kd_model *model = NULL;
    getrusage(RUSAGE_SELF, &before);
    assert_int_equal(load_case(text, NULL, 0, &model), KD_BAD_FORMAT); /* no triangles */
    getrusage(RUSAGE_SELF, &after);
    assert_non_null(strstr(seen_messages.last_error, "no triangles"));
    free(text);
    /* 10 MB of text in a few copies; parsed values would take 170 bytes each, 850 MB (sanitizers triple the
     * copies). */
    assert_true(after.ru_maxrss - before.ru_maxrss < 400 * 1024);
}

static void long_chains_of_nodes_do_not_recurse(void **state)
{
    (void)state;
    size_t count = 200000, at = 0;
    char *text = malloc(count * 32);
    assert_non_null(text);
    at += (size_t)sprintf(text, "{'asset':{'version':'2.0'},'scenes':[{'nodes':[0]}],'nodes':[");
    for (size_t i = 0; i + 1 < count; i++)
        at += (size_t)sprintf(text + at, "{'children':[%zu]},", i + 1);
    sprintf(text + at, "{}]}");
    expect_refusal(text, KD_BAD_FORMAT); /* read to the end: it holds no triangles */
    assert_non_null(strstr(seen_messages.last_error, "no triangles"));
}

static void files_that_are_no_files_give_one_message(void **state)
{
    (void)state;
    assert_false(load_any("/nonexistent/model.glb"));
    assert_false(load_any("/tmp"));
    write_bytes(in_folder("case.glb"), "", 0);
    assert_false(load_any(in_folder("case.glb")));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_hostile_file_loads_or_gives_one_message),
        cmocka_unit_test(small_glb_loads_whole),
        cmocka_unit_test(every_truncation_gives_one_message),
        cmocka_unit_test(every_truncation_with_a_true_header_gives_one_message),
        cmocka_unit_test(bent_bytes_give_a_model_or_one_message),
        cmocka_unit_test(bent_numbers_give_a_model_or_one_message),
        cmocka_unit_test(large_extras_cost_nothing),
        cmocka_unit_test(costly_texts_are_refused),
        cmocka_unit_test(short_files_do_not_unfold_to_gigabytes),
        cmocka_unit_test(long_chains_of_nodes_do_not_recurse),
        cmocka_unit_test(files_that_are_no_files_give_one_message),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
