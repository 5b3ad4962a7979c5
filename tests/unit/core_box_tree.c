/* Every question to a tree of boxes gives what asking each box gives. */

#include "runtime/core/box_tree.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static uint64_t seed;

static float random_float(float low, float high)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (float)(seed >> 40) / (float)(1 << 24);
}

static kd_vec3 random_point(float reach)
{
    return (kd_vec3){random_float(-reach, reach), random_float(-reach, reach), random_float(-reach, reach)};
}

static kd_box random_box(float reach, float size)
{
    kd_vec3 low = random_point(reach), edge = random_point(size);
    return (kd_box){low, {low.x + fabsf(edge.x), low.y + fabsf(edge.y), low.z + fabsf(edge.z)}};
}

static void fill(kd_box_tree *t, uint32_t count)
{
    assert_int_equal(kd_box_tree_reserve(t, count), KD_OK);
    for (uint32_t i = 0; i < count; i++) {
        t->boxes[i] = random_box(100, i % 50 ? 2 : 60);
        t->still[i] = i % 3 == 0;
    }
    kd_box_tree_build(t);
}

static bool overlap(const kd_box *a, const kd_box *b)
{
    return a->low.x <= b->high.x && b->low.x <= a->high.x && a->low.y <= b->high.y && b->low.y <= a->high.y &&
           a->low.z <= b->high.z && b->low.z <= a->high.z;
}

static void assert_box_answer(const kd_box_tree *t, uint32_t *out)
{
    kd_box region = random_box(110, 60);
    uint32_t found = kd_box_tree_in_box(t, &region, out), at = 0;
    for (uint32_t i = 0; i < t->count; i++)
        if (overlap(&region, &t->boxes[i])) {
            assert_true(at < found);
            assert_int_equal(out[at++], i);
        }
    assert_int_equal(at, found);
}

static void assert_frustum_answer(const kd_box_tree *t, uint32_t *out)
{
    kd_frustum f;
    for (int i = 0; i < 6; i++) { /* half spaces with the origin inside */
        kd_vec3 n = random_point(1);
        f.planes[i] = (kd_vec4){n.x, n.y, n.z, random_float(1, 40)};
    }
    uint32_t found = kd_box_tree_in_frustum(t, &f, out), at = 0;
    for (uint32_t i = 0; i < t->count; i++)
        if (kd_frustum_touches(&f, t->boxes[i].low, t->boxes[i].high)) {
            assert_true(at < found);
            assert_int_equal(out[at++], i);
        }
    assert_int_equal(at, found);
}

static void assert_unions(const kd_box_tree *t)
{
    kd_box all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}, still = all;
    for (uint32_t i = 0; i < t->count; i++)
        for (int k = 0; k < 3; k++) {
            float low = (&t->boxes[i].low.x)[k], high = (&t->boxes[i].high.x)[k];
            (&all.low.x)[k] = fminf((&all.low.x)[k], low);
            (&all.high.x)[k] = fmaxf((&all.high.x)[k], high);
            if (!t->still[i])
                continue;
            (&still.low.x)[k] = fminf((&still.low.x)[k], low);
            (&still.high.x)[k] = fmaxf((&still.high.x)[k], high);
        }
    kd_box a = kd_box_tree_all(t), s = kd_box_tree_still(t);
    assert_memory_equal(&a, &all, sizeof a);
    assert_memory_equal(&s, &still, sizeof s);
}

static void answers_are_those_of_asking_each(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 1, 15, 16, 17, 255, 256, 257, 4096, 5000};
    kd_box_tree t = {0};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        uint32_t *out = malloc((2 * (size_t)counts[c] + 1) * sizeof *out);
        fill(&t, counts[c]);
        assert_unions(&t);
        for (int i = 0; i < 40; i++) {
            assert_box_answer(&t, out);
            assert_frustum_answer(&t, out);
        }
        free(out);
    }
    kd_box_tree_fini(&t);
}

static void changed_boxes_are_found_where_they_are(void **state)
{
    (void)state;
    enum { COUNT = 3000 };
    kd_box_tree t = {0};
    uint32_t *out = malloc(2 * COUNT * sizeof *out);
    fill(&t, COUNT);
    for (uint32_t i = 0; i < 4000; i++) {
        uint32_t item = (uint32_t)random_float(0, COUNT - 0.5f);
        kd_box_tree_set(&t, item, random_box(150, 3), i % 2);
        if (i % 100 == 0) {
            assert_unions(&t);
            assert_box_answer(&t, out);
            assert_frustum_answer(&t, out);
        }
    }
    assert_true(kd_box_tree_is_worn(&t));
    kd_box_tree_build(&t);
    assert_false(kd_box_tree_is_worn(&t));
    assert_unions(&t);
    assert_box_answer(&t, out);
    free(out);
    kd_box_tree_fini(&t);
}

/* Boxes that are no places at all are in no answer, and hide none. */
static void boxes_without_a_place_are_left_out(void **state)
{
    (void)state;
    kd_box_tree t = {0};
    fill(&t, 200);
    t.boxes[7] = (kd_box){{NAN, NAN, NAN}, {NAN, NAN, NAN}};
    t.boxes[90] = (kd_box){{INFINITY, 0, 0}, {-INFINITY, 0, 0}};
    kd_box_tree_build(&t);
    uint32_t out[400];
    kd_box everything = {{-1e6f, -1e6f, -1e6f}, {1e6f, 1e6f, 1e6f}};
    assert_int_equal(kd_box_tree_in_box(&t, &everything, out), 198);
    kd_box_tree_fini(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_are_those_of_asking_each),
        cmocka_unit_test(changed_boxes_are_found_where_they_are),
        cmocka_unit_test(boxes_without_a_place_are_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
