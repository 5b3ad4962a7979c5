/* What a scenario cannot do: reach the system, run for ever, fill the memory, load from elsewhere. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#include <cmocka.h>

#include "tests/script_fixture.h"

static kd_status run(const char *text)
{
    kd_world *w = fixture_world();
    kd_script *script;
    kd_status status = fixture_load(w, text, &script);
    kd_script_destroy(script);
    kd_world_destroy(w);
    return status;
}

static void expect_failure(const char *text, const char *says)
{
    struct timespec from, to;
    clock_gettime(CLOCK_MONOTONIC, &from);
    kd_status status = run(text);
    clock_gettime(CLOCK_MONOTONIC, &to);
    if (status != KD_SCRIPT || fixture_errors != 1 || !strstr(fixture_message, says) ||
        !strstr(fixture_message, "; "))
        fail_msg("%s\ngave status %d, %d messages: %s", text, (int)status, fixture_errors, fixture_message);
    if (to.tv_sec - from.tv_sec > 60)
        fail_msg("%s\ntook more than a minute", text);
}

static void the_system_is_out_of_reach(void **state)
{
    (void)state;
    assert_int_equal(
        run("for _, n in ipairs{'os','io','package','debug','dofile','loadfile','collectgarbage'} "
            "do\n"
            "  if _G[n] ~= nil then error(n) end end\n"
            "assert(string.dump == nil)\n"
            "assert(not pcall(load, string.char(27) .. 'Lua'))\n" /* a function: only text is taken */
            "assert(load('\\27Lua') == nil)\n"
            "assert(load('return 1 + 1')() == 2)\n"
            "assert(getmetatable('') == 'protected')\n"
            "assert(not pcall(setmetatable, {}, {__gc = function() end}))\n"
            "assert(getmetatable(kandil) == 'protected')\n"),
        KD_SCRIPT);
    /* The third line must have failed there: pcall(load, text) succeeds and returns nil, so assert(not true)
     * raises. */
    assert_non_null(strstr(fixture_message, "scene.lua:4:"));
    assert_int_equal(
        run("assert(string.dump == nil)\n"
            "assert(load('\\27Lua') == nil)\n"
            "assert(not pcall(load, function() return 'x' end))\n"
            "assert(load('return 1 + 1')() == 2)\n"
            "assert(load('return x', 'chunk', 't', {x = 5})() == 5)\n"
            "assert(getmetatable('') == 'protected')\n"
            "assert(not pcall(setmetatable, {}, {__gc = function() end}))\n"
            "assert(getmetatable(kandil) == 'protected')\n"
            "assert(getmetatable(kandil.spawn{}) == 'protected')\n"
            "for _, n in ipairs{'os','io','package','debug','dofile','loadfile','collectgarbage'} "
            "do\n"
            "  if _G[n] ~= nil then error(n) end end\n"),
        KD_OK);
}

static void endless_work_is_stopped(void **state)
{
    (void)state;
    static const char *const scripts[] = {
        "while true do end",
        "local function f() return f() end f()",
        "while true do pcall(function() while true do end end) end",
        "coroutine.wrap(function() while true do end end)()",
        "while true do coroutine.wrap(function() for i = 1, 150 do end end)() end",
        "xpcall(function() while true do end end, function() while true do end end)",
        "coroutine.wrap(function() local x <close> = setmetatable({}, {__close = function() while true do "
        "end end}) while true do end end)()",
        "local c = coroutine.create(function() local x <close> = setmetatable({}, {__close = function() "
        "while true do end end})\n"
        "while true do end end) coroutine.resume(c) coroutine.close(c)",
        "error(setmetatable({}, {__tostring = function() while true do end end}))",
        "string.rep('a', 100000):find(('.-'):rep(12) .. 'b')",
        "string.rep('a', 100000):match(('a*'):rep(8) .. 'b')",
        "string.rep('a', 100000):gsub(('.-'):rep(8) .. 'b', '')",
        "for w in string.rep('a', 100000):gmatch(('a-'):rep(8) .. 'b') do end",
        "string.rep('a', 1000000):find(string.rep('a', 500000) .. 'b', 1, true)",
        "string.rep(string.rep('(', 1000000), 1):match(('%b()'):rep(1) .. 'x')",
        "local t = setmetatable({}, {__index = function(t, k) return k end}) local i = 0 while t[i] do i = i "
        "+ 1 end",
        "table.sort({3, 2, 1}, function() while true do end end)",
        "repeat local x <close> = setmetatable({}, {__close = function() while true do end end}) until false",
        "while true do local s = ('x'):rep(1000000) end",
        "while true do kandil.spawn{} end",
        "local function again() kandil.at(0, again) end while true do again() end",
    };
    for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++)
        expect_failure(scripts[i], "scene.lua");
    expect_failure("local a = 1\nwhile true do a = a + 1 end", "scene.lua:2: ran for too long");
}

static void loops_inside_one_library_call_are_refused(void **state)
{
    (void)state;
    expect_failure("table.move({}, 1, 1 << 53, 2)", "out of range");
    expect_failure("table.insert(setmetatable({}, {__len = function() return 1 << 53 end}), 1, 1)",
                   "too long");
    expect_failure("table.sort(setmetatable({}, {__len = function() return (1 << 31) - 2 end}), rawequal)",
                   "too long");
    expect_failure("table.concat(setmetatable({}, {__index = rawlen}), '', 1, 1 << 40)", "out of range");
    assert_int_equal(run("assert(string.rep('', 1 << 62) == '')"), KD_OK);
}

/* Each line holds more work than the limit in few instructions. */
static void work_inside_library_calls_is_charged(void **state)
{
    (void)state;
    static const char *const scripts[] = {
        "local t = {} for i = 1, 200000 do t[i] = i * 7919 % 200003 end table.sort(t, math.ult)",
        "local t = {} for i = 1, 200000 do t[i] = i * 7919 % 200003 end table.sort(t)",
        "local u = setmetatable({}, {__index = table.concat}) for i = 1, 3 do table.concat(u, '', 1, "
        "1000000) "
        "end",
        "local u = setmetatable({}, {__index = rawlen, __newindex = rawequal})\n"
        "for i = 1, 3 do table.move(u, 1, 1000000, 1, u) end",
        "local u = setmetatable({}, {__index = rawlen}) for i = 1, 30 do table.unpack(u, 1, 100000) end",
        "local u = setmetatable({}, {__len = function() return 1000000 end, __newindex = rawequal})\n"
        "for i = 1, 3 do table.insert(u, 1, 1) end",
        "local u = setmetatable({}, {__len = function() return 1000000 end, __newindex = rawequal})\n"
        "for i = 1, 3 do table.remove(u, 1) end",
        "local s = (' '):rep(4000000) for i = 1, 20 do tonumber(s) end",
        "local s = (' '):rep(4000000) for i = 1, 400 do pcall(function() return s + 1 end) end",
        "local s = ('a'):rep(4000000) for i = 1, 20 do utf8.len(s) end",
        "local s = ('a'):rep(4000000) for i = 1, 20 do utf8.offset(s, 4000000) end",
        "local s = ('a'):rep(4000000) for i = 1, 400 do pcall(utf8.codepoint, s, 1, -1) end",
        "local s = 'a' .. ('\\128'):rep(4000000) local f = utf8.codes(s) for i = 1, 400 do pcall(f, s, 1) "
        "end",
    };
    for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++)
        expect_failure(scripts[i], "ran for too long");
}

/* The table library is our own: each from the reference manual, section 6.6. */
static void lists_change_as_the_manual_says(void **state)
{
    (void)state;
    assert_int_equal(
        run("local function is(t, says) local s = table.concat(t, ' ') if s ~= says then error(s, 2) end "
            "end\n"
            "local t = {1, 2, 3} table.insert(t, 4) is(t, '1 2 3 4') table.insert(t, 1, 0) is(t, '0 1 2 3 "
            "4')\n"
            "table.insert(t, 3, 9) is(t, '0 1 9 2 3 4') table.insert(t, 7, 5) is(t, '0 1 9 2 3 4 5')\n"
            "assert(not pcall(table.insert, t, 9, 1) and not pcall(table.insert, t, 0, 1) and not "
            "pcall(table.insert, t) and not pcall(table.insert, nil, 1))\n"
            "assert(table.remove(t) == 5 and table.remove(t, 3) == 9 and table.remove(t, 1) == 0) is(t, '1 2 "
            "3 "
            "4')\n"
            "assert(table.remove(t, 5) == nil and not pcall(table.remove, t, 6)) assert(#t == 4)\n"
            "assert(table.remove({}) == nil and table.remove({[0] = 7}, 0) == 7)\n"
            "is(table.move({1, 2, 3}, 1, 3, 2), '1 1 2 3') is(table.move({1, 2, 3}, 2, 3, 1), '2 3 3')\n"
            "is(table.move({1, 2, 3}, 1, 3, 2, {9}), '9 1 2 3') assert(not pcall(table.move, {}, 1))\n"
            "assert(table.concat({1, 'b', 2.5}, ', ') == '1, b, 2.5' and table.concat({}) == '')\n"
            "assert(table.concat({1, 2, 3, 4}, '-', 2, 3) == '2-3' and not pcall(table.concat, {{}}))\n"
            "assert(select('#', table.unpack({1, nil, 3}, 1, 3)) == 3 and table.unpack({5, 6}, 2) == 6)\n"
            "assert(select('#', table.unpack({}, 2, 1)) == 0)\n"
            "t = {3, 1, 2} table.sort(t) is(t, '1 2 3') table.sort(t, function(a, b) return a > b end) is(t, "
            "'3 2 1')\n"
            "t = {'b', 'a'} table.sort(t) is(t, 'a b') assert(not pcall(table.sort, {1, 'x'}) and not "
            "pcall(table.sort, t, 5))\n"
            "local codes = {} for _, c in utf8.codes('a\\u{e9}\\u{20ac}') do codes[#codes + 1] = c end\n"
            "is(codes, '97 233 8364')\n"
            "assert(utf8.len('a\\u{e9}b') == 3 and utf8.len('a\\u{e9}b', 2, -2) == 1 and utf8.len('') == 0)\n"
            "assert(utf8.codepoint('a\\u{e9}b', -1) == 98 and select('#', utf8.codepoint('abc', 1, -1)) == "
            "3)\n"
            "assert(utf8.offset('a\\u{e9}b', 3) == 4 and utf8.offset('a\\u{e9}b', -1) == 4 and "
            "utf8.offset('a', 5) == nil)\n"
            "local long, sum = ('ab'):rep(20000), 0\n" /* a look at a part costs what the part does */
            "for i = 1, 20000 do sum = sum + long:byte(i) + #long:sub(i, i) + utf8.offset(long, 2, i) + "
            "utf8.codepoint(long, i) end\n"
            "assert('10' + 5 == 15 and -'2' == -2 and tonumber('ff', 16) == 255 and tonumber('x') == nil)\n"),
        KD_OK);
}

static void copies_are_charged_by_their_entities(void **state)
{
    (void)state;
    expect_failure("local top = kandil.spawn{} for i = 1, 1000 do kandil.spawn{parent = top} end\n"
                   "for i = 1, 30 do top:clone():destroy() end",
                   "scene.lua:2: ran for too long");
}

/* The limit is 1 s; what is "slow" takes longer, what is "tired" fails after 5 ms. */
static void only_reading_a_file_first_puts_off_the_end(void **state)
{
    (void)state;
    fixture_time_limit_s = 1;
    fixture_write("slow.glb", "x", 1);
    fixture_write("tired.glb", "x", 1);
    assert_int_equal(run("kandil.spawn{model = 'slow.glb'}"), KD_OK);
    expect_failure("for i = 1, 2 do kandil.spawn{model = 'slow.glb'} end", "ran for too long");
    fixture_spawns = 0;
    expect_failure("while true do pcall(kandil.spawn, {model = 'tired.glb'}) end", "ran for too long");
    assert_in_range(fixture_spawns, 1, 201);
    fixture_time_limit_s = 0;
}

static void wait_and_collect(void *user, kd_log_level level, const char *text)
{
    nanosleep(&(struct timespec){.tv_nsec = 600000000}, NULL);
    fixture_sink(user, level, text);
}

/* The limit is half a second; nobody gives the script a processor for longer. Two loops later it would have
 * failed by the clock of the wall. */
static void time_without_a_processor_does_not_count(void **state)
{
    (void)state;
    fixture_time_limit_s = 0.5;
    kd_log_set_sink(wait_and_collect, NULL);
    kd_status status = run("print('x') local sum = 0 for i = 1, 2000 do sum = sum + i end");
    kd_log_set_sink(fixture_sink, NULL);
    fixture_time_limit_s = 0;
    assert_int_equal(status, KD_OK);
}

static void memory_is_bounded(void **state)
{
    (void)state;
    /* in few steps: the time that a call may take is bounded too */
    expect_failure("local t, line = {}, ('x'):rep(1000) while true do t[#t + 1] = line:rep(8000) .. #t end",
                   "MiB of memory");
    expect_failure("local s = 'x' while true do s = s .. s end", "MiB of memory");
    expect_failure("string.rep('x', 1 << 40)", "scene.lua");
    expect_failure("local function f(...) return f(1, ...) end f()", "scene.lua");
}

static void errors_name_the_line(void **state)
{
    (void)state;
    expect_failure("local x = 1\nlocal y = = 2\n", "/scene.lua:2: unexpected symbol near '='; ");
    expect_failure("\n\nlocal x = nothing.here", "/scene.lua:3: attempt to index a nil value");
    expect_failure("\nerror('no room')", "/scene.lua:2: no room; ");
    expect_failure("error({code = 5})", "/scene.lua");
    expect_failure("error(setmetatable({}, {__tostring = function() return 'custom' end}))",
                   "/scene.lua:1: custom");
    expect_failure("error('two\\nlines\\27[31m')", "two lines [31m");
    expect_failure("error(nil)", "/scene.lua");
    expect_failure("\27Lua", "/scene.lua");
    expect_failure("x = ", "/scene.lua:1:");
}

static void files_stay_below_the_scenario(void **state)
{
    (void)state;
    char path[128];
    fixture_write("room.glb", "x", 1);
    assert_int_equal(run("kandil.spawn{model = 'room.glb'}"), KD_OK);
    snprintf(path, sizeof path, "%s/room.glb", fixture_folder);
    assert_string_equal(fixture_model, path);
    expect_failure("kandil.spawn{model = '/etc/passwd'}", "outside the scenario's folder");
    expect_failure("kandil.spawn{model = '../../etc/passwd'}", "outside the scenario's folder");
    expect_failure("kandil.spawn{model = 'sub/../../x'}", "outside the scenario's folder");
    expect_failure("kandil.spawn{model = 'missing.glb'}", "not found");
    expect_failure("kandil.spawn{model = 'a\\0b'}", "zero byte");
    snprintf(path, sizeof path, "%s/link.glb", fixture_folder);
    assert_int_equal(symlink("/etc/passwd", path), 0);
    expect_failure("kandil.spawn{model = 'link.glb'}", "outside the scenario's folder");
}

/* A link beside the scenario may lead into an asset root, and nowhere else. */
static void links_may_lead_into_a_root(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        kd_status status;
    } rows[] = {{"kandil.spawn{model = 'models/room.glb'}", KD_OK},
                {"kandil.spawn{model = '../far/room.glb'}", KD_SCRIPT},
                {"kandil.spawn{model = 'far/room.glb'}", KD_SCRIPT}};
    char path[128], root[128], link[128];
    snprintf(path, sizeof path, "%s/work", fixture_folder);
    assert_int_equal(mkdir(path, 0700), 0);
    snprintf(root, sizeof root, "%s/given", fixture_folder);
    assert_int_equal(mkdir(root, 0700), 0);
    snprintf(path, sizeof path, "%s/far", fixture_folder);
    assert_int_equal(mkdir(path, 0700), 0);
    snprintf(link, sizeof link, "%s/work/far", fixture_folder);
    assert_int_equal(symlink(path, link), 0);
    snprintf(link, sizeof link, "%s/work/models", fixture_folder);
    assert_int_equal(symlink(root, link), 0);
    fixture_write("given/room.glb", "x", 1);
    fixture_write("far/room.glb", "x", 1);
    snprintf(path, sizeof path, "%s/work/scene.lua", fixture_folder);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        kd_world *w = fixture_world();
        kd_script *script = NULL;
        const char *const roots[] = {root};
        fixture_write("work/scene.lua", rows[i].text, strlen(rows[i].text));
        fixture_message[0] = '\0';
        kd_status status = kd_script_load(&(kd_script_desc){.path = path,
                                                            .roots = roots,
                                                            .root_count = 1,
                                                            .world = w,
                                                            .host = {.user = w, .spawn = fixture_spawn}},
                                          &script);
        if (status != rows[i].status || (status && !strstr(fixture_message, "outside")))
            fail_msg("%s\ngave status %d: %s", rows[i].text, (int)status, fixture_message);
        kd_script_destroy(script);
        kd_world_destroy(w);
    }
}

/* What a terminal would obey is written out, and no line passes for one of the program's own. */
static void printed_text_cannot_steer_a_terminal(void **state)
{
    (void)state;
    assert_int_equal(run("kandil.log('a\\27[2J\\r\\0b\\127\\tc\\nkandil: broken', '\\u{9b}1m \\u{e9}')"),
                     KD_OK);
    assert_non_null(
        strstr(fixture_said, ": a\\x1b[2J\\x0d\\x00b\\x7f\tc\n    kandil: broken \\xc2\\x9b1m \xc3\xa9"));
    assert_int_equal(run("print('x\\8y')"), KD_OK);
    assert_non_null(strstr(fixture_said, ": x\\x08y"));
}

static void text_holds_no_addresses(void **state)
{
    (void)state;
    assert_int_equal(run("local t, f = {}, function() end\n"
                         "print(t, f, t, print, coroutine.create(f), kandil.spawn{}.transform, 7, nil)\n"
                         "assert(tostring(t) == 'table: 1' and string.format('%5.1f%%%-9s|', 1.25, t) == "
                         "'  1.2%table: 1 |')\n"
                         "assert(('%s %s %d'):format(f, setmetatable({}, {__tostring = function() return 'x' "
                         "end}), 3) == 'function: 2 x 3')\n"
                         "assert(tostring(setmetatable({}, {__name = 'thing'})):match('^thing: %d$'))\n"
                         "assert(tostring(setmetatable({}, {__name = 5})):match('^table: %d$'))\n"
                         "assert(tostring(1) == '1' and tostring('a') == 'a' and tostring(nil) == 'nil')\n"
                         "assert(not pcall(tostring) and not pcall(string.format, '%s'))\n"
                         "local first = tostring(t) for i = 1, 30000 do local _ = tostring({}) end\n"
                         "assert(tostring(t) == first)"),
                     KD_OK);
    assert_non_null(strstr(fixture_said, "table: 1 function: 2 table: 1 function: 3 thread: 4 "));
    assert_null(strstr(fixture_said, "0x"));
    expect_failure("print(string.format('%p', {}))", "%p is not available");
    expect_failure("print(string.format('%-20p', {}))", "%p is not available");
}

static void chance_and_order_are_the_same_every_time(void **state)
{
    (void)state;
    char first[2048];
    const char *text =
        "local s = {} for i = 1, 40 do s['key' .. i] = i end local o = {}\n"
        "for k in pairs(s) do o[#o + 1] = k end print(math.random(1000000), table.concat(o, ' '))";
    assert_int_equal(run(text), KD_OK);
    strcpy(first, fixture_said);
    assert_non_null(strstr(first, "key1 key10 key11"));
    for (int i = 0; i < 3; i++) {
        assert_int_equal(run(text), KD_OK);
        assert_string_equal(strchr(fixture_said, ' '), strchr(first, ' '));
    }
    expect_failure("math.randomseed()", "scene.lua");
}

/* The matcher is our own: the manual's examples and corner cases, each derived from the reference manual,
 * section 6.4. */
static void patterns_match_as_the_manual_says(void **state)
{
    (void)state;
    assert_int_equal(
        run("local function eq(a, b) if a ~= b then error(tostring(a) .. ' is not ' .. tostring(b), 2) end "
            "end\n"
            "local i, j = ('hello world'):find('o w') eq(i, 5) eq(j, 7)\n"
            "eq(('hello'):find('l'), 3) eq(('hello'):find('l', 4), 4) eq(('hello'):find('l', -1), nil) "
            "eq(('hello'):find(''), 1)\n"
            "eq(('a.b'):find('.', 1, true), 2) eq(('a+b'):find('+', 1, true), 2) eq(('abc'):find('', 10), "
            "nil) eq(('abc'):find('', 4), 4)\n"
            "eq(('key = value'):match('^(%w+)%s*=%s*(%w+)$'), 'key') eq(select(2, ('key = "
            "value'):match('^(%w+)%s*=%s*(%w+)$')), 'value')\n"
            "eq(('  x  '):match('^%s*(.-)%s*$'), 'x') eq(('[[x]]'):match('%[%[(.-)%]%]'), 'x') "
            "eq(('2024-05'):match('%d+', 5), '05')\n"
            "eq(('f(a(b)c)d'):match('%b()'), '(a(b)c)') eq(('THE (quick) fox'):find('%((%a+)%)'), 5)\n"
            "eq(('hello'):match('()ll()'), 3) eq(select(2, ('hello'):match('()ll()')), 5)\n"
            "eq(('aXb'):match('[^%l]'), 'X') eq(('a]b'):match('[]]'), ']') eq(('a-b'):match('[a%-]+'), 'a-') "
            "eq(('x^'):match('[x^]+'), 'x^')\n"
            "eq(('abab'):match('(ab)%1'), 'ab') eq(('\"q\\'q\"'):match('([\"\\'])(.-)%1'), '\"')\n"
            "eq(('THE (quick) fox'):gsub('%f[%a]%a+', 'w'), 'w (w) w') eq(('a,b,,c'):gsub(',', ';'), "
            "'a;b;;c')\n"
            "eq(('hello world'):gsub('o', '0', 1), 'hell0 world') eq(select(2, ('aaa'):gsub('a', 'b')), 3) "
            "eq(('abc'):gsub('', '-'), '-a-b-c-')\n"
            "eq(('hello'):gsub('(l)(l)', '%2%1%0'), 'hellllo') eq(('abc'):gsub('%w', '%0%0'), 'aabbcc') "
            "eq(('abc'):gsub('b', {b = 'x'}), 'axc')\n"
            "eq(('abc'):gsub('%w', function(c) return c == 'b' and 'B' or nil end), 'aBc') "
            "eq(('x'):gsub('x', '%%'), '%')\n"
            "local t = {} for k, v in ('a=1, b=2'):gmatch('(%w+)=(%w+)') do t[#t + 1] = k .. v end "
            "eq(table.concat(t, ','), 'a1,b2')\n"
            "local n = 0 for w in ('one two'):gmatch('%a*') do n = n + 1 end eq(n, 3 - 1)\n"
            "eq(('abc'):match('a?b?c?d?'), 'abc') eq(('aaab'):match('a-b'), 'aaab') eq(('aaa'):match('a+'), "
            "'aaa') eq(('$5'):match('$%d'), '$5')\n"
            "eq(pcall(string.match, 'a', '['), false) eq(pcall(string.match, 'a', '%'), false) "
            "eq(pcall(string.match, 'a', '(a'), false)\n"
            "eq(pcall(string.match, 'a', 'a)'), false) eq(pcall(string.match, 'a', '%1'), false) "
            "eq(pcall(string.gsub, 'a', 'a', '%9'), false)\n"),
        KD_OK);
}

/* A log that fills the disk is as good as a loop without end: 50 million instructions at 16 a byte. */
static void a_step_cannot_flood_the_log(void **state)
{
    (void)state;
    fixture_infos = 0;
    expect_failure("for i = 1, 1e9 do kandil.log(('x'):rep(1000)) end", "ran for too long");
    assert_in_range(fixture_infos, 100, 50000000 / 16000);
}

static bool say_stop(void *user)
{
    (void)user;
    return true;
}

/* Whoever catches every error cannot hold the program either. */
static void a_host_that_stops_ends_it_without_a_message(void **state)
{
    (void)state;
    fixture_stopped = say_stop;
    assert_int_equal(run("while true do pcall(function() while true do end end) end"), KD_INTERRUPTED);
    assert_int_equal(fixture_errors, 0);
    fixture_stopped = NULL;
    assert_int_equal(run("local sum = 0 for i = 1, 1000 do sum = sum + i end"), KD_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_cannot_flood_the_log),
        cmocka_unit_test(a_host_that_stops_ends_it_without_a_message),
        cmocka_unit_test(the_system_is_out_of_reach),
        cmocka_unit_test(endless_work_is_stopped),
        cmocka_unit_test(loops_inside_one_library_call_are_refused),
        cmocka_unit_test(work_inside_library_calls_is_charged),
        cmocka_unit_test(lists_change_as_the_manual_says),
        cmocka_unit_test(copies_are_charged_by_their_entities),
        cmocka_unit_test(only_reading_a_file_first_puts_off_the_end),
        cmocka_unit_test(time_without_a_processor_does_not_count),
        cmocka_unit_test(memory_is_bounded),
        cmocka_unit_test(errors_name_the_line),
        cmocka_unit_test(files_stay_below_the_scenario),
        cmocka_unit_test(links_may_lead_into_a_root),
        cmocka_unit_test(printed_text_cannot_steer_a_terminal),
        cmocka_unit_test(text_holds_no_addresses),
        cmocka_unit_test(chance_and_order_are_the_same_every_time),
        cmocka_unit_test(patterns_match_as_the_manual_says),
    };
    return cmocka_run_group_tests(tests, fixture_open, fixture_close);
}
