/* A drop of one metre across, standing on the ground, with two shapes to morph into: drawn out to a tip, and
 * a star of five lobes. Its clip swings between them. */

#include <math.h>
#include <stddef.h>

#include "samples/assets/generate.h"
#include "samples/assets/gltf.h"

enum { RINGS = 33, SECTORS = 64, POINTS = RINGS * (SECTORS + 1), SHAPES = 3, KEYS = 5 };
enum { BALL, TIP, STAR };

/* The surface of a shape at latitude v (0 at the bottom, 1 on top) and longitude u. */
static void surface(int shape, double u, double v, double out[3])
{
    double a = 2 * 3.14159265358979323846 * u, b = 3.14159265358979323846 * (v - 0.5);
    double radius = 0.5, across = cos(b), up = sin(b);
    if (shape == STAR)
        radius *= 1 + 0.35 * across * across * cos(5 * a);
    if (shape == TIP) {
        double share = v * v;
        up += 1.2 * share * share;
        across *= 1 - 0.75 * share;
    }
    out[0] = radius * across * sin(a);
    out[1] = 0.5 + radius * up;
    out[2] = radius * across * cos(a);
}

static void normal(int shape, double u, double v, double out[3])
{
    const double step = 1e-4;
    double low[3], high[3], along_u[3], along_v[3], length = 0;
    double inside = v < 0.01 ? 0.01 : v > 0.99 ? 0.99 : v; /* the poles have no direction of their own */
    surface(shape, u - step, inside, low);
    surface(shape, u + step, inside, high);
    for (int c = 0; c < 3; c++)
        along_u[c] = high[c] - low[c];
    surface(shape, u, inside - step, low);
    surface(shape, u, inside + step, high);
    for (int c = 0; c < 3; c++)
        along_v[c] = high[c] - low[c];
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        out[c] = along_u[d] * along_v[e] - along_u[e] * along_v[d];
        length += out[c] * out[c];
    }
    for (int c = 0; c < 3; c++)
        out[c] = v == inside ? out[c] / sqrt(length) : c == 1 ? (v > 0.5 ? 1 : -1) : 0;
}

static float positions[SHAPES][POINTS][3], normals[SHAPES][POINTS][3];
static uint16_t indices[(RINGS - 1) * SECTORS * 6];

/* Rounded to a millionth, so that no machine's sine shows. */
static float rounded(double x)
{
    return (float)(floor(x * 1e6 + 0.5) / 1e6);
}

static void make_points(void)
{
    for (int shape = 0; shape < SHAPES; shape++)
        for (int i = 0; i < POINTS; i++) {
            double u = (double)(i % (SECTORS + 1)) / SECTORS, v = (double)(i / (SECTORS + 1)) / (RINGS - 1);
            double p[3], n[3];
            surface(shape, u, v, p);
            normal(shape, u, v, n);
            for (int c = 0; c < 3; c++) { /* targets are differences from the ball */
                positions[shape][i][c] = rounded(p[c]) - (shape ? positions[BALL][i][c] : 0);
                normals[shape][i][c] = rounded(n[c]) - (shape ? normals[BALL][i][c] : 0);
            }
        }
}

static void make_triangles(void)
{
    uint16_t *out = indices;
    for (int ring = 0; ring < RINGS - 1; ring++)
        for (int sector = 0; sector < SECTORS; sector++) {
            int at = ring * (SECTORS + 1) + sector, above = at + SECTORS + 1;
            const int corners[6] = {at, at + 1, above + 1, at, above + 1, above};
            for (int k = 0; k < 6; k++)
                *out++ = (uint16_t)corners[k];
        }
}

static int add_points(gltf *g, float (*values)[3], bool bounds)
{
    return gltf_add_array(g, &(gltf_array){.data = values,
                                           .count = POINTS,
                                           .width = 3,
                                           .type = GLTF_F32,
                                           .target = GLTF_VERTICES,
                                           .bounds = bounds});
}

static void add_clip(gltf *g)
{
    static const float times[KEYS] = {0, 1, 2, 3, 4};
    static const float weights[KEYS][SHAPES - 1] = {{0, 0}, {1, 0}, {0.2f, 0.2f}, {0, 1}, {0, 0}};
    int input = gltf_add_array(
        g, &(gltf_array){.data = times, .count = KEYS, .width = 1, .type = GLTF_F32, .bounds = true});
    int output = gltf_add_array(
        g, &(gltf_array){.data = weights, .count = KEYS * (SHAPES - 1), .width = 1, .type = GLTF_F32});
    gltf_add(
        g, GLTF_ANIMATIONS,
        "{\"name\":\"morph\",\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"weights\"}}],"
        "\"samplers\":[{\"input\":%d,\"output\":%d,\"interpolation\":\"LINEAR\"}]}",
        input, output);
}

bool drop_write(const char *folder)
{
    gltf g = {0};
    int at[SHAPES][2];
    make_points();
    make_triangles();
    for (int shape = 0; shape < SHAPES; shape++) {
        at[shape][0] = add_points(&g, positions[shape], true);
        at[shape][1] = add_points(&g, normals[shape], false);
    }
    int triangles = gltf_add_array(&g, &(gltf_array){.data = indices,
                                                     .count = (int)(sizeof indices / sizeof *indices),
                                                     .width = 1,
                                                     .type = GLTF_U16,
                                                     .target = GLTF_INDICES});
    gltf_add(&g, GLTF_MATERIALS,
             "{\"name\":\"drop\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.2,0.45,0.8,1],"
             "\"metallicFactor\":0,\"roughnessFactor\":0.35}}");
    gltf_add(&g, GLTF_MESHES,
             "{\"name\":\"drop\",\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d},"
             "\"indices\":%d,\"material\":0,\"targets\":[{\"POSITION\":%d,\"NORMAL\":%d},"
             "{\"POSITION\":%d,\"NORMAL\":%d}]}],\"weights\":[0,0],\"extras\":{\"targetNames\":[\"tip\","
             "\"star\"]}}",
             at[BALL][0], at[BALL][1], triangles, at[TIP][0], at[TIP][1], at[STAR][0], at[STAR][1]);
    gltf_add(&g, GLTF_NODES, "{\"name\":\"drop\",\"mesh\":0}");
    add_clip(&g);
    gltf_add(&g, GLTF_SCENES, "{\"name\":\"drop\",\"nodes\":[0]}");
    bool ok = gltf_save(&g, folder, "drop");
    gltf_free(&g);
    return ok;
}
