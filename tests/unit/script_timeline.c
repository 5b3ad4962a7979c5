/* What happens later in a scenario: kandil.at, every, run, wait, tween, follow, on_clip. Steps are 1/30 s
 * unless a test says otherwise. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>

#include <cmocka.h>

#include "runtime/script/ease.h"
#include "tests/script_fixture.h"

/* Load the text, take steps, and expect the scenario to have said nothing wrong. */
static void run_steps(const char *text, int steps, double fps)
{
    kd_world *w = fixture_world();
    kd_script *script;
    kd_status status = fixture_load(w, text, &script);
    for (int i = 0; i < steps && status == KD_OK; i++)
        status = kd_script_step(script, i / fps, 1 / fps);
    if (status != KD_OK)
        fail_msg("%s\ngave status %d: %s", text, (int)status, fixture_message);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void run_and_expect(const char *text, int steps, const char *said)
{
    run_steps(text, steps, 30);
    if (!strstr(fixture_said, said))
        fail_msg("%s\nsaid '%s', not '%s'", text, fixture_said, said);
}

static void expect_failure(const char *text, int steps, const char *says)
{
    kd_world *w = fixture_world();
    kd_script *script = NULL;
    kd_status status = fixture_load(w, text, &script);
    for (int i = 0; i < steps && status == KD_OK; i++)
        status = kd_script_step(script, i / 30.0, 1 / 30.0);
    if (status != KD_SCRIPT || !strstr(fixture_message, says) || !strstr(fixture_message, "; "))
        fail_msg("%s\ngave status %d: %s", text, (int)status, fixture_message);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

/* At 30 steps a second a period of 0.1 s falls due in steps 3, 6, 9 …; the sum of periods does not drift. */
static void every_fires_once_a_period(void **state)
{
    (void)state;
    run_and_expect("n = 0 kandil.every(0.1, function(t) n = n + 1 print(n, math.floor(t * 30 + 0.5)) end)",
                   31, " 10 30");
    run_and_expect("n = 0 kandil.every(0.1, function() n = n + 1 print(n) return n < 4 end)", 31, " 4");
    run_and_expect("n = 0 k = kandil.every(0.01, function() n = n + 1 end)\n"
                   "kandil.at(0.5, function() k:cancel() print(n, k:done()) end)",
                   31, " 49 true"); /* the last falls due when it is cancelled, which was asked for first */
}

static void coroutines_wait_and_go_on(void **state)
{
    (void)state;
    run_and_expect("log = ''\n"
                   "kandil.run(function(a, b)\n"
                   "  log = log .. a .. b kandil.wait(0.1) log = log .. 'c' kandil.wait() log = log .. 'd'\n"
                   "  print(log, math.floor(kandil.time() * 30 + 0.5))\n"
                   "end, 'a', 'b') log = log .. '|'",
                   10, " ab|cd 4");
    /* Ten waits of 0.05 s end at 0.5 s, step 15, although each ends between two steps. */
    run_and_expect(
        "kandil.run(function() for i = 1, 10 do kandil.wait(0.05) end print(kandil.time() * 30) end)", 20,
        " 15.0");
    run_and_expect(
        "local a = kandil.run(function() kandil.wait(0.2) end)\n"
        "local b = kandil.run(function() kandil.wait(0.3) end)\n"
        "kandil.run(function() kandil.wait(a, b) print('both', math.floor(kandil.time() * 30 + 0.5), "
        "a:done() and b:done()) end)",
        20, " both 9 true");
    /* One that has ended is not waited for; pcall and loops may stand round a wait. */
    run_and_expect(
        "local a = kandil.run(function() end)\n"
        "kandil.run(function() kandil.wait(a) local ok, e = pcall(function() kandil.wait(0.1) error('x', 0) "
        "end) print(ok, e) end)",
        20, " false x");
}

static void a_cancelled_task_wakes_who_waits(void **state)
{
    (void)state;
    run_and_expect(
        "local a = kandil.run(function() kandil.wait(100) end)\n"
        "kandil.run(function() kandil.wait(a) print('on', math.floor(kandil.time() * 30 + 0.5)) end)\n"
        "kandil.at(0.2, function() a:cancel() end)",
        10, " on 6");
    /* A coroutine that waits for another can be cancelled too, and the other then wakes nobody. */
    run_and_expect("local a = kandil.run(function() kandil.wait(0.2) end)\n"
                   "local b = kandil.run(function() kandil.wait(a) print('wrong') end)\n"
                   "kandil.run(function() kandil.wait(b) print('right') end) b:cancel()",
                   10, " right");
}

static void mistakes_in_coroutines_name_their_line(void **state)
{
    (void)state;
    expect_failure("kandil.run(function()\nkandil.wait(0.1)\nlocal x = nothing.here end)", 9,
                   "scene.lua:3: attempt");
    expect_failure("kandil.run(function()\nkandil.wait(0.1)\nerror('late') end)", 9, "scene.lua:3: late");
    expect_failure("kandil.run(function()\nkandil.wait(0.1)\nkandil.spawn{modle = 1} end)", 9,
                   "scene.lua:3:");
    expect_failure("kandil.wait(1)", 0, "kandil.run");
    expect_failure("kandil.run(function() coroutine.wrap(function() kandil.wait(1) end)() end)", 0,
                   "kandil.run");
    expect_failure("kandil.run(function()\ncoroutine.yield() end)", 0,
                   "scene.lua:2: a function of kandil.run yielded");
    expect_failure("kandil.run(function() kandil.wait(-1) end)", 0, "seconds from 0");
    expect_failure("local t t = kandil.run(function() kandil.wait(0.1) kandil.wait(t) end)", 9,
                   "wait for itself");
    expect_failure("kandil.every(0, print)", 0, "too short");
}

static void endless_coroutines_are_stopped(void **state)
{
    (void)state;
    static const char *const scripts[] = {
        "kandil.run(function() while true do end end)",
        "kandil.run(function() kandil.wait() while true do end end)",
        "kandil.run(function() kandil.wait() while true do pcall(function() while true do end end) end end)",
        "kandil.every(0.01, function() while true do end end)",
        "for i = 1, 4 do kandil.every(1e-6, function() end) end",
        "kandil.run(function() while true do kandil.wait(1e-9) end end)",
        "kandil.tween(function() while true do end end, 1)",
        "while true do pcall(kandil.run, error) end",
        "while true do kandil.run(function() for i = 1, 150 do end end) end",
        "while true do kandil.run(function() kandil.wait(1) end) end",
        "for i = 1, 1e9 do kandil.tween(print, 1e6) end",
        "local function f() kandil.run(f) end f()",
        /* each resumption alone is short, all of a step together are not */
        ("for i = 1, 20000 do kandil.run(function() while true do kandil.wait() for k = 1, 150 do end end "
         "end) end"),
    };
    for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++)
        expect_failure(scripts[i], 3, "scene.lua");
}

/* Linear: at 0.1 s of 0.4 s a quarter of the way, the end exactly; the value at the start is where it stood.
 */
static void tweens_move_fields(void **state)
{
    (void)state;
    run_steps(
        "e = kandil.spawn{light = {}, transform = {position = {1, 2, 3}}}\n"
        "kandil.tween(e, 'transform.position', {5, 2, -1}, 0.4, 'linear')\n"
        "kandil.tween(e, 'light.outer_cone_deg', 85, 0.4, 'linear')\n"
        "kandil.tween(e, 'light.color.g', 0, 0.4, 'linear')\n"
        "local function near(a, b) if math.abs(a - b) > 1e-5 then error(a .. ' is not ' .. b, 2) end end\n"
        "function kandil.update(t) local s = math.min(t / 0.4, 1) local p = e.transform.position\n"
        "near(p[1], 1 + 4 * s) near(p[2], 2) near(p[3], 3 - 4 * s) near(e.light.outer_cone_deg, 45 + 40 * "
        "s)\n"
        "near(e.light.color[2], 1 - s) near(e:get('light.color.r'), 1)\n"
        "if t > 0.4 then assert(p[1] == 5 and p[3] == -1 and e.light.color[2] == 0) end end",
        20, 30);
    /* A rotation goes the short way at constant speed: half-way to 90 degrees are 45. Angles go as they are
     * said. */
    run_steps(
        "a = kandil.spawn{} b = kandil.spawn{} c = kandil.spawn{transform = {position = {0, 0, 1}}}\n"
        "kandil.tween(a, 'transform.rotation', {0, math.sin(math.pi / 4), 0, math.cos(math.pi / 4)}, 1, "
        "'linear')\n"
        "kandil.tween(b, 'transform.rotation_deg', {0, 720, 0}, 1, 'linear')\n"
        "kandil.tween(c, 'transform.look_at', {1, 0, 1}, 1, 'linear')\n"
        "local function near(a, b) if math.abs(a - b) > 1e-3 then error(a .. ' is not ' .. b, 2) end end\n"
        "kandil.at(0.5, function() kandil.update = function()\n"
        "  near(a.transform.rotation_deg[2], 45) near(math.abs(b.transform.rotation_deg[2]), 0)\n"
        "  near(c.transform.rotation_deg[2], -45) kandil.update = nil end end)",
        20, 30);
}

static void tweens_chain_without_loss(void **state)
{
    (void)state;
    /* Two of 0.05 s one after the other end at 0.1 s = step 3; the third has then just begun. */
    run_and_expect(
        "e = kandil.spawn{}\n"
        "kandil.run(function() for i = 1, 3 do\n"
        "  kandil.wait(kandil.tween(e, 'transform.position', {i, 0, 0}, 0.05, 'linear')) end end)\n"
        "kandil.at(0.1, function() kandil.update = function(t)\n"
        "  print(e.transform.position[1]) kandil.update = nil end end)",
        5, " 2.0");
    run_and_expect("e = kandil.spawn{} kandil.tween(e, 'transform.position', {4, 0, 0}, 0)\n"
                   "function kandil.update() print(e.transform.position[1]) end",
                   1, " 4.0");
    run_and_expect("local t = kandil.tween(function(s) print(s) end, 0.1, 'linear')", 10, " 1.0");
    /* What moves may be destroyed; who waits goes on. */
    run_and_expect(
        "e = kandil.spawn{} t = kandil.tween(e, 'transform.position', {4, 0, 0}, 100)\n"
        "kandil.at(0.1, function() e:destroy() end) kandil.run(function() kandil.wait(t) print('gone') end)",
        9, " gone");
    expect_failure("e = kandil.spawn{light = {}} kandil.tween(e, 'light.type', 'spot', 1)", 0,
                   "does not change by degrees");
    expect_failure("e = kandil.spawn{light = {}} kandil.tween(e, 'light.intensity', 5, 1, 'cubi_in')", 0,
                   "cubic");
    expect_failure("e = kandil.spawn{part = {}} kandil.tween(e, 'light.intensity', 5, 1)", 0,
                   "has no 'light'");
    expect_failure("e = kandil.spawn{light = {}} kandil.tween(e, 'light.intensity', -5, 1)", 0,
                   "out of range");
}

/* A curve that swings out stays within the field's range. */
static void tweens_heed_ranges(void **state)
{
    (void)state;
    run_steps("e = kandil.spawn{light = {intensity = 1}}\n"
              "kandil.tween(e, 'light.intensity', 0, 1, 'elastic_out')\n"
              "function kandil.update() assert(e.light.intensity >= 0) end",
              31, 30);
}

static void easings_start_at_0_and_end_at_1(void **state)
{
    (void)state;
    static const char *const directions[] = {"in", "out", "inout"};
    char name[64];
    for (int f = 0; script_ease_families[f]; f++) {
        for (int d = 0; d < 3; d++) {
            snprintf(name, sizeof name, "%s_%s", script_ease_families[f], directions[d]);
            int curve = script_ease_find(name);
            assert_true(curve >= 0);
            assert_true(script_ease(curve, 0) == 0 && script_ease(curve, 1) == 1);
            assert_true(script_ease(curve, -1) == 0 && script_ease(curve, 2) == 1);
            /* near the ends it is near them, and inout is symmetric about its middle */
            assert_true(fabs(script_ease(curve, 1e-6)) < 1e-3 &&
                        fabs(script_ease(curve, 1 - 1e-6) - 1) < 1e-3);
            if (d == 2)
                for (double s = 0.05; s < 0.5; s += 0.05)
                    assert_true(fabs(script_ease(curve, s) + script_ease(curve, 1 - s) - 1) < 1e-12);
        }
    }
    assert_true(script_ease(script_ease_find("quad_in"), 0.5) == 0.25);
    assert_true(script_ease(script_ease_find("cubic_out"), 0.5) == 0.875);
    assert_true(fabs(script_ease(script_ease_find("sine_inout"), 0.5) - 0.5) < 1e-12);
    assert_true(script_ease(script_ease_find("back_in"), 0.3) < 0);
    assert_true(fabs(script_ease(script_ease_find("bounce_out"), 1 / 2.75) - 1) < 1e-9); /* the first touch */
    assert_int_equal(script_ease_find("quad"), -1);
    assert_int_equal(script_ease_find("ease_"), -1);
}

/* Along a straight line a path goes at constant speed; through its points in any case. */
static void paths_are_walked_at_constant_speed(void **state)
{
    (void)state;
    run_steps(
        "local function near(a, b, e) if math.abs(a - b) > (e or 1e-4) then error(a .. ' is not ' .. b, 2) "
        "end end\n"
        "local line = kandil.path{{0, 0, 0}, {1, 0, 0}, {4, 0, 0}}\n"
        "near(line:length(), 4) for i = 0, 8 do near(line:at(i / 8)[1], i / 2, 1e-3) end\n"
        "near(line:at(-1)[1], 0) near(line:at(2)[1], 4)\n"
        "local p, d = line:at(0.3) near(d[1], 1) near(d[2], 0)\n"
        /* a square with rounded corners: at quarters of its length it meets its corners, by symmetry */
        "local round = kandil.path{{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0, 1}, closed = true}\n"
        "for i, c in ipairs{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}} do local q = round:at((i - 1) / 4)\n"
        "  near(q[1], c[1], 1e-3) near(q[3], c[2], 1e-3) end\n"
        "local length, last = 0, round:at(0)\n"
        "for i = 1, 200 do local q = round:at(i / 200)\n"
        "  local step = ((q[1] - last[1])^2 + (q[2] - last[2])^2 + (q[3] - last[3])^2)^0.5\n"
        "  near(step, round:length() / 200, round:length() / 200 * 0.03) length = length + step last = q "
        "end\n"
        "near(length, round:length(), 0.01)\n"
        "local dot = kandil.path{{1, 1, 1}, {1, 1, 1}} near(dot:at(0.5)[1], 1)\n",
        0, 30);
    expect_failure("kandil.path{{1, 2, 3}}", 0, "2 to 100000 points");
    expect_failure("kandil.path{{1, 2, 3}, {1, 2}}", 0, "must have 3 numbers");
}

static void cameras_follow_paths(void **state)
{
    (void)state;
    run_steps(
        "local function near(a, b) if math.abs(a - b) > 1e-3 then error(a .. ' is not ' .. b, 2) end end\n"
        "local line = kandil.path{{0, 0, 0}, {4, 0, 0}}\n"
        "a = kandil.spawn{} b = kandil.spawn{} c = kandil.spawn{} goal = kandil.spawn{transform = {position "
        "= {9, 0, 0}}}\n"
        "kandil.follow(a, line, 1) kandil.follow(b, line, 1, {look_at = 'path'})\n"
        "kandil.follow(c, line, 0.25, {look_at = goal, loop = true})\n"
        "kandil.at(0.5, function() kandil.update = function()\n"
        "  near(a.transform.position[1], 2) near(a.transform.rotation_deg[2], 0)\n"
        "  near(b.transform.position[1], 2) near(b.transform.rotation_deg[2], -90)\n"
        "  near(c.transform.position[1], 0) near(c.transform.rotation_deg[2], -90) kandil.update = nil end "
        "end)",
        20, 30);
    /* the camera's parent is turned, and the target hangs below another */
    run_steps(
        "local function near(a, b) if math.abs(a - b) > 1e-3 then error(a .. ' is not ' .. b, 2) end end\n"
        "local rail = kandil.spawn{transform = {position = {1, 0, 0}, rotation_deg = {0, 90, 0}}}\n"
        "local base = kandil.spawn{transform = {position = {0, 0, -4}}}\n"
        "local goal = kandil.spawn{parent = base, transform = {position = {1, 0, 0}}}\n"
        "local camera = kandil.spawn{parent = rail}\n"
        "kandil.follow(camera, kandil.path{{0, 0, 0}, {4, 0, 0}}, 1, {look_at = goal})\n"
        "kandil.at(0.5, function() kandil.update = function()\n" /* it is at 1, 0, -2, the goal at 1, 0, -4 */
        "  near(camera.transform.rotation_deg[2], -90) kandil.update = nil end end)",
        20, 30);
    expect_failure("kandil.follow(kandil.spawn{}, 5, 1)", 0, "path");
    expect_failure("kandil.follow(kandil.spawn{}, kandil.path{{0,0,0},{1,0,0}}, 1, {look = 1})", 0,
                   "unknown key 'look'");
}

/* The test plays the animation system: 0.3 s a step in a clip of 1 s that loops. The event at 0.5 s is passed
 * between 0.3 and 0.6, then between 0.2 + … : times 0 .3 .6 .9 .2 .5 .8 .1 .4 .7 pass it at .6, .5 and .7. */
static void clip_events_fire_once_a_pass(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(
            w,
            "e = kandil.spawn{name = 'e'} e.animation = {clip = 1, speed = 1, loop = true} n, m = 0, 0\n"
            "k = e:on_clip('walk', 0.5, function(who) assert(who == e) n = n + 1 end)\n"
            "e:on_clip('walk', 0, function() m = m + 1 end)\n"
            "function kandil.update() print(n, m) end",
            &script),
        KD_OK);
    static const char *const said[] = {" 0 1", " 0 1", " 1 1", " 1 1", " 1 2",
                                       " 2 2", " 2 2", " 2 3", " 2 3", " 3 3"};
    for (int i = 0; i < 10; i++) {
        fixture_animation *a = kd_find_mut_id(w, kd_find_named(w, "e"), kd_component_find(w, "animation"));
        a->time_s = (float)((3 * i) % 10) / 10;
        assert_int_equal(kd_script_step(script, i / 30.0, 1 / 30.0), KD_OK);
        if (!strstr(fixture_said, said[i]))
            fail_msg("step %d said '%s', not '%s'", i, fixture_said, said[i]);
    }
    kd_script_destroy(script);
    kd_world_destroy(w);
    expect_failure("kandil.spawn{animation = {}}:on_clip('run', 0, print)", 0, "it has walk");
    expect_failure("kandil.spawn{animation = {}}:on_clip('walk', 2, print)", 0, "is 1.0 s long");
}

/* The animation system adds rounded steps to a rounded time, so it comes to 0.49999997 here, to 1.0000001
 * there. Ten minutes of a clip of 1 s: events at 0 and 0.5 s come in the steps that reach them, either way
 * round. */
static void clip_events_do_not_drift(void **state)
{
    (void)state;
    for (int direction = -1; direction <= 1; direction += 2) {
        kd_world *w = fixture_world();
        kd_script *script;
        assert_int_equal(
            fixture_load(w,
                         "e = kandil.spawn{name = 'e'} e.animation = {clip = 1, loop = true}\n"
                         "local function check(at, rest)\n"
                         "  local n = 0 e:on_clip('walk', at, function() n = n + 1\n"
                         "    local step = math.floor(kandil.time() * 24 + 0.5)\n"
                         "    if step % 24 ~= rest then error(at .. ' s in step ' .. step) end end)\n"
                         "  kandil.at(599.99, function() print(n) assert(n == 600) end) end\n"
                         "check(0, 0) check(0.5, 12)",
                         &script),
            KD_OK);
        kd_component_id id = kd_component_find(w, "animation");
        float time_s = 0;
        for (int i = 0; i <= 24 * 600; i++) {
            fixture_animation *a = kd_find_mut_id(w, kd_find_named(w, "e"), id);
            a->speed = (float)direction;
            a->time_s = time_s;
            if (kd_script_step(script, i / 24.0, 1 / 24.0) != KD_OK)
                fail_msg("direction %d, step %d: %s", direction, i, fixture_message);
            double next = fmod((double)time_s + direction * (double)(1.0f / 24), 1);
            time_s = (float)(next < 0 ? next + 1 : next);
            time_s = time_s >= 1 ? 0 : time_s;
        }
        assert_non_null(strstr(fixture_said, " 600"));
        kd_script_destroy(script);
        kd_world_destroy(w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_fires_once_a_period),
        cmocka_unit_test(coroutines_wait_and_go_on),
        cmocka_unit_test(a_cancelled_task_wakes_who_waits),
        cmocka_unit_test(mistakes_in_coroutines_name_their_line),
        cmocka_unit_test(endless_coroutines_are_stopped),
        cmocka_unit_test(tweens_move_fields),
        cmocka_unit_test(tweens_chain_without_loss),
        cmocka_unit_test(tweens_heed_ranges),
        cmocka_unit_test(easings_start_at_0_and_end_at_1),
        cmocka_unit_test(paths_are_walked_at_constant_speed),
        cmocka_unit_test(cameras_follow_paths),
        cmocka_unit_test(clip_events_fire_once_a_pass),
        cmocka_unit_test(clip_events_do_not_drift),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
