/* Welding. Every patch is sampled on a grid of its own, so that a point on a side has a row from each patch
 * that touches it. Points get numbers by where they lie on the cage (vertex, edge, middle of a face); the
 * samples of one point that share normal and texture coordinates become one vertex. Normals are shared by
 * corners of faces that no infinitely sharp edge parts. All vertices of a point take their position from its
 * first sample, so that surfaces that part there have no crack between them. */

#include "runtime/asset/subdiv_surface.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct variant {
    uint32_t row, point_row; /* samples that give the derivatives and the position */
    uint32_t next;           /* of the same point, or KD_NONE */
    uint32_t group;          /* shares its normal with those of the same group */
    kd_vec2 uv;
    kd_vec2 tangent; /* along d/du, d/dv */
    bool mirrored;
} variant;

typedef struct welder {
    const subdiv_cage *cage;
    const subdiv_topology *topology;
    const kd_vec2 *uv_values;
    subdiv_rows rows, uv_rows;
    int level, n;        /* segments along an edge */
    uint32_t *group_of;  /* [corner_count] union-find: corners that share a normal */
    uint32_t *first;     /* [point_count] variant, or KD_NONE */
    uint32_t *vertex_of; /* [rows.row_count] */
    variant *variants;
    uint32_t variant_count, index_count;
    uint32_t *indices;
    int inner; /* point at which the sides inside of faces begin */
} welder;

/* A face, and the patch of it being sampled. */
typedef struct patch {
    int face, first_corner, size;
    int corner;   /* of a corner patch, within the face */
    int segments; /* along a side */
    bool whole;   /* the face is one patch */
    uint32_t row; /* of its first sample */
} patch;

typedef struct place {
    int point; /* -1: inside the patch */
    uint32_t group;
} place;

/* ---- which corners share a normal ---- */

static uint32_t find_group(uint32_t *of, uint32_t corner)
{
    while (of[corner] != corner)
        corner = of[corner] = of[of[corner]];
    return corner;
}

static void unite(const welder *w, int a, int b)
{
    if (w->topology->vertex_sharp[w->cage->corners[a]])
        return;
    uint32_t x = find_group(w->group_of, (uint32_t)a), y = find_group(w->group_of, (uint32_t)b);
    w->group_of[x < y ? y : x] = x < y ? x : y;
}

/* mate: [edge_count] pairs, scratch: the first corner seen on an edge, and the next one of its face. */
static void group_corners(const welder *w, int *mate)
{
    const subdiv_cage *cage = w->cage;
    for (int c = 0; c < cage->corner_count; c++)
        w->group_of[c] = (uint32_t)c;
    for (int e = 0; e < 2 * w->topology->edge_count; e++)
        mate[e] = -1;
    for (int f = 0, first = 0; f < cage->face_count; first += cage->face_sizes[f], f++)
        for (int i = 0; i < cage->face_sizes[f]; i++) {
            int a = first + i, b = first + (i + 1) % cage->face_sizes[f], e = w->topology->corner_edges[a];
            if (w->topology->edge_sharp[e])
                continue;
            if (mate[2 * e] < 0) {
                mate[2 * e] = a;
                mate[2 * e + 1] = b;
            } else { /* the other face runs along the edge the other way */
                unite(w, a, mate[2 * e + 1]);
                unite(w, b, mate[2 * e]);
            }
        }
}

/* ---- where a sample lies ---- */

/* `at` of n along the edge that leaves a corner of the face. */
static place on_edge(const welder *w, const patch *p, int corner, int at)
{
    int a = p->first_corner + corner, b = p->first_corner + (corner + 1) % p->size;
    if (at == 0 || at == w->n) {
        int c = at == 0 ? a : b;
        return (place){w->cage->corners[c], find_group(w->group_of, (uint32_t)c)};
    }
    int e = w->topology->corner_edges[a];
    if (w->topology->edge_vertices[2 * e] != w->cage->corners[a])
        at = w->n - at;
    return (place){w->cage->vertex_count + e * (w->n - 1) + at - 1,
                   w->topology->edge_sharp[e] ? (uint32_t)p->face + 1 : 0};
}

/* `at` of n / 2 from the middle of the edge that leaves a corner to the middle of the face. */
static place inside(const welder *w, const patch *p, int corner, int at)
{
    if (at == 0)
        return on_edge(w, p, corner, w->n / 2);
    if (at == p->segments)
        return (place){w->inner + p->face, 0};
    return (place){w->inner + w->cage->face_count + (p->first_corner + corner) * (p->segments - 1) + at - 1,
                   0};
}

static place place_of(const welder *w, const patch *p, int i, int j)
{
    const int m = p->segments, before = (p->corner + p->size - 1) % p->size;
    if (w->cage->loop)
        return j == 0       ? on_edge(w, p, 0, i)
               : i + j == m ? on_edge(w, p, 1, j)
               : i == 0     ? on_edge(w, p, 2, m - j)
                            : (place){-1, 0};
    if (j == 0)
        return on_edge(w, p, p->corner, i);
    if (i == m)
        return p->whole ? on_edge(w, p, 1, j) : inside(w, p, p->corner, j);
    if (j == m)
        return p->whole ? on_edge(w, p, 2, m - i) : inside(w, p, before, i);
    if (i == 0)
        return p->whole ? on_edge(w, p, 3, m - j) : on_edge(w, p, before, w->n - j);
    return (place){-1, 0};
}

/* ---- vertices ---- */

/* Texture coordinates of a sample, and with them the direction in which u rises. */
static void read_uv(const welder *w, uint32_t row, variant *v)
{
    double uv[2] = {0}, du[2] = {0}, dv[2] = {0};
    v->tangent = (kd_vec2){1, 0};
    if (!w->uv_values)
        return;
    for (uint32_t i = w->uv_rows.first[row]; i < w->uv_rows.first[row + 1]; i++) {
        const kd_vec2 *value = &w->uv_values[w->uv_rows.index[i]];
        const double at[2] = {(double)value->x, (double)value->y};
        for (int k = 0; k < 2; k++) {
            uv[k] += at[k] * (double)w->uv_rows.weight[i];
            du[k] += at[k] * (double)w->uv_rows.du[i];
            dv[k] += at[k] * (double)w->uv_rows.dv[i];
        }
    }
    double area = du[0] * dv[1] - dv[0] * du[1], larger = fmax(fabs(dv[1]), fabs(du[1]));
    v->uv = (kd_vec2){(float)uv[0], (float)uv[1]};
    v->mirrored = area < 0;
    if (area == 0 || !(larger > 0))
        return;
    double scale = (area < 0 ? -1 : 1) / larger;
    v->tangent = (kd_vec2){(float)(dv[1] * scale), (float)(-du[1] * scale)};
}

/* Texture coordinates of two patches at one point differ by rounding only, where they are the same. */
static bool near(float a, float b)
{
    return fabsf(a - b) <= 1e-5f * (1 + fabsf(a));
}

static bool same(const variant *a, const variant *b)
{
    return a->group == b->group && a->mirrored == b->mirrored && near(a->uv.x, b->uv.x) &&
           near(a->uv.y, b->uv.y);
}

static uint32_t vertex_for(welder *w, uint32_t row, place at)
{
    variant made = {.row = row, .point_row = row, .next = KD_NONE, .group = at.group};
    read_uv(w, row, &made);
    if (at.point >= 0) {
        uint32_t *link = &w->first[at.point];
        if (*link != KD_NONE)
            made.point_row = w->variants[*link].point_row;
        for (; *link != KD_NONE; link = &w->variants[*link].next)
            if (same(&w->variants[*link], &made))
                return *link;
        *link = w->variant_count;
    }
    w->variants[w->variant_count] = made;
    return w->variant_count++;
}

static void put_triangle(welder *w, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *out = &w->indices[w->index_count];
    out[0] = w->vertex_of[a];
    out[1] = w->vertex_of[b];
    out[2] = w->vertex_of[c];
    w->index_count += 3;
}

static void sample_square(welder *w, patch *p)
{
    uint32_t m = (uint32_t)p->segments, first = p->row;
    for (uint32_t j = 0; j <= m; j++)
        for (uint32_t i = 0; i <= m; i++, p->row++)
            w->vertex_of[p->row] = vertex_for(w, p->row, place_of(w, p, (int)i, (int)j));
    for (uint32_t j = 0; j < m; j++)
        for (uint32_t i = 0; i < m; i++) {
            uint32_t a = first + j * (m + 1) + i, d = a + m + 1;
            put_triangle(w, a, a + 1, d + 1);
            put_triangle(w, a, d + 1, d);
        }
}

static void sample_triangle(welder *w, patch *p)
{
    uint32_t m = (uint32_t)p->segments, row = p->row;
    for (uint32_t j = 0; j <= m; j++)
        for (uint32_t i = 0; i + j <= m; i++, p->row++)
            w->vertex_of[p->row] = vertex_for(w, p->row, place_of(w, p, (int)i, (int)j));
    for (uint32_t j = 0; j < m; row += m - j + 1, j++)
        for (uint32_t i = 0; i + j < m; i++) {
            uint32_t a = row + i, above = a + m - j + 1;
            put_triangle(w, a, a + 1, above);
            if (i + j + 1 < m)
                put_triangle(w, a + 1, above + 1, above);
        }
}

static void sample_faces(welder *w)
{
    patch p = {0};
    for (p.face = 0; p.face < w->cage->face_count; p.first_corner += p.size, p.face++) {
        int patches = subdiv_patches(w->cage, p.face);
        p.size = w->cage->face_sizes[p.face];
        p.whole = patches == 1;
        p.segments = subdiv_segments(w->cage, p.face, w->level);
        for (p.corner = 0; p.corner < patches && !w->topology->face_hole[p.face]; p.corner++)
            (w->cage->loop ? sample_triangle : sample_square)(w, &p);
    }
}

/* ---- rows ---- */

/* Enter one weight into entries [first, *end) that are in rising order of vertices. */
static kd_stencil *entry_of(kd_stencil *entries, uint32_t first, uint32_t *end, uint32_t vertex)
{
    uint32_t at = *end;
    while (at > first && entries[at - 1].vertex > vertex)
        at--;
    if (at > first && entries[at - 1].vertex == vertex)
        return &entries[at - 1];
    memmove(&entries[at + 1], &entries[at], (*end - at) * sizeof *entries);
    ++*end;
    entries[at] = (kd_stencil){.vertex = vertex};
    return &entries[at];
}

static void write_rows(const welder *w, subdiv_surface *out)
{
    const subdiv_rows *r = &w->rows;
    uint32_t end = 0;
    for (uint32_t v = 0; v < w->variant_count; v++) {
        const variant *from = &w->variants[v];
        uint32_t first = end;
        for (uint32_t i = r->first[from->point_row]; i < r->first[from->point_row + 1]; i++)
            entry_of(out->stencils, first, &end, (uint32_t)r->index[i])->weight += r->weight[i];
        for (uint32_t i = r->first[from->row]; i < r->first[from->row + 1]; i++) {
            kd_stencil *e = entry_of(out->stencils, first, &end, (uint32_t)r->index[i]);
            e->du += r->du[i];
            e->dv += r->dv[i];
        }
        out->rows[v] = (kd_stencil_row){first, end - first, from->tangent.x, from->tangent.y};
        out->handedness[v] = w->uv_values && !from->mirrored ? -1.0f : 1.0f;
        if (out->uv)
            out->uv[v] = from->uv;
    }
    out->stencil_count = end;
}

static size_t stencil_bound(const welder *w)
{
    size_t bound = 0;
    for (uint32_t v = 0; v < w->variant_count; v++) {
        const variant *from = &w->variants[v];
        bound += w->rows.first[from->row + 1] - w->rows.first[from->row];
        if (from->point_row != from->row)
            bound += w->rows.first[from->point_row + 1] - w->rows.first[from->point_row];
    }
    return bound;
}

/* ---- the whole ---- */

static size_t sample_count(const welder *w, size_t *triangles)
{
    size_t samples = 0;
    *triangles = 0;
    for (int f = 0; f < w->cage->face_count; f++) {
        size_t m = (size_t)subdiv_segments(w->cage, f, w->level),
               patches = w->topology->face_hole[f] ? 0 : (size_t)subdiv_patches(w->cage, f);
        samples += patches * (w->cage->loop ? (m + 1) * (m + 2) / 2 : (m + 1) * (m + 1));
        *triangles += patches * (w->cage->loop ? m * m : 2 * m * m);
    }
    return samples;
}

static kd_status weld(welder *w, size_t triangles, kd_arena *kept, kd_arena *work)
{
    const subdiv_cage *cage = w->cage;
    w->inner = cage->vertex_count + w->topology->edge_count * (w->n - 1);
    size_t points =
        (size_t)w->inner + (size_t)cage->face_count + (size_t)cage->corner_count * (size_t)(w->n / 2);
    int *mate = KD_ARENA_NEW(work, int, 2 * w->topology->edge_count + 1);
    w->group_of = KD_ARENA_NEW(work, uint32_t, cage->corner_count);
    w->first = KD_ARENA_NEW(work, uint32_t, points);
    w->vertex_of = KD_ARENA_NEW(work, uint32_t, w->rows.row_count);
    w->variants = KD_ARENA_NEW(work, variant, w->rows.row_count);
    w->indices = KD_ARENA_NEW(kept, uint32_t, triangles * 3);
    if (!mate || !w->group_of || !w->first || !w->vertex_of || !w->variants || !w->indices)
        return KD_NO_MEMORY;
    for (size_t i = 0; i < points; i++)
        w->first[i] = KD_NONE;
    group_corners(w, mate);
    sample_faces(w);
    return KD_OK;
}

static kd_status finish(welder *w, kd_arena *kept, subdiv_surface *out)
{
    size_t bound = stencil_bound(w);
    if (bound > INT32_MAX)
        return KD_NO_MEMORY;
    out->vertex_count = w->variant_count;
    out->index_count = w->index_count;
    out->indices = w->indices;
    out->rows = KD_ARENA_NEW(kept, kd_stencil_row, w->variant_count);
    out->stencils = KD_ARENA_NEW(kept, kd_stencil, bound + 1);
    out->handedness = KD_ARENA_NEW(kept, float, w->variant_count);
    out->uv = w->uv_values ? KD_ARENA_NEW(kept, kd_vec2, w->variant_count) : NULL;
    if (!out->rows || !out->stencils || !out->handedness || (w->uv_values && !out->uv))
        return KD_NO_MEMORY;
    write_rows(w, out);
    return KD_OK;
}

kd_status subdiv_surface_make(const subdiv_cage *cage, int level, const kd_vec2 *uv, kd_arena *kept,
                              kd_arena *work, subdiv_surface *out, char *error, size_t error_size)
{
    *out = (subdiv_surface){0};
    subdiv *s = subdiv_open(cage, subdiv_isolation(cage, level), error, error_size);
    if (!s)
        return KD_UNSUPPORTED;
    welder w = {.cage = cage, .topology = subdiv_topology_of(s), .level = level, .n = 1 << level};
    w.uv_values = cage->uv_corners ? uv : NULL;
    size_t triangles, samples = sample_count(&w, &triangles);
    snprintf(error, error_size, "out of memory while the cage is subdivided");
    kd_status status = subdiv_stencils(s, level, false, &w.rows, error, error_size);
    if (!status && w.uv_values)
        status = subdiv_stencils(s, level, true, &w.uv_rows, error, error_size);
    bool whole = w.rows.row_count == samples && (!w.uv_values || w.uv_rows.row_count == samples);
    if (!status && (!whole || !samples)) {
        snprintf(error, error_size, "%s",
                 samples ? "parts of the cage have no limit surface" : "the cage has no face with a surface");
        status = KD_UNSUPPORTED;
    }
    if (!status)
        status = weld(&w, triangles, kept, work);
    if (!status)
        status = finish(&w, kept, out);
    subdiv_close(s);
    return status;
}
