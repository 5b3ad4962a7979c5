/* Light neither appears from nothing nor grows. An empty room with one lamp is simple enough to be computed
 * here, pixel by pixel, by quadrature over the hemisphere. */

#include "tests/image_fixture.h"

#define PI        3.14159265358979
#define ALBEDO    0.5
#define INTENSITY 10.0
#define WIDTH     48
#define HEIGHT    27

/* A room of 2 m round the origin: six planes that face inwards, one lamp, nothing else. The camera looks from
 * one corner to the opposite one. */
static const char room[] = "kandil.scene { size = {48, 27} }\n"
                           "local function wall(p, r)\n"
                           "    kandil.spawn { mesh = { shape = 'plane', size = {2, 1, 2} }, transform = { "
                           "position = p, rotation_deg = r },\n"
                           "                   material = { base_color = {%g, %g, %g} } }\n"
                           "end\n"
                           "wall({0, -1, 0}, {0, 0, 0}) wall({0, 1, 0}, {180, 0, 0})\n"
                           "wall({-1, 0, 0}, {0, 0, -90}) wall({1, 0, 0}, {0, 0, 90})\n"
                           "wall({0, 0, -1}, {90, 0, 0}) wall({0, 0, 1}, {-90, 0, 0})\n"
                           "kandil.spawn { light = { type = 'point', intensity = %g }, transform = { "
                           "position = {0.1, 0.2, -0.1} } }\n"
                           "kandil.spawn { camera = { fov_y_deg = 70 }, transform = { position = {-0.8, 0.5, "
                           "0.8}, look_at = {0.6, -0.3, -0.8} } }\n";

static image render(double albedo, double intensity, const char *view, const char *output)
{
    image_render(image_scenario("room.lua", room, albedo, albedo, albedo, intensity), "--frames", "1",
                 "--set", "light.bounces=1", "--view", view, "--out", image_path(output));
    return image_read(output);
}

/* ---- the same room by quadrature ---- */

typedef struct vec {
    double v[3];
} vec;

static const vec lamp = {{0.1, 0.2, -0.1}}, eye = {{-0.8, 0.5, 0.8}}, target = {{0.6, -0.3, -0.8}};

static vec cross(vec a, vec b)
{
    return (vec){{a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2],
                  a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}

static vec unit(vec a)
{
    double length = sqrt(a.v[0] * a.v[0] + a.v[1] * a.v[1] + a.v[2] * a.v[2]);
    return (vec){{a.v[0] / length, a.v[1] / length, a.v[2] / length}};
}

/* Where a ray from inside meets a wall, and the axis of the wall's normal. */
static vec hit(vec p, vec d, int *axis)
{
    double nearest = 1e9;
    for (int i = 0; i < 3; i++) {
        double t = fabs(d.v[i]) < 1e-12 ? 1e9 : ((d.v[i] > 0 ? 1 : -1) - p.v[i]) / d.v[i];
        if (t < nearest) {
            nearest = t;
            *axis = i;
        }
    }
    for (int i = 0; i < 3; i++)
        p.v[i] += nearest * d.v[i];
    return p;
}

static vec pixel_hit(uint32_t x, uint32_t y, int *axis)
{
    vec forward = unit((vec){{target.v[0] - eye.v[0], target.v[1] - eye.v[1], target.v[2] - eye.v[2]}});
    vec right = unit(cross(forward, (vec){{0, 1, 0}})), up = cross(right, forward), d;
    double half = tan(35 * PI / 180);
    double sx = ((x + 0.5) / WIDTH * 2 - 1) * half * WIDTH / HEIGHT, sy = (1 - (y + 0.5) / HEIGHT * 2) * half;
    for (int i = 0; i < 3; i++)
        d.v[i] = forward.v[i] + sx * right.v[i] + sy * up.v[i];
    return hit(eye, d, axis);
}

/* Radiance that a wall point sends out after one reflection. */
static double direct(vec p, int axis)
{
    vec l = {{lamp.v[0] - p.v[0], lamp.v[1] - p.v[1], lamp.v[2] - p.v[2]}};
    double d2 = l.v[0] * l.v[0] + l.v[1] * l.v[1] + l.v[2] * l.v[2];
    return ALBEDO / PI * INTENSITY * fabs(l.v[axis]) / (d2 * sqrt(d2));
}

/* The same after two: albedo times the mean of `direct` over the cosine-weighted hemisphere, by the midpoint
 * rule. */
static double indirect(vec p, int axis)
{
    enum { RINGS = 24, SECTORS = 48 };
    double sum = 0, inward = p.v[axis] > 0 ? -1 : 1;
    p.v[axis] = -inward * (1 - 1e-9);
    for (int i = 0; i < RINGS * SECTORS; i++) {
        double sine = sqrt((i / SECTORS + 0.5) / RINGS), turn = 2 * PI * (i % SECTORS + 0.5) / SECTORS;
        vec d;
        int other;
        d.v[axis] = inward * sqrt(1 - sine * sine);
        d.v[(axis + 1) % 3] = sine * cos(turn);
        d.v[(axis + 2) % 3] = sine * sin(turn);
        vec q = hit(p, d, &other);
        sum += direct(q, other);
    }
    return ALBEDO * sum / (RINGS * SECTORS);
}

/* ---- tests ---- */

/* Away from grazing views, where the highlight of a rough surface shows, direct light is albedo / pi times
 * irradiance; Fresnel takes 2 to 4 % of it and the highlight gives some back. Pixels on a seam of two walls
 * may see a sliver of shadow. */
static void direct_light_is_what_it_should_be(void **state)
{
    (void)state;
    image p = render(ALBEDO, INTENSITY, "direct", "direct.exr");
    int off = 0;
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) {
            int axis;
            vec q = pixel_hit(x, y, &axis);
            off += fabs((double)image_at(p, x, y)[0] / direct(q, axis) - 1) > 0.06;
        }
    assert_in_range(off, 0, 6);
    image_free(&p);
}

/* What a bounce brings to a pixel is a mean of what walls send out, so never more than albedo times the
 * brightest point, 0.8 m from the lamp; the highlight of a rough white surface returns at most another 7 %.
 * All together must bring what there is within what six cones make of an uneven room: 5 % more, a quarter
 * less. Single pixels differ more: cones are wide, so dark corners take from bright walls. */
static void one_bounce_is_bounded_by_the_light_there_is(void **state)
{
    const double bound = (ALBEDO + 0.07) * ALBEDO / PI * INTENSITY / (0.8 * 0.8);
    double sum = 0, wanted = 0;
    (void)state;
    image p = render(ALBEDO, INTENSITY, "indirect", "indirect.exr");
    for (uint32_t y = 0; y < HEIGHT; y++)
        for (uint32_t x = 0; x < WIDTH; x++) {
            int axis;
            vec q = pixel_hit(x, y, &axis);
            double exact = indirect(q, axis), got = (double)image_at(p, x, y)[0];
            assert_double_below(got, bound);
            assert_double_below(got, 1.65 * exact);
            assert_double_above(got, 0.5 * exact);
            sum += got;
            wanted += exact;
        }
    if (getenv("KD_KEEP_PICTURES"))
        print_message("indirect light: %.3f of what is exact\n", sum / wanted);
    assert_double_below(sum, 1.05 * wanted);
    assert_double_above(sum, 0.75 * wanted);
    image_free(&p);
}

/* All that happens to light is linear, and halfs scale by two without rounding. Equal bits would be too much
 * to ask: the tree keeps radiance in a common exponent, whose last bit may fall otherwise. */
static void doubled_lamp_doubles_the_picture(void **state)
{
    (void)state;
    image one = render(ALBEDO, INTENSITY, "final", "one.exr"),
          two = render(ALBEDO, 2 * INTENSITY, "final", "two.exr");
    for (size_t i = 0; i < image_count(one); i++)
        assert_double_near((double)two.rgb[i], 2 * (double)one.rgb[i], 0.002 * (double)two.rgb[i]);
    image_free(&one);
    image_free(&two);
}

static void no_lamp_is_black(void **state)
{
    (void)state;
    image p = render(ALBEDO, 0, "final", "dark.exr");
    for (size_t i = 0; i < image_count(p); i++)
        assert_true(p.rgb[i] == 0.0f);
    image_free(&p);
}

/* All indirect light here has met a wall: what a black wall's highlight returns is not carried by voxels. */
static void black_walls_send_nothing_back(void **state)
{
    (void)state;
    image p = render(0, INTENSITY, "indirect", "black.exr");
    for (size_t i = 0; i < image_count(p); i++)
        assert_true(p.rgb[i] == 0.0f);
    image_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(direct_light_is_what_it_should_be),
        cmocka_unit_test(one_bounce_is_bounded_by_the_light_there_is),
        cmocka_unit_test(doubled_lamp_doubles_the_picture),
        cmocka_unit_test(no_lamp_is_black),
        cmocka_unit_test(black_walls_send_nothing_back),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
