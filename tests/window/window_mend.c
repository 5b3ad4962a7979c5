/* Files are broken and mended while the window is open: what is on in the end is what they say. */
#include "tests/window_fixture.h"

static const area inside = {260, 20, 470, 230};
static picture seen;

/* A triangle that fills the picture, in one colour; its clip makes it green. */
static const char model[] =
    "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_animation_pointer\",\"KHR_materials_unlit\"],"
    "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0,"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%s,1]},\"doubleSided\":true,"
    "\"extensions\":{\"KHR_materials_unlit\":{}}}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
    "\"animations\":[{\"name\":\"green\",\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{"
    "\"sampler\":0,"
    "\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":"
    "\"/materials/0/pbrMetallicRoughness/baseColorFactor\"}}}}]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[-4,-3,0],"
    "\"max\":[4,6,0]},{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\",\"min\":[0],"
    "\"max\":[1]},{\"bufferView\":2,\"componentType\":5126,\"count\":2,\"type\":\"VEC4\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":8},"
    "{\"buffer\":0,\"byteOffset\":44,\"byteLength\":32}],"
    "\"buffers\":[{\"byteLength\":76,\"uri\":\"data:application/octet-stream;base64,"
    "AACAwAAAQMAAAAAAAACAQAAAQMAAAAAAAAAAAAAAwEAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAAAAAIA/AAAAAAAAgD8AAAAA"
    "AACAPw=="
    "\"}]}";

/* What is outside of the middle is another scenario's. */
static const char scenario[] = "kandil.scene { size = {480, 240}, gi = 'none' }\n"
                               "local model = kandil.spawn { model = 'm.gltf' }\n"
                               "kandil.spawn { camera = {}, transform = { position = {0, 0, 2} } }\n"
                               "%s\n";

static void write_model(const char *color)
{
    char text[4096];
    snprintf(text, sizeof text, model, color);
    window_write("m.gltf", text);
}

static void write_scenario(const char *more)
{
    char text[1024];
    snprintf(text, sizeof text, scenario, more);
    window_write("scene.lua", text);
}

static bool shows(int channel)
{
    double mean[3];
    for (int i = 0; i < 3; i++)
        mean[i] = picture_mean(&seen, inside, i);
    return mean[channel] > 100 && mean[(channel + 1) % 3] < 50 && mean[(channel + 2) % 3] < 50;
}

static void wait_until_said(const char *text, int times)
{
    double deadline = program_clock_s() + WINDOW_PATIENCE_S;
    for (; window_times_said(text) < times; window_rest(0.02))
        assert_true(program_clock_s() < deadline);
}

/* The scenario with a line more and a red model, in a window without panels. */
static void start_red(const char *more)
{
    write_model("1,0,0");
    write_scenario(more);
    window_start("scene.lua");
    window_key(KEY_F1);
}

static void what_a_clip_has_moved_comes_back(void **state)
{
    (void)state;
    start_red("model:play('green')");
    WINDOW_UNTIL(&seen, shows(1));
    write_scenario("");
    WINDOW_UNTIL(&seen, shows(0));
    assert_string_equal(window_finish(), "");
}

static void a_model_changed_beside_a_broken_scenario_is_seen(void **state)
{
    (void)state;
    start_red("");
    WINDOW_UNTIL(&seen, shows(0));
    write_scenario("error('first; mend it')");
    wait_until_said("first", 1);
    write_scenario("error('second; mend it')");
    wait_until_said("second", 1);
    write_model("0,0,1");
    wait_until_said("second", 2);
    write_scenario("");
    WINDOW_UNTIL(&seen, shows(2));
    (void)window_finish();
}

static void steps_may_ask_for_what_systems_know(void **state)
{
    (void)state;
    start_red("function kandil.update() kandil.get('view.width') end");
    WINDOW_UNTIL(&seen, shows(0));
    write_scenario("kandil.log('again')\n"
                   "function kandil.update() if kandil.get('view.width') then kandil.find('gone') end end\n"
                   "model:play('green')");
    WINDOW_UNTIL(&seen, shows(1));
    assert_string_equal(window_finish(), "kandil: scene.lua: again\n");
}

static void files_of_a_failed_load_are_watched(void **state)
{
    (void)state;
    start_red("");
    WINDOW_UNTIL(&seen, shows(0));
    write_scenario("require('beside')(model)");
    wait_until_said("beside.lua: not found", 1);
    window_write("beside.lua", "return function(");
    wait_until_said("expected", 1);
    window_write("beside.lua", "return function(model) model:play('green') end\n");
    WINDOW_UNTIL(&seen, shows(1));
    (void)window_finish();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        WINDOW_TEST(what_a_clip_has_moved_comes_back),
        WINDOW_TEST(a_model_changed_beside_a_broken_scenario_is_seen),
        WINDOW_TEST(steps_may_ask_for_what_systems_know),
        WINDOW_TEST(files_of_a_failed_load_are_watched),
    };
    return WINDOW_RUN(tests);
}
