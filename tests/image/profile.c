/* A profile of a real run accounts for all of each frame: on the GPU lane and on the GPU what lies inside a
 * frame adds up to it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include <cmocka.h>

#include "tests/folder_fixture.h"

#include "tests/pftrace.h"

#define SCENE  KD_SOURCE_DIR "/samples/02_timeline.lua"
#define FRAMES 6

/* Length of the zones of one name on a track, and of those directly inside them. */
static double share_inside(const pf_trace *t, const char *name, uint32_t depth)
{
    double whole = 0, inside = 0;
    for (size_t i = 0; i < t->zone_count; i++) {
        const pf_zone *z = &t->zones[i];
        if (z->depth != depth || strcmp(z->name, name) != 0)
            continue;
        whole += (double)(z->end_ns - z->start_ns);
        for (size_t k = i + 1; k < t->zone_count && t->zones[k].depth > depth; k++)
            if (t->zones[k].depth == depth + 1)
                inside += (double)(t->zones[k].end_ns - t->zones[k].start_ns);
    }
    return whole > 0 ? inside / whole : 0;
}

static size_t count_zones(const pf_trace *t, const char *name)
{
    size_t count = 0;
    for (size_t i = 0; i < t->zone_count; i++)
        count += strcmp(t->zones[i].name, name) == 0;
    return count;
}

static void run(const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof command,
             "'%s/kandil' run '%s' --size 160x90 --frames %d --threads 2 %s > out 2>&1", KD_BINARY_DIR, SCENE,
             FRAMES, arguments);
    assert_int_equal(system(command), 0);
}

static void zones_add_up_to_their_frames(void **state)
{
    (void)state;
    run("--profile a.pftrace --profile a.json");
    pf_trace t = pf_decode("a.pftrace");
    if (t.mistake)
        fail_msg("%s", t.mistake);
    assert_int_equal(count_zones(&t, "frame"), FRAMES);
    assert_int_equal(count_zones(&t, "gpu_frame"), FRAMES);
    assert_int_equal(count_zones(&t, "scenario"), FRAMES);
    assert_int_equal(count_zones(&t, "animation"), FRAMES);
    /* Both on the CPU that records and on the GPU that runs. */
    assert_int_equal(count_zones(&t, "svo_build"), 2 * FRAMES);
    double cpu = share_inside(&t, "frame", 0), gpu = share_inside(&t, "gpu_frame", 0);
    if (!(cpu > 0.98 && cpu < 1.02 && gpu > 0.98 && gpu < 1.02))
        fail_msg("systems are %.4f of the CPU's frame, passes %.4f of the GPU's", cpu, gpu);
    assert_true(t.value_count >= FRAMES);
    free(t.zones);
}

/* How often a counter stands in the timeline, with a value above 0. */
static int count_values(const char *path, const char *name)
{
    static char line[65536];
    char wanted[64];
    int count = 0;
    FILE *file = fopen(path, "rb");
    snprintf(wanted, sizeof wanted, "\"name\":\"%s\",\"ph\":\"C\"", name);
    while (file && fgets(line, sizeof line, file))
        for (const char *at = line; (at = strstr(at, wanted)) != NULL; at++) {
            const char *value = strstr(at, "\"value\":");
            count += value && strtod(value + strlen("\"value\":"), NULL) > 0;
        }
    if (file)
        fclose(file);
    return count;
}

static void memory_is_counted_every_frame(void **state)
{
    (void)state;
    run("--profile b.json");
    assert_int_equal(count_values("b.json", "heap bytes"), FRAMES);
    assert_int_equal(count_values("b.json", "world bytes"), FRAMES);
    /* The first frame makes what lasts; what stands still takes nothing more. */
    int taking = count_values("b.json", "allocations");
    assert_in_range(taking, 1, FRAMES - 1);
    assert_int_equal(count_values("b.json", "allocated bytes"), taking);
}

static void a_run_is_compared_with_an_earlier_one(void **state)
{
    char text[256] = "";
    (void)state;
    run("--compare-profile a.json");
    FILE *file = fopen("out", "rb");
    bool found = false;
    while (file && fgets(text, sizeof text, file))
        found = found || strncmp(text, "compared with a.json", 20) == 0;
    if (file)
        fclose(file);
    assert_true(found);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(zones_add_up_to_their_frames),
        cmocka_unit_test(memory_is_counted_every_frame),
        cmocka_unit_test(a_run_is_compared_with_an_earlier_one),
    };
    return cmocka_run_group_tests(tests, open_folder, close_folder);
}
