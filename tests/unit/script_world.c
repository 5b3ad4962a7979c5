/* What a scenario does with a world: queries, hierarchy, copies, whole components, singletons. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/script_fixture.h"

static void expect(const char *text, kd_status status, const char *says)
{
    kd_world *w = fixture_world();
    kd_script *script;
    kd_status got = fixture_load(w, text, &script);
    if (got != status || (says && !strstr(fixture_message, says)))
        fail_msg("%s\ngave status %d: %s", text, (int)got, fixture_message);
    kd_script_destroy(script);
    kd_world_destroy(w);
}

static void queries_walk_what_matches(void **state)
{
    (void)state;
    expect(
        "for i = 1, 9 do kandil.spawn{name = 'e' .. i, light = i % 3 == 0 and {intensity = i} or nil} end\n"
        "local names = {} for e, l in kandil.query('light') do names[#names + 1] = e.name .. l.intensity "
        "end\n"
        "assert(table.concat(names, ' ') == 'e33.0 e66.0 e99.0')\n"
        "local n = 0 for e, t, l in kandil.query('transform', '?light', '!animation') do n = n + 1\n"
        "  assert(t.scale[1] == 1 and (l == nil) == not e:has('light')) end assert(n == 9)\n"
        "n = 0 for e in kandil.query('transform', '!light') do n = n + 1 e:destroy() end assert(n == 6)\n"
        "n = 0 for e in kandil.query('transform') do n = n + 1 kandil.spawn{light = {}} end assert(n == 3)\n"
        /* what a walk destroys ahead of itself is not met */
        "n = 0 for e in kandil.query('light') do n = n + 1\n"
        "  for other in kandil.query('light') do if other ~= e then other:destroy() end end end assert(n == "
        "1)",
        KD_OK, NULL);
    expect("kandil.query('ligt')", KD_SCRIPT, "did you mean 'light'?");
    expect("kandil.query()", KD_SCRIPT, "from 1 to 16");
}

static void handles_are_keys_of_tables(void **state)
{
    (void)state;
    expect("local e = kandil.spawn{name = 'e'} local t = {[e] = 5}\n"
           "assert(t[kandil.find('e')] == 5) for q in kandil.query('transform') do assert(t[q] == 5) end\n"
           "assert(rawequal(e, kandil.find('e')) and kandil.find('nobody') == nil)",
           KD_OK, NULL);
}

static void entities_hang_below_others(void **state)
{
    (void)state;
    expect("local a, b = kandil.spawn{name = 'a'}, kandil.spawn{name = 'b'} assert(a.parent == nil)\n"
           "b.parent = a assert(b.parent == a and a:children()[1] == b and #a:children() == 1)\n"
           "local c = kandil.spawn{parent = b} assert(a:child('b') == b)\n"
           "assert(not pcall(function() a.parent = c end)) b.parent = nil assert(b.parent == nil and "
           "#a:children() == 0)",
           KD_OK, NULL);
    expect("kandil.spawn{}.parent = 5", KD_SCRIPT, "entity or nil");
}

static void a_copy_is_its_own(void **state)
{
    (void)state;
    expect(
        "local a = kandil.spawn{name = 'a', light = {intensity = 7}} kandil.spawn{name = 'c', parent = a}\n"
        "local b = a:clone{name = 'b', transform = {position = {1, 2, 3}}}\n"
        "assert(b.name == 'b' and b.light.intensity == 7 and b:child('c') ~= a:child('c'))\n"
        "assert(b.transform.position[2] == 2 and a.transform.position[2] == 0 and b.parent == a.parent)\n"
        "b.light.intensity = 8 assert(a.light.intensity == 7) assert(a:clone().name == 'a')\n"
        "local d = b:clone{parent = a} assert(d.parent == a and d.light.intensity == 8)\n"
        "assert(not pcall(a.clone, a, {parent = a:child('c')}))",
        KD_OK, NULL);
    expect("kandil.spawn{}:clone{modle = 1}", KD_SCRIPT, "clone: unknown key 'modle'; did you mean 'model'?");
}

static void whole_components_come_and_go(void **state)
{
    (void)state;
    expect("local e = kandil.spawn{} assert(not e:has('light')) e.light = {intensity = 5} "
           "assert(e.light.intensity == 5)\n"
           "e.light = {type = 'spot'} assert(e.light.intensity == 5 and e.light.type == 'spot')\n"
           "assert(table.concat(e:components(), ' ') == 'transform light part')\n"
           "e.light = nil assert(not e:has('light') and not pcall(function() e.transform = nil end))\n"
           "assert(not pcall(function() e.part = nil end) and e:has('part'))\n"
           "e.part = {hidden = true} assert(e.part.hidden)\n"
           "e:look_at{5, 0, 0} assert(math.abs(e.transform.rotation_deg[2] + 90) < 1e-3)\n"
           "e:look_at(kandil.spawn{transform = {position = {-3, 0, 0}}}) "
           "assert(math.abs(e.transform.rotation_deg[2] - 90) < 1e-3)\n"
           "e:set('transform.position.y', 4) assert(e:get('transform.position.y') == 4)",
           KD_OK, NULL);
    expect("kandil.spawn{}.lihgt = {}", KD_SCRIPT, "has no 'lihgt'");
    expect("local e = kandil.spawn{name = 'bare'} e.part = {hidden = true}", KD_SCRIPT,
           "has no 'part' itself");
    expect("kandil.spawn{}:enable('transform', false)", KD_SCRIPT, "cannot be switched off");
    expect("local e = kandil.spawn{} e.transform.look_at = 5", KD_SCRIPT, "list of 3 numbers");
    expect("local e = kandil.spawn{} print(e.transform.look_at)", KD_SCRIPT, "can be set only");
}

/* A looker and a target below parents that move, turn and scale: -z, carried to the world, leads to it. */
static void looking_crosses_the_hierarchy(void **state)
{
    (void)state;
    const char *text =
        "local function near(e, x, z) local q = e.transform.rotation\n" /* where -z points, below its parent
                                                                         */
        "  local fx, fz = -2 * (q[1] * q[3] + q[4] * q[2]), 2 * (q[1] * q[1] + q[2] * q[2]) - 1\n"
        "  local length = math.sqrt(x * x + z * z)\n"
        "  if math.abs(fx - x / length) + math.abs(fz - z / length) > 1e-4 then\n"
        "    error(fx .. ' ' .. fz, 2) end end\n"
        "local cart = kandil.spawn{transform = {position = {0, 0, 10}, rotation_deg = {0, 90, 0}, scale = "
        "{2, "
        "2, 2}}}\n"
        "local arm = kandil.spawn{parent = cart, transform = {position = {0, 0, 5}}}\n"   /* at 10, 0, 10 */
        "local tip = kandil.spawn{parent = arm, transform = {position = {-5, 0, -10}}}\n" /* at -10, 0, 20 */
        "local free = kandil.spawn{} free:look_at(arm) near(free, 1, 1)\n"
        "free:look_at(tip) near(free, -1, 2)\n"
        "local post = kandil.spawn{transform = {position = {10, 0, 0}}}\n"
        /* seen from arm, post is 10 along the world's -z, which is the cart's +x */
        "arm:look_at(post) near(arm, 1, 0)\n"
        "arm.transform.rotation_deg = {0, 0, 0} tip:look_at(cart) near(tip, 1, 1)\n"
        "arm:look_at(cart) near(arm, 0, -1)\n"
        "local eye = kandil.spawn{parent = cart, transform = {look_at = arm}} near(eye, 0, 1)\n"
        "eye = kandil.spawn{transform = {look_at = arm, position = {10, 0, 0}}} near(eye, 0, 1)\n"
        "eye.transform.look_at = cart near(eye, -1, 1)\n"
        "eye = eye:clone{parent = cart, transform = {position = {0, 0, 0}, look_at = post}} near(eye, 1, "
        "1)\n"
        "kandil.tween(eye, 'transform.look_at', arm, 0)\n"
        /* nothing is seen from what is scaled to nothing: it stays as it is */
        "cart.transform.scale = {0, 0, 0} eye:look_at(post) near(eye, 1, 1)";
    expect(text, KD_OK, NULL);
    expect("local e, f = kandil.spawn{}, kandil.spawn{} f:destroy() e:look_at(f)", KD_SCRIPT, "destroyed");
}

static void singletons_are_read(void **state)
{
    (void)state;
    kd_world *w = fixture_world();
    kd_script *script;
    fixture_light *light = kd_singleton_ensure(w, &fixture_light_desc);
    light->intensity = 9;
    assert_int_equal(fixture_load(w, "assert(kandil.get('light.intensity') == 9)", &script), KD_OK);
    kd_script_destroy(script);
    kd_world_destroy(w);
    expect("kandil.get('light.intensity')", KD_SCRIPT, "keeps no light");
    expect("kandil.get('intensity')", KD_SCRIPT, "such as frame.dt_s");
    expect("kandil.get('lihgt.intensity')", KD_SCRIPT, "did you mean 'light'?");
}

/* A table's order must not depend on hashes: 40 objects of each kind, put in in another order than they were
 * made. */
static void order_of_keys_is_that_of_making(void **state)
{
    (void)state;
    const char *text =
        "local made, index = {}, {}\n"
        "local function add(v) made[#made + 1] = v index[v] = #made end\n"
        "for i = 1, 40 do add({}) add(function() return i end) add(coroutine.create(print)) "
        "add(kandil.run(print, i)) end\n"
        "local t = {} for i = #made, 1, -1 do t[made[i]] = i end\n"
        "for i = 1, 5 do t[i] = i t[i + 0.5] = i t['s' .. i] = i end t[true] = 1 t[false] = 0\n"
        "local e = {} for i = 1, 9 do e[i] = kandil.spawn{} end for i = 9, 1, -1 do t[e[i]] = i end\n"
        "local order, last = {}, 0\n"
        "for k in pairs(t) do order[#order + 1] = k end\n"
        "assert(order[1] == 1 and order[2] == 1.5 and order[10] == 5.5 and order[11] == 's1' and order[16] "
        "== false)\n"
        "for i = 1, 9 do assert(order[17 + i] == e[i]) end\n"
        "for i = 27, #order do assert(index[order[i]] > last) last = index[order[i]] end assert(#order == 26 "
        "+ 160)\n"
        "local n, k = 0, next(t) while k ~= nil do n = n + 1 assert(order[n] == k) k = next(t, k) end "
        "assert(n == #order)\n"
        /* removing while walking is allowed */
        "n = 0 for k in pairs(t) do t[k] = nil n = n + 1 end assert(n == #order and next(t) == nil)\n"
        "t = {a = 1, b = 2, c = 3} k = next(t) while k do t[k] = nil k = next(t, k) end assert(next(t) == "
        "nil)\n"
        "t = {1, 2, 3, 4} for k in pairs(t) do t[k + 1] = nil end assert(t[1] and not t[2] and t[3])\n"
        "t = {[print] = 1, [pairs] = 2, [math.sin] = 3} n = 0 for _ in pairs(t) do n = n + 1 end assert(n == "
        "3)\n"
        "assert(next({}) == nil and select('#', next({})) == 1 and not pcall(next))";
    for (int i = 0; i < 3; i++)
        expect(text, KD_OK, NULL);
    expect("setmetatable({}, {__mode = 'k'})", KD_SCRIPT, "weak tables");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(queries_walk_what_matches),    cmocka_unit_test(handles_are_keys_of_tables),
        cmocka_unit_test(entities_hang_below_others),   cmocka_unit_test(a_copy_is_its_own),
        cmocka_unit_test(whole_components_come_and_go), cmocka_unit_test(looking_crosses_the_hierarchy),
        cmocka_unit_test(singletons_are_read),          cmocka_unit_test(order_of_keys_is_that_of_making),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
