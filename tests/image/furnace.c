/* A furnace: a closed room whose walls all glow alike and reflect alike. Wherever the camera stands and
 * however the room lies to the voxels, every pixel must have the same radiance. */

#include "tests/image_fixture.h"

typedef struct furnace {
    const char *name;
    double inside[3]; /* edges of the room, m */
    double at[3];     /* its middle */
    double turn_deg[3];
    double eye[3], look[3]; /* in shares of half the room */
    const char *span, *voxels, *cascades, *every;
    double limit; /* of the largest deviation from the mean, relative */
} furnace;

#define ALBEDO 0.5
/* Every wall sends out 1 and reflects what one bounce brings: albedo and some 4 % Fresnel, that a rough
 * surface loses in part. */
#define RADIANCE (1 + ALBEDO + 0.01)

/* Six slabs round the room; they overlap at the edges, so that no light gets lost. The camera turns with the
 * room. */
static const char room[] =
    "kandil.scene { size = {64, 48} }\n"
    "local n = kandil.spawn { transform = { position = {%g, %g, %g}, rotation_deg = {%g, %g, %g} } }\n"
    "local e, t = {%g, %g, %g}, 0.3\n"
    "for axis = 1, 3 do\n"
    "    for side = -1, 1, 2 do\n"
    "        local size, place = {e[1] + 2 * t, e[2] + 2 * t, e[3] + 2 * t}, {0, 0, 0}\n"
    "        size[axis], place[axis] = t, side * (e[axis] + t) / 2\n"
    "        kandil.spawn { parent = n, mesh = { shape = 'box', size = size }, transform = { position = "
    "place },\n"
    "                       material = { base_color = {%g, %g, %g}, emissive = {1, 1, 1} } }\n"
    "    end\n"
    "end\n"
    "kandil.spawn { parent = n, camera = { fov_y_deg = 60, z_near = 0.01 },\n"
    "               transform = { position = {%g, %g, %g}, look_at = {%g, %g, %g} } }\n";

static image render(const furnace *f, const char *view)
{
    char span[64], voxels[64], cascades[64], every[64];
    double eye[3], look[3];
    for (int i = 0; i < 3; i++) {
        eye[i] = f->eye[i] * f->inside[i] / 2;
        look[i] = f->look[i] * f->inside[i] / 2;
    }
    const char *scene =
        image_scenario("furnace.lua", room, f->at[0], f->at[1], f->at[2], f->turn_deg[0], f->turn_deg[1],
                       f->turn_deg[2], f->inside[0], f->inside[1], f->inside[2], ALBEDO, ALBEDO, ALBEDO,
                       eye[0], eye[1], eye[2], look[0], look[1], look[2]);
    snprintf(span, sizeof span, "voxels.span=%s", f->span);
    snprintf(voxels, sizeof voxels, "voxels.resolution=%s", f->voxels);
    snprintf(cascades, sizeof cascades, "voxels.cascades=%s", f->cascades);
    snprintf(every, sizeof every, "cones.resolution=%s", f->every);
    image_render(scene, "--frames", "1", "--set", "light.bounces=1", "--gi", "cones", "--view", view, "--set",
                 span, "--set", voxels, "--set", cascades, "--set", every, "--out",
                 image_path("furnace.exr"));
    return image_read("furnace.exr");
}

static double spread(image p, double *mean)
{
    double worst = 0;
    *mean = image_mean_all(p);
    for (size_t i = 0; i < image_count(p); i++)
        worst = fmax(worst, fabs((double)p.rgb[i] - *mean));
    return worst / *mean;
}

/* Two metres at 2 cm are 100 voxels; walls lie on the voxels' lattice where nothing else is said. */
static const furnace plain_rooms[] = {
    {"room", {2, 2, 2}, {0, 0, 0}, {0, 0, 0}, {0.1, 0, 0.2}, {0.3, 0.1, -1}, "0.02", "128", "3", "1", 0.02},
    {"room, every other pixel",
     {2, 2, 2},
     {0, 0, 0},
     {0, 0, 0},
     {0.1, 0, 0.2},
     {0.3, 0.1, -1},
     "0.02",
     "128",
     "3",
     "2",
     0.02},
    {"room from a corner", /* the walls behind the camera's reach lie in the second cascade */
     {2, 2, 2},
     {0, 0, 0},
     {0, 0, 0},
     {0.8, 0.8, 0.8},
     {-1, -1, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.028},
    {"corner of a room",
     {2, 2, 2},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.02},
    {"room in large cascades",
     {2, 2, 2},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.02",
     "256",
     "3",
     "2",
     0.02},
    {"room off the lattice",
     {2, 2, 2},
     {0.013, 0.007, 0.009},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.02},
};

/* Walls a few voxels long, slanted, seen along themselves, or crossing from cascade to cascade: no more than
 * what is stated. */
static const furnace hard_rooms[] = {
    {"room seen along its walls",
     {2, 2, 2},
     {0, 0, 0},
     {0, 0, 0},
     {0, -0.9, 0.9},
     {0, -0.9, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.03},
    {"room close to a wall",
     {2, 2, 2},
     {0, 0, 0},
     {0, 0, 0},
     {0.9, 0, 0},
     {1, 0.2, -0.3},
     "0.02",
     "128",
     "3",
     "1",
     0.03},
    {"one cascade off the lattice",
     {2, 2, 2},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.03",
     "128",
     "1",
     "1",
     0.03},
    {"turned about y",
     {2, 2, 2},
     {0, 0, 0},
     {0, 20, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.035},
    {"turned about all axes",
     {2, 2, 2},
     {0.01, 0.02, 0.03},
     {20, 20, 20},
     {0, 0, 0},
     {-1, -1, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.03},
    {"10 voxels wide",
     {0.8, 0.8, 0.8},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.08",
     "128",
     "3",
     "1",
     0.03},
    {"10 voxels wide, turned",
     {0.8, 0.8, 0.8},
     {0.03, 0.05, 0.02},
     {0, 20, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.08",
     "128",
     "3",
     "1",
     0.02},
    {"3 voxels wide",
     {0.6, 0.6, 0.6},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.2",
     "128",
     "3",
     "1",
     0.03},
    {"1 voxel wide",
     {0.4, 0.4, 0.4},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.4",
     "128",
     "3",
     "1",
     0.02},
    {"hall over three cascades",
     {10, 4, 6},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     {-1, -1, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.055},
    {"hall, turned",
     {8, 4, 6},
     {0, 0, 0},
     {0, 20, 0},
     {0, 0, 0},
     {-1, -0.3, -1},
     "0.02",
     "128",
     "3",
     "1",
     0.03},
};

/* Returns whether the room is as even as it must be; says so if not. */
static bool is_even(const furnace *f)
{
    double mean;
    image p = render(f, "final");
    double worst = spread(p, &mean);
    bool even = worst <= f->limit;
    if (!even || getenv("KD_KEEP_PICTURES"))
        print_message("%s: mean radiance %.4f, off by %.2f %% at most, of %.2f %%\n", f->name, mean,
                      100 * worst, 100 * f->limit);
    image_free(&p);
    return even;
}

static void every_pixel_of_a_furnace_is_equally_bright(void **state)
{
    int uneven = 0;
    (void)state;
    for (size_t i = 0; i < sizeof plain_rooms / sizeof *plain_rooms; i++)
        uneven += !is_even(&plain_rooms[i]);
    assert_int_equal(uneven, 0);
}

static void hard_furnaces_are_nearly_even(void **state)
{
    int uneven = 0;
    (void)state;
    for (size_t i = 0; i < sizeof hard_rooms / sizeof *hard_rooms; i++)
        uneven += !is_even(&hard_rooms[i]);
    assert_int_equal(uneven, 0);
}

/* Evenness alone would let light get lost everywhere. */
static void a_furnace_has_the_radiance_it_should_have(void **state)
{
    double mean;
    (void)state;
    image p = render(&plain_rooms[0], "final");
    spread(p, &mean);
    assert_double_near(mean, RADIANCE, 0.02 * RADIANCE);
    image_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_of_a_furnace_is_equally_bright),
        cmocka_unit_test(hard_furnaces_are_nearly_even),
        cmocka_unit_test(a_furnace_has_the_radiance_it_should_have),
    };
    return cmocka_run_group_tests(tests, image_setup, image_teardown);
}
