/* kandil.spawn, entity handles, the timeline: what a scenario says reaches the world. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>

#include <cmocka.h>

#include "tests/script_fixture.h"

static const fixture_transform *transform_of(kd_world *w, const char *name)
{
    const fixture_transform *t = kd_find_id(w, kd_find_named(w, name), kd_component_find(w, "transform"));
    assert_non_null(t);
    return t;
}

static kd_vec3 turned(kd_quat q, kd_vec3 v)
{
    kd_mat4 m = kd_mat4_from_trs((kd_vec3){0, 0, 0}, q, (kd_vec3){1, 1, 1});
    return kd_mat4_direction(&m, v);
}

static void assert_near(kd_vec3 a, kd_vec3 b, float tolerance)
{
    if (!(kd_vec3_length(kd_vec3_sub(a, b)) <= tolerance))
        fail_msg("%g %g %g is not %g %g %g", (double)a.x, (double)a.y, (double)a.z, (double)b.x, (double)b.y,
                 (double)b.z);
}

static void spawn_sets_components_through_reflection(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(
            w,
            "local p = kandil.spawn{name = 'parent', transform = {position = {1, 2, 3}, scale = {2, 2, 2}}}\n"
            "kandil.spawn{name = 'lamp', parent = p, light = {type = 'spot', intensity = 7, outer_cone_deg = "
            "30, "
            "no_shadow = true, color = {1, 0.5, 0}}}\n",
            &script),
        KD_OK);
    assert_near(transform_of(w, "parent")->position, (kd_vec3){1, 2, 3}, 0);
    assert_near(transform_of(w, "parent")->scale, (kd_vec3){2, 2, 2}, 0);
    kd_entity lamp = kd_find_named(w, "lamp");
    const fixture_light *light = kd_find_id(w, lamp, kd_component_find(w, "light"));
    assert_non_null(light);
    assert_int_equal(light->type, 2);
    assert_true(light->intensity == 7 && light->no_shadow == 1);
    assert_true(fabsf(light->outer_cone - 0.5235988f) < 1e-6f); /* 30 degrees, one rounding to float */
    assert_near(light->color, (kd_vec3){1, 0.5f, 0}, 0);
    assert_true(kd_entity_equal(kd_get_parent(w, lamp), kd_find_named(w, "parent")));
    kd_script_destroy(script);
    kd_world_destroy(w);
}

/* -Z must point at the target, X stay level, and straight up or down be finite. Tolerance: a few roundings of
 * unit floats. */
static void look_at_points_at_the_target(void **state)
{
    (void)state;
    static const kd_vec3 directions[] = {{0, 0, -1},        {0, 0, 1},         {1, 0, 0},
                                         {-1, 0, 0},        {0, 1, 0},         {0, -1, 0},
                                         {0.3f, -1, -0.4f}, {-5, 0.01f, 2.5f}, {1e-4f, 1, 0}};
    for (size_t i = 0; i < sizeof directions / sizeof *directions; i++) {
        char text[256];
        kd_world *w = fixture_world();
        kd_script *script;
        kd_vec3 d = directions[i];
        snprintf(text, sizeof text,
                 "kandil.spawn{name = 'e', transform = {look_at = {%.9g, %.9g, %.9g}, position = {4, 5, 6}}}",
                 (double)(4 + d.x), (double)(5 + d.y), (double)(6 + d.z));
        assert_int_equal(fixture_load(w, text, &script), KD_OK);
        kd_quat q = transform_of(w, "e")->rotation;
        kd_vec3 seen = {(4 + d.x) - 4, (5 + d.y) - 5, (6 + d.z) - 6};
        assert_near(turned(q, (kd_vec3){0, 0, -1}), kd_vec3_normalize(seen, d), 2e-5f);
        /* near the vertical the picture's side is level only as far as the direction leans: 1e-4 here */
        assert_true(fabsf(turned(q, (kd_vec3){1, 0, 0}).y) < 2e-4f);
        assert_true(turned(q, (kd_vec3){0, 1, 0}).y > -1e-5f);
        kd_script_destroy(script);
        kd_world_destroy(w);
    }
}

static void rotation_deg_turns_about_x_then_y_then_z(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(
            w,
            "local e = kandil.spawn{name = 'y', transform = {rotation_deg = {0, 90, 0}}}\n"
            "kandil.spawn{name = 'xy', transform = {rotation_deg = {90, 90, 0}}}\n"
            "local d = e:get('transform.rotation_deg') "
            "assert(math.abs(d[2] - 90) < 1e-4 and math.abs(d[1]) < 1e-4 and math.abs(d[3]) < 1e-4)\n"
            "e.transform.rotation_deg = {10, 20, 30} d = e.transform.rotation_deg\n"
            "assert(math.abs(d[1] - 10) < 1e-4 and math.abs(d[2] - 20) < 1e-4 and math.abs(d[3] - "
            "30) < 1e-4)\n"
            "e:set('transform.rotation_deg', {0, 90 + 3600000, 0})\n",
            &script),
        KD_OK);
    /* A quarter turn about +Y takes +Z to +X. */
    assert_near(turned(transform_of(w, "y")->rotation, (kd_vec3){0, 0, 1}), (kd_vec3){1, 0, 0}, 1e-5f);
    /* About x first: +Y goes to +Z; then about y: +Z goes to +X. */
    assert_near(turned(transform_of(w, "xy")->rotation, (kd_vec3){0, 1, 0}), (kd_vec3){1, 0, 0}, 1e-5f);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

/* Each turn rounds to floats of a quaternion and of degrees: about 1e-5 degrees, and it must not add up. */
static void rotation_deg_stays_when_it_is_written_back(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(
            w,
            "local e = kandil.spawn{}\n"
            "for _, y in ipairs{0, 45, 89, 89.9, 89.99, 89.999, 90, -89.5, -89.99, -90} do\n"
            "  e.transform.rotation_deg = {0, y, 0}\n"
            "  for i = 1, 50 do e.transform.rotation_deg = e.transform.rotation_deg end\n"
            "  local d = e.transform.rotation_deg\n"
            "  assert(math.abs(d[2] - y) < 2e-4 and math.abs(d[1]) < 2e-4 and math.abs(d[3]) < 2e-4,\n"
            "    y .. ' became ' .. d[1] .. ' ' .. d[2] .. ' ' .. d[3])\n"
            "end\n"
            "for _, s in ipairs{{30, 90, 50}, {30, -90, 50}, {170, 90, -170}} do\n"
            "  e.transform.rotation_deg = s local q = e.transform.rotation\n"
            "  e.transform.rotation_deg = e.transform.rotation_deg local p = e.transform.rotation\n"
            "  local dot = q[1] * p[1] + q[2] * p[2] + q[3] * p[3] + q[4] * p[4]\n"
            "  assert(math.abs(dot) > 1 - 1e-6)\n"
            "end\n",
            &script),
        KD_OK);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void handles_read_write_and_go_stale(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(
            w,
            "local e = kandil.spawn{name = 'a', light = {}}\n"
            "e.transform.position = {1, 2, 3} assert(e.transform.position[2] == 2)\n"
            "e:set('light.type', 'point'):set('light.no_shadow', true) assert(e:get('light.type') == "
            "'point')\n"
            "assert(e.light.no_shadow == true and e.name == 'a') e.name = 'b' assert(e.name == 'b')\n"
            "local c = kandil.spawn{name = 'child', parent = e} local g = kandil.spawn{name = 'grand', "
            "parent = c}\n"
            "assert(e:child('grand') == g and e:child('child') == c and not pcall(e.child, e, 'nobody'))\n"
            "assert(not pcall(function() e.light.intensity = -1 end) and e.light.intensity == 3)\n"
            "e.part.hidden = true assert(e.part.hidden and not pcall(function() e.part.store = 1 end))\n"
            "assert(not pcall(function() e.transform.rotation = {0, 0, 0, 0} end))\n"
            "assert(not pcall(function() e.transform.position = {1, 2} end))\n"
            "assert(not pcall(function() e.transform.position = {1, 2, 0/0} end))\n"
            "assert(not pcall(function() e.transform.position = {1, 2, 1e300} end))\n"
            "e:destroy() assert(not e:alive() and not g:alive())\n"
            "assert(not pcall(function() return e.transform end) and not pcall(e.set, e, 'light.type', "
            "'spot'))\n",
            &script),
        KD_OK);
    assert_int_equal(kd_entity_count(w), 0);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void animations_and_materials_reach_the_host(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(
            w,
            "local e = kandil.spawn{mesh = {shape = 'box', size = {1, 2, 3}, segments = 4},\n"
            "  material = {base_color = {1, 0, 0}, metallic = 1, roughness = 0.25, emissive = {9, 8, 7}},\n"
            "  animation = {clip = 'walk', loop = false, speed = 2}}\n",
            &script),
        KD_OK);
    assert_string_equal(fixture_played, "walk 0 2 0");
    assert_near(fixture_spawned.mesh.size, (kd_vec3){1, 2, 3}, 0);
    assert_int_equal(fixture_spawned.mesh.segments, 4);
    assert_near(fixture_spawned.material.emissive, (kd_vec3){9, 8, 7}, 0);
    assert_true(fixture_spawned.material.metallic == 1 && fixture_spawned.material.roughness == 0.25f);
    assert_true(fixture_spawned.material.base_color.x == 1 && fixture_spawned.material.base_color.w == 1);
    kd_script_destroy(script);
    assert_int_equal(fixture_load(w, "kandil.spawn{}:play('jump', {blend = 0.5, loop = false})", &script),
                     KD_OK);
    assert_string_equal(fixture_played, "jump 0 1 0.5");
    kd_script_destroy(script);
    assert_int_equal(
        fixture_load(w,
                     "local e = kandil.spawn{} e:play('wave', {layer = 2, weight = 0.5, from = 'arm'})\n"
                     "assert(not pcall(e.play, e, 'wave', {weight = 0.5}))\n"
                     "assert(not pcall(e.play, e, 'wave', {layer = 4}))\n"
                     "assert(not pcall(e.play, e, 'wave', {layer = 1.5})) assert(not pcall(e.stop, e, 0))",
                     &script),
        KD_OK);
    assert_string_equal(fixture_played, "wave 1 1 0 layer 2 0.5 arm");
    kd_script_destroy(script);
    assert_int_equal(fixture_load(w, "kandil.spawn{}:stop(1, 0.25)", &script), KD_OK);
    assert_string_equal(fixture_played, "- 0 0 0.25 layer 1 0 stop");
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void mistakes_name_the_key(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says;
    } rows[] = {
        {"kandil.spawn{modle = 'x'}", "unknown key 'modle'; did you mean 'model'?"},
        {"kandil.spawn{xyzzy = 1}", "unknown key 'xyzzy'"},
        {"kandil.spawn{'x'}", "without a name"},
        {"kandil.spawn{light = {intensty = 3}}", "light: unknown key 'intensty'; did you mean 'intensity'?"},
        {"kandil.spawn{light = {outer_con_deg = 3}}", "did you mean 'outer_cone_deg'?"},
        {"kandil.spawn{light = {outer_cone_deg = 300}}", "from 0 to 90"},
        {"kandil.spawn{light = {type = 'sun'}}", "directional, point, spot"},
        {"kandil.spawn{light = 5}", "must be a table"},
        {"kandil.spawn{transform = {position = {1, 2}}}", "must have 3 numbers, not 2"},
        {"kandil.spawn{transform = {position = {1, 'a', 2}}}", "must be a number"},
        {"kandil.spawn{mesh = {shape = 'bax'}}", "box, sphere"},
        {"kandil.spawn{mesh = {shape = 'box', size = {-1, 1, 1}}}", "positive"},
        {"kandil.spawn{mesh = {shape = 'box', segments = 1e9}}", "mesh.segments"},
        {"kandil.spawn{mesh = {shape = 'box'}, material = {roughnes = 1}}", "did you mean 'roughness'?"},
        {"kandil.spawn{mesh = {shape = 'box'}, material = {base_color = {2, 0, 0}}}", "from 0 to 1"},
        {"kandil.spawn{material = {roughness = 1}}", "needs a model or a mesh"},
        {"kandil.spawn{parent = 5}", "must be an entity"},
        {"kandil.spawn{model = 5}", "must be a string"},
        {"kandil.spawn{part = {store = 1}}", "cannot be set"},
        {"kandil.spawn{name = 'bare', part = {hidden = true}}", "has no 'part' itself"},
        {"kandil.spawn()", "table expected"},
        {"kandil.scene{sise = {1, 1}}", "did you mean 'size'?"},
        {"kandil.scene{size = {0, 1}}", "from 1 to 16384"},
        {"kandil.scene{fps = -3}", "out of range"},
        {"kandil.updat = function() end", "did you mean kandil.update?"},
        {"kandil.update = 5", "must be a function"},
        {"kandil.spwan{}", "did you mean kandil.spawn?"},
        {"kandil.at(-1, print)", "seconds from 0"},
        {"kandil.at(1, 5)", "function expected"},
        {"local e = kandil.spawn{} e:set('position', {1, 2, 3})", "component.field"},
        {"local e = kandil.spawn{} e:set('light.intensity', 3)", "has no 'light'"},
        {"local e = kandil.spawn{} e:play('x', {blnd = 1})", "did you mean 'blend'?"},
        {"local e = kandil.spawn{} e.transfrom.position = {1, 2, 3}", "did you mean 'transform'?"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        kd_world *w = fixture_world();
        kd_script *script;
        kd_status status = fixture_load(w, rows[i].text, &script);
        if (status != KD_SCRIPT || fixture_errors != 1 || !strstr(fixture_message, rows[i].says) ||
            !strstr(fixture_message, "scene.lua:1:"))
            fail_msg("%s\ngave status %d: %s", rows[i].text, (int)status, fixture_message);
        kd_world_destroy(w);
    }
}

static void host_errors_carry_the_line_and_can_be_caught(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    fixture_write("broken.glb", "x", 1);
    assert_int_equal(fixture_load(w, "\nkandil.spawn{model = 'broken.glb'}", &script), KD_SCRIPT);
    assert_int_equal(fixture_errors, 1);
    assert_non_null(strstr(fixture_message, "scene.lua:2: "));
    assert_non_null(strstr(fixture_message, "is broken; repair it"));
    assert_int_equal(fixture_load(w, "assert(not pcall(kandil.spawn, {model = 'broken.glb'}))", &script),
                     KD_OK);
    assert_int_equal(fixture_errors, 0);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void events_fire_once_in_order_of_time(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    assert_int_equal(
        fixture_load(
            w,
            "log = ''\n"
            "kandil.at(0.1, function(t) log = log .. 'b' end) kandil.at(0, function() log = log .. 'a' end)\n"
            "kandil.at(0.1, function() log = log .. 'c' kandil.at(0.1, function() log = log .. 'd' end) "
            "end)\n"
            "function kandil.update(t, dt) log = log .. '|' print(log, t, dt) end\n",
            &script),
        KD_OK);
    /* With 30 steps a second 0.1 s is step 3, although 3/30 is not exactly 0.1. */
    static const char *const logs[] = {"a| ", "a|| ", "a||| ", "a|||bcd| "};
    for (int i = 0; i < 4; i++) {
        assert_int_equal(kd_script_step(script, i / 30.0, 1 / 30.0), KD_OK);
        assert_non_null(strstr(fixture_said, logs[i]));
    }
    kd_script_destroy(script);
    assert_int_equal(
        fixture_load(w, "function kandil.update(t)\n if t > 0 then error('late') end end", &script), KD_OK);
    assert_int_equal(kd_script_step(script, 0, 1), KD_OK);
    assert_int_equal(kd_script_step(script, 1, 1), KD_SCRIPT);
    assert_non_null(strstr(fixture_message, "scene.lua:2: late"));
    kd_script_destroy(script);
    kd_world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spawn_sets_components_through_reflection),
        cmocka_unit_test(look_at_points_at_the_target),
        cmocka_unit_test(rotation_deg_turns_about_x_then_y_then_z),
        cmocka_unit_test(rotation_deg_stays_when_it_is_written_back),
        cmocka_unit_test(handles_read_write_and_go_stale),
        cmocka_unit_test(animations_and_materials_reach_the_host),
        cmocka_unit_test(mistakes_name_the_key),
        cmocka_unit_test(host_errors_carry_the_line_and_can_be_caught),
        cmocka_unit_test(events_fire_once_in_order_of_time),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
