/* Primitives made in memory. Each is a grid of points (u, v) put on a surface; u rises along the tangent, v
 * downwards as in glTF, and triangles wind counter-clockwise seen from outside. */

#include "runtime/asset/model.h"

#include <math.h>

#include "runtime/asset/model_memory.h"
#include "runtime/core/log.h"

#define PI_F         3.14159265358979f
#define SEGMENTS     32u   /* a silhouette of 32 edges reads as round at the sizes scenes have */
#define SEGMENTS_MAX 1024u /* two million triangles, beyond which a shape is a mistake */

typedef struct builder {
    kd_vec3 *positions, *normals;
    kd_vec4 *tangents;
    kd_vec2 *uv;
    uint32_t *indices;
    uint32_t vertex_count, index_count;
} builder;

static uint32_t put_vertex(builder *b, kd_vec3 position, kd_vec3 normal, kd_vec3 tangent, float u, float v)
{
    uint32_t i = b->vertex_count++;
    b->positions[i] = position;
    b->normals[i] = kd_vec3_normalize(normal, (kd_vec3){0, 1, 0});
    kd_vec3 t = kd_vec3_normalize(tangent, (kd_vec3){1, 0, 0});
    b->tangents[i] = (kd_vec4){t.x, t.y, t.z, 1};
    b->uv[i] = (kd_vec2){u, v};
    return i;
}

static void put_triangle(builder *b, uint32_t i, uint32_t j, uint32_t k)
{
    b->indices[b->index_count++] = i;
    b->indices[b->index_count++] = j;
    b->indices[b->index_count++] = k;
}

/* ---- flat faces ---- */

/* A rectangle round `centre`, spanned by the half axes; the normal is right x up. v falls along up. */
static void put_rectangle(builder *b, kd_vec3 centre, kd_vec3 right, kd_vec3 up)
{
    kd_vec3 normal = kd_vec3_cross(right, up);
    uint32_t first = b->vertex_count;
    for (int i = 0; i < 4; i++) {
        float x = i == 1 || i == 2 ? 1.0f : -1.0f, y = i >= 2 ? 1.0f : -1.0f;
        kd_vec3 p = kd_vec3_add(centre, kd_vec3_add(kd_vec3_scale(right, x), kd_vec3_scale(up, y)));
        put_vertex(b, p, normal, right, (x + 1) / 2, (1 - y) / 2);
    }
    put_triangle(b, first, first + 1, first + 2);
    put_triangle(b, first, first + 2, first + 3);
}

static void make_box(builder *b, kd_vec3 size)
{
    kd_vec3 x = {size.x / 2, 0, 0}, y = {0, size.y / 2, 0}, z = {0, 0, size.z / 2};
    kd_vec3 nx = kd_vec3_scale(x, -1), ny = kd_vec3_scale(y, -1), nz = kd_vec3_scale(z, -1);
    put_rectangle(b, x, nz, y);
    put_rectangle(b, nx, z, y);
    put_rectangle(b, y, x, nz);
    put_rectangle(b, ny, x, z);
    put_rectangle(b, z, x, y);
    put_rectangle(b, nz, nx, y);
}

/* ---- surfaces of revolution ---- */

typedef struct surface_point {
    kd_vec3 position, normal, tangent;
} surface_point;
typedef surface_point surface(kd_vec3 size, float u, float v);

static surface_point sphere_at(kd_vec3 size, float u, float v)
{
    float a = u * 2 * PI_F, e = v * PI_F, r = size.x / 2, h = size.y / 2, s = v == 1 ? 0 : sinf(e);
    kd_vec3 out = {cosf(a) * s, cosf(e), -sinf(a) * s};
    /* The normal of an ellipsoid scales by the inverse of its axes. */
    return (surface_point){
        {out.x * r, out.y * h, out.z * r}, {out.x / r, out.y / h, out.z / r}, {-sinf(a), 0, -cosf(a)}};
}

static surface_point side_at(kd_vec3 size, float u, float v)
{
    float a = u * 2 * PI_F, r = size.x / 2;
    kd_vec3 out = {cosf(a), 0, -sinf(a)};
    return (surface_point){{out.x * r, size.y * (0.5f - v), out.z * r}, out, {-sinf(a), 0, -cosf(a)}};
}

/* v runs from the outer rim over the top: the tube turns from pointing out to pointing up. */
static surface_point torus_at(kd_vec3 size, float u, float v)
{
    float a = u * 2 * PI_F, e = -v * 2 * PI_F, tube = size.y / 2, ring = size.x / 2 - tube;
    kd_vec3 out = {cosf(a), 0, -sinf(a)}, normal = {out.x * cosf(e), sinf(e), out.z * cosf(e)};
    kd_vec3 centre = kd_vec3_scale(out, ring);
    return (surface_point){kd_vec3_add(centre, kd_vec3_scale(normal, tube)), normal, {-sinf(a), 0, -cosf(a)}};
}

/* `columns` by `rows` quads; the first and the last row of a surface with poles have one triangle a column.
 */
static void put_grid(builder *b, surface *at, kd_vec3 size, uint32_t columns, uint32_t rows, bool poles)
{
    uint32_t first = b->vertex_count;
    for (uint32_t j = 0; j <= rows; j++)
        for (uint32_t i = 0; i <= columns; i++) {
            float u = (float)i / (float)columns, v = (float)j / (float)rows;
            surface_point p = at(size, i == columns ? 0 : u, v); /* the seam closes exactly */
            put_vertex(b, p.position, p.normal, p.tangent, u, v);
        }
    for (uint32_t j = 0; j < rows; j++)
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t top = first + j * (columns + 1) + i, low = top + columns + 1;
            if (!poles || j + 1 < rows)
                put_triangle(b, top, low, low + 1);
            if (!poles || j > 0)
                put_triangle(b, top, low + 1, top + 1);
        }
}

static void put_cap(builder *b, kd_vec3 size, uint32_t segments, float up)
{
    kd_vec3 normal = {0, up, 0}, right = {1, 0, 0};
    float y = size.y / 2 * up;
    uint32_t centre = put_vertex(b, (kd_vec3){0, y, 0}, normal, right, 0.5f, 0.5f);
    for (uint32_t i = 0; i < segments; i++) {
        kd_vec3 p = side_at(size, (float)i / (float)segments, 0).position;
        put_vertex(b, (kd_vec3){p.x, y, p.z}, normal, right, 0.5f + p.x / size.x, 0.5f + up * p.z / size.x);
    }
    for (uint32_t i = 0; i < segments; i++) {
        uint32_t here = centre + 1 + i, next = centre + 1 + (i + 1) % segments;
        put_triangle(b, centre, up > 0 ? here : next, up > 0 ? next : here);
    }
}

/* ---- the model ---- */

static void build(builder *b, kd_shape shape, kd_vec3 size, uint32_t n)
{
    switch (shape) {
    case KD_SHAPE_BOX: make_box(b, size); break;
    case KD_SHAPE_SPHERE: put_grid(b, sphere_at, size, n, (n + 1) / 2, true); break;
    case KD_SHAPE_PLANE:
        put_rectangle(b, (kd_vec3){0, 0, 0}, (kd_vec3){size.x / 2, 0, 0}, (kd_vec3){0, 0, -size.z / 2});
        break;
    case KD_SHAPE_CYLINDER:
        put_grid(b, side_at, size, n, 1, false);
        put_cap(b, size, n, 1);
        put_cap(b, size, n, -1);
        break;
    case KD_SHAPE_TORUS: put_grid(b, torus_at, size, n, n < 6 ? 3 : n / 2, false); break;
    }
}

static bool reserve(kd_arena *arena, builder *b, uint32_t n)
{
    uint32_t vertices = 64 + (n + 1) * (n + 4),
             indices = 6 * vertices; /* enough for every shape of n segments */
    b->positions = KD_ARENA_NEW(arena, kd_vec3, vertices);
    b->normals = KD_ARENA_NEW(arena, kd_vec3, vertices);
    b->tangents = KD_ARENA_NEW(arena, kd_vec4, vertices);
    b->uv = KD_ARENA_NEW(arena, kd_vec2, vertices);
    b->indices = KD_ARENA_NEW(arena, uint32_t, indices);
    return b->positions && b->normals && b->tangents && b->uv && b->indices;
}

static const char *const shape_names[] = {"box", "sphere", "plane", "cylinder", "torus"};

/* One node, one mesh, one material. */
typedef struct shape_model {
    kd_model model;
    kd_material_desc material;
    kd_primitive_desc primitive;
    kd_mesh_desc mesh;
    kd_node_desc node;
    model_memory memory;
    const char *none[1];
} shape_model;

static void describe(shape_model *s, const char *name, const builder *b)
{
    kd_vec3 low = b->positions[0], high = low;
    for (uint32_t i = 1; i < b->vertex_count; i++) {
        kd_vec3 p = b->positions[i];
        low = (kd_vec3){fminf(low.x, p.x), fminf(low.y, p.y), fminf(low.z, p.z)};
        high = (kd_vec3){fmaxf(high.x, p.x), fmaxf(high.y, p.y), fmaxf(high.z, p.z)};
    }
    s->primitive = (kd_primitive_desc){.vertex_count = b->vertex_count,
                                       .index_count = b->index_count,
                                       .indices = b->indices,
                                       .positions = b->positions,
                                       .normals = b->normals,
                                       .tangents = b->tangents,
                                       .uv0 = b->uv,
                                       .bounds_min = low,
                                       .bounds_max = high};
    s->mesh = (kd_mesh_desc){.name = name, .primitive_count = 1, .primitives = &s->primitive};
    s->node = (kd_node_desc){.name = name,
                             .parent = KD_NONE,
                             .rotation = {0, 0, 0, 1},
                             .scale = {1, 1, 1},
                             .matrix = KD_MAT4_IDENTITY,
                             .skin = KD_NONE,
                             .camera = KD_NONE,
                             .light = KD_NONE};
    s->model = (kd_model){.path = name,
                          .material_count = 1,
                          .mesh_count = 1,
                          .node_count = 1,
                          .materials = &s->material,
                          .meshes = &s->mesh,
                          .nodes = &s->node,
                          .warnings = s->none,
                          .extensions_used = s->none,
                          .scenes = s->none,
                          .variants = s->none,
                          .scene = KD_NONE,
                          .generator = "kandil",
                          .triangle_count = b->index_count / 3,
                          .bounds_min = low,
                          .bounds_max = high};
}

static bool is_usable(kd_shape shape, kd_vec3 s)
{
    bool x = s.x > 0 && s.x<1e9f, y = s.y> 0 && s.y<1e9f, z = s.z> 0 && s.z < 1e9f;
    switch (shape) {
    case KD_SHAPE_BOX: return x && y && z;
    case KD_SHAPE_PLANE: return x && z;
    case KD_SHAPE_TORUS: return x && y && s.y * 2 <= s.x; /* the tube must not pass the axis */
    default: return x && y;
    }
}

kd_status kd_model_make_shape(kd_shape shape, kd_vec3 size, uint32_t segments,
                              const kd_material_desc *material, kd_model **out)
{
    *out = NULL;
    uint32_t n = segments ? segments : SEGMENTS;
    if ((unsigned)shape > KD_SHAPE_TORUS || !is_usable(shape, size))
        return kd_fail(KD_OUT_OF_RANGE, "shape: the size %g, %g, %g makes no %s; give positive lengths",
                       (double)size.x, (double)size.y, (double)size.z,
                       (unsigned)shape > KD_SHAPE_TORUS ? "known shape" : shape_names[shape]);
    if (n < 3 || n > SEGMENTS_MAX)
        return kd_fail(KD_OUT_OF_RANGE, "shape: %u segments are not 3 to %u", n, SEGMENTS_MAX);
    kd_arena arena = {0};
    builder b = {0};
    shape_model *s = KD_ARENA_NEW(&arena, shape_model, 1);
    if (!s || !reserve(&arena, &b, n)) {
        kd_arena_fini(&arena);
        return kd_fail(KD_NO_MEMORY, "shape: out of memory for %u segments", n);
    }
    build(&b, shape, size, n);
    s->material = material ? *material : kd_material_default();
    const char *name = s->material.name ? s->material.name : "material";
    s->material.name = kd_arena_printf(&arena, "%s", name);
    describe(s, shape_names[shape], &b);
    s->memory = (model_memory){arena, 1};
    s->model.internal = &s->memory;
    *out = &s->model;
    return KD_OK;
}
