/* How quickly the picture follows what happens: light that goes out, a glowing thing that leaves. Of the
 * final difference nine tenths are there in the same frame, all but a hundredth two frames later, and nothing
 * is left after ten. */
#include "tests/image_fixture.h"

enum { HAPPENS = 12, LAST = 32 };

/* A room open to the camera, with a red and a green wall; what happens is told in the second part. */
static const char room[] =
    "kandil.scene { size = {64, 48}, fps = 30 }\n"
    "local e, t = {4, 3, 4}, 0.3\n"
    "for axis = 1, 3 do\n"
    "    for side = -1, 1, 2 do\n"
    "        local size, place = {e[1] + 2 * t, e[2] + 2 * t, e[3] + 2 * t}, {0, 0, 0}\n"
    "        local color = axis ~= 1 and {0.7, 0.7, 0.7} or side == 1 and {0.7, 0.2, 0.2} or {0.2, 0.7, "
    "0.2}\n"
    "        size[axis], place[axis] = t, side * (e[axis] + t) / 2\n"
    "        if axis < 3 or side < 0 then\n"
    "            kandil.spawn { mesh = { shape = 'box', size = size }, transform = { position = place },\n"
    "                           material = { base_color = color } }\n"
    "        end\n"
    "    end\n"
    "end\n"
    "kandil.spawn { camera = { fov_y_deg = 60 }, transform = { position = {0, 0, 1.9}, look_at = {0, 0, 0} } "
    "}\n"
    "local leaves = kandil.spawn { %s }\n"
    "kandil.at(%d / 30 - 0.01, function() %s end)\n";

static image frame_of(const char *name, int number)
{
    char file[64];
    snprintf(file, sizeof file, "%s_%04d.exr", name, number);
    return image_read(file);
}

static double distance(image a, image b)
{
    double sum = 0;
    for (size_t i = 0; i < image_count(a); i++)
        sum += fabs((double)a.rgb[i] - (double)b.rgb[i]);
    return sum / (double)image_count(a);
}

/* What is left to change `later` frames after it happened, as a share of the whole change. */
static double left(const char *name, int later)
{
    image before = frame_of(name, HAPPENS - 1), now = frame_of(name, HAPPENS + later),
          end = frame_of(name, LAST);
    double whole = distance(before, end), rest = distance(now, end);
    assert_double_above(whole, 1e-3);
    image_free(&before);
    image_free(&now);
    image_free(&end);
    return rest / whole;
}

static void react(const char *name, const char *what, const char *happens, double third_limit,
                  double tenth_limit)
{
    char pattern[64], frames[8];
    snprintf(pattern, sizeof pattern, "%s_%%04d.exr", name);
    snprintf(frames, sizeof frames, "%d", LAST + 1);
    image_render(image_scenario("reaction.lua", room, what, HAPPENS, happens), "--frames", frames, "--set",
                 "voxels.resolution=128", "--set", "voxels.cascades=2", "--set", "voxels.span=0.03", "--out",
                 image_path(pattern));
    assert_double_below(left(name, 0), 0.1);
    assert_double_below(left(name, 2), third_limit);
    assert_double_below(left(name, 10), tenth_limit);
}

static const char lamp[] =
    "light = { type = 'point', intensity = 10 }, transform = { position = {0.7, 0.4, 0.3} }";
static const char body[] = "mesh = { shape = 'box', size = 0.5 }, transform = { position = {0.7, 0.4, 0.3} },"
                           "material = { base_color = {0, 0, 0}, emissive = {20, 20, 20} }";

static void a_lamp_goes_out(void **state)
{
    (void)state;
    react("lamp", lamp, "leaves.light.intensity = 0", 0.01, 1e-4);
}

static void a_glowing_body_is_destroyed(void **state)
{
    (void)state;
    react("gone", body, "leaves:destroy()", 0.01, 1e-4);
}

/* What comes is there at once; what it sends round many times grows from frame to frame. */
static void a_glowing_body_is_elsewhere(void **state)
{
    (void)state;
    react("came", body, "leaves.transform.position = {-0.7, -0.4, 0}", 0.02, 0.003);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lamp_goes_out),
        cmocka_unit_test(a_glowing_body_is_destroyed),
        cmocka_unit_test(a_glowing_body_is_elsewhere),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
