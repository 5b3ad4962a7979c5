/* Our limit surfaces against OpenSubdiv's own evaluation on the CPU, which goes another way
 * (tests/osd_limit.h). Each of our vertices must be one of its points within 1e-5 of the cage's size, and
 * each of its points a vertex of ours. Creases that round off must have done so before its limit is right:
 * there it refines deeper, and has points that we have not. */

#include "tests/osd_limit.h"
#include "tests/systems_fixture.h"

#include "runtime/asset/subdiv_surface.h"

typedef struct shape {
    const char *name;
    subdiv_cage cage;
    const float *positions;
    int roundest; /* levels after which all creases have rounded off */
} shape;

static void assert_each_has_a_mate(const shape *s, const float *points, int count, const float *mates,
                                   int mate_count)
{
    for (int i = 0; i < count; i++) {
        float nearest = INFINITY;
        for (int k = 0; k < mate_count && nearest > 1e-10f; k++) {
            float d2 = 0;
            for (int c = 0; c < 3; c++)
                d2 += (points[3 * i + c] - mates[3 * k + c]) * (points[3 * i + c] - mates[3 * k + c]);
            nearest = fminf(nearest, d2);
        }
        if (sqrtf(nearest) > 1e-5f)
            fail_msg("%s: point %d is %g away from the nearest", s->name, i, (double)sqrtf(nearest));
    }
}

static void check(const shape *s, int level)
{
    char error[256];
    kd_arena kept = {0}, work = {0};
    subdiv_surface surface;
    assert_int_equal(subdiv_surface_make(&s->cage, level, NULL, &kept, &work, &surface, error, sizeof error),
                     KD_OK);
    kd_vec3 *ours = calloc(surface.vertex_count, sizeof *ours),
            *normals = calloc(surface.vertex_count, sizeof *normals);
    const kd_subdivision subdivision = {.rows = surface.rows, .stencils = surface.stencils};
    kd_subdivision_evaluate(&subdivision, surface.vertex_count, (const kd_vec3 *)(const void *)s->positions,
                            ours, normals, NULL);
    int deeper = level > s->roundest ? level : s->roundest;
    int count = osd_limit(&s->cage, deeper, s->positions, NULL);
    float *theirs = calloc((size_t)count * 3, sizeof *theirs);
    osd_limit(&s->cage, deeper, s->positions, theirs);
    if (deeper == level)
        assert_each_has_a_mate(s, theirs, count, &ours[0].x, (int)surface.vertex_count);
    assert_each_has_a_mate(s, &ours[0].x, (int)surface.vertex_count, theirs, count);
    free(ours);
    free(normals);
    free(theirs);
    kd_arena_fini(&kept);
    kd_arena_fini(&work);
}

static const float cube[24] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                               -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static const int four[6] = {4, 4, 4, 4, 4, 4};
static const int cube_corners[24] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
/* The first faces of the cube. */
#define QUADS(vertices, faces)                                                                               \
    .vertex_count = vertices, .face_count = faces, .corner_count = 4 * (faces), .face_sizes = four,          \
    .corners = cube_corners
static const int rim[8] = {4, 5, 5, 6, 6, 7, 7, 4};
static const float endless[4] = {10, 10, 10, 10}, soft[4] = {1, 2, 3, 1.5f};

/* A pyramid on a pentagon: triangles and a face of five. */
static const float pyramid[18] = {1,     0, 0,     0.3f, 0, 0.95f,  -0.8f, 0,    0.6f,
                                  -0.8f, 0, -0.6f, 0.3f, 0, -0.95f, 0,     1.2f, 0};
static const int pyramid_sizes[6] = {5, 3, 3, 3, 3, 3};
static const int pyramid_corners[20] = {0, 1, 2, 3, 4, 0, 5, 1, 1, 5, 2, 2, 5, 3, 3, 5, 4, 4, 5, 0};

static const float octahedron[18] = {1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, -1.4f, 0, 0, 0.2f, -1};
static const int three[8] = {3, 3, 3, 3, 3, 3, 3, 3};
static const int octahedron_corners[24] = {0, 1, 2, 1, 3, 2, 3, 4, 2, 4, 0, 2,
                                           1, 0, 5, 3, 1, 5, 4, 3, 5, 0, 4, 5};
static const int ridge[4] = {0, 1, 1, 3}, tip[1] = {2};

static void surfaces_equal_opensubdivs_own(void **state)
{
    (void)state;
    const shape shapes[] = {
        {"cube", {QUADS(8, 6), .boundary = SUBDIV_EDGE_AND_CORNER}, cube, 0},
        {"sharp rim",
         {QUADS(8, 6), .boundary = SUBDIV_EDGE_AND_CORNER, .crease_count = 4, .creases = rim,
          .crease_sharpness = endless},
         cube,
         0},
        {"soft rim",
         {QUADS(8, 6), .boundary = SUBDIV_EDGE_AND_CORNER, .crease_count = 4, .creases = rim,
          .crease_sharpness = soft},
         cube,
         4},
        {"open box", {QUADS(8, 5), .boundary = SUBDIV_EDGE_AND_CORNER}, cube, 0},
        {"one quad", {QUADS(4, 1), .boundary = SUBDIV_EDGE_AND_CORNER}, cube, 0},
        {"one round quad", {QUADS(4, 1), .boundary = SUBDIV_EDGE_ONLY}, cube, 0},
        {"pyramid",
         {.vertex_count = 6,
          .face_count = 6,
          .corner_count = 20,
          .face_sizes = pyramid_sizes,
          .corners = pyramid_corners,
          .boundary = SUBDIV_EDGE_AND_CORNER,
          .sharp_corner_count = 1,
          .sharp_corners = tip,
          .corner_sharpness = endless},
         pyramid,
         0},
        {"loop",
         {.loop = true,
          .vertex_count = 6,
          .face_count = 8,
          .corner_count = 24,
          .face_sizes = three,
          .corners = octahedron_corners,
          .boundary = SUBDIV_EDGE_AND_CORNER},
         octahedron,
         0},
        {"loop with a ridge",
         {.loop = true,
          .vertex_count = 6,
          .face_count = 8,
          .corner_count = 24,
          .face_sizes = three,
          .corners = octahedron_corners,
          .boundary = SUBDIV_EDGE_AND_CORNER,
          .crease_count = 2,
          .creases = ridge,
          .crease_sharpness = endless,
          .sharp_corner_count = 1,
          .sharp_corners = tip,
          .corner_sharpness = endless},
         octahedron,
         0},
    };
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        for (int level = 1; level <= 3; level++)
            check(&shapes[i], level);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(surfaces_equal_opensubdivs_own)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
