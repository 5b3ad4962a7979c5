/* The Cornell-style box: 2 m each way inside, floor at y = 0, open towards +z. Its walls are closed slabs,
 * thick enough for a voxel of two centimetres to lie inside. Slabs meet edge to edge and nowhere overlap. */

#include "samples/assets/generate.h"
#include "samples/assets/gltf.h"

#define THICK 0.04f

typedef struct slab {
    const char *name;
    int material;
    float low[3], high[3];
} slab;

enum { WHITE, RED, GREEN };

static const slab slabs[] = {
    {"floor", WHITE, {-1 - THICK, -THICK, -1 - THICK}, {1 + THICK, 0, 1}},
    {"ceiling", WHITE, {-1 - THICK, 2, -1 - THICK}, {1 + THICK, 2 + THICK, 1}},
    {"back", WHITE, {-1, 0, -1 - THICK}, {1, 2, -1}},
    {"left", RED, {-1 - THICK, 0, -1 - THICK}, {-1, 2, 1}},
    {"right", GREEN, {1, 0, -1 - THICK}, {1 + THICK, 2, 1}},
};

/* Face f of a box: normal along axis f/2, on the high side when f is odd; corners run counter-clockwise from
 * outside. */
static void box_face(const slab *s, int f, float positions[4][3], float normals[4][3])
{
    static const int corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    int axis = f / 2, high = f % 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int k = 0; k < 4; k++) {
        const int *corner = corners[high ? k : 3 - k];
        positions[k][axis] = high ? s->high[axis] : s->low[axis];
        positions[k][u] = corner[0] ? s->high[u] : s->low[u];
        positions[k][v] = corner[1] ? s->high[v] : s->low[v];
        for (int c = 0; c < 3; c++)
            normals[k][c] = c != axis ? 0.0f : high ? 1.0f : -1.0f;
    }
}

static void add_slab(gltf *g, const slab *s, int index_array)
{
    float positions[24][3], normals[24][3];
    for (int f = 0; f < 6; f++)
        box_face(s, f, &positions[f * 4], &normals[f * 4]);
    int p = gltf_add_array(g, &(gltf_array){.data = positions,
                                            .count = 24,
                                            .width = 3,
                                            .type = GLTF_F32,
                                            .target = GLTF_VERTICES,
                                            .bounds = true});
    int n = gltf_add_array(
        g,
        &(gltf_array){.data = normals, .count = 24, .width = 3, .type = GLTF_F32, .target = GLTF_VERTICES});
    int mesh = gltf_add(g, GLTF_MESHES,
                        "{\"name\":\"%s\",\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d},"
                        "\"indices\":%d,\"material\":%d}]}",
                        s->name, p, n, index_array, s->material);
    gltf_add(g, GLTF_NODES, "{\"name\":\"%s\",\"mesh\":%d}", s->name, mesh);
}

static void add_material(gltf *g, const char *name, const char *color)
{
    gltf_add(g, GLTF_MATERIALS,
             "{\"name\":\"%s\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[%s,1],\"metallicFactor\":0,"
             "\"roughnessFactor\":0.9}}",
             name, color);
}

bool cornell_write(const char *folder)
{
    gltf g = {0};
    uint16_t indices[36];
    for (int f = 0; f < 6; f++)
        for (int k = 0; k < 6; k++)
            indices[f * 6 + k] = (uint16_t)(f * 4 + (const int[]){0, 1, 2, 0, 2, 3}[k]);
    int index_array = gltf_add_array(
        &g,
        &(gltf_array){.data = indices, .count = 36, .width = 1, .type = GLTF_U16, .target = GLTF_INDICES});
    add_material(&g, "white", "0.73,0.73,0.73");
    add_material(&g, "red", "0.65,0.05,0.05");
    add_material(&g, "green", "0.12,0.45,0.15");
    for (int i = 0; i < (int)(sizeof slabs / sizeof *slabs); i++)
        add_slab(&g, &slabs[i], index_array);
    gltf_add(&g, GLTF_SCENES, "{\"name\":\"cornell\",\"nodes\":[0,1,2,3,4]}");
    bool ok = gltf_save(&g, folder, "cornell");
    gltf_free(&g);
    return ok;
}
