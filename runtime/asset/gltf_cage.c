/* Checks of a cage: everything OpenSubdiv takes for granted, so that what it is given cannot make it crash,
 * hang or eat memory. */

#include "runtime/asset/gltf_cage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Each of the faces round a vertex depends on all of them: work rises with the square of their number. */
#define VALENCE_MAX 64
/* Estimated entries of all rows, 16 bytes each; a square of a level-3 cage has some 81 rows of 16 to 20. */
#define STENCILS_MAX ((uint64_t)24 << 20)

typedef struct checker {
    gltf_loader *l;
    const gltf_cage *from;
    const char *where;
    uint32_t vertex_count;
    gltf_cage_faces *out;
} checker;

#define BAD(c, ...) gltf_fail((c)->l, KD_BAD_FORMAT, __VA_ARGS__)

/* ---- words ---- */

static kd_status read_word(const checker *c, const char *text, const char *name, const char *const *words,
                           int *out)
{
    if (!text)
        return KD_OK;
    for (int i = 0; words[i]; i++)
        if (strcmp(text, words[i]) == 0) {
            *out = i;
            return KD_OK;
        }
    return BAD(c, "'%.40s' is no %s (%s.extras.%s); use one of USD's words", text, name, c->where, name);
}

static kd_status read_words(const checker *c)
{
    static const char *const schemes[] = {"catmullClark", "loop", NULL};
    static const char *const boundaries[] = {"none", "edgeOnly", "edgeAndCorner", NULL};
    static const char *const uv_rules[] = {
        "none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all", NULL};
    int scheme = 0, boundary = SUBDIV_EDGE_AND_CORNER, uv_rule = SUBDIV_UV_CORNERS_PLUS1;
    kd_status status = read_word(c, c->from->scheme, "subdivisionScheme", schemes, &scheme);
    if (!status)
        status = read_word(c, c->from->boundary, "interpolateBoundary", boundaries, &boundary);
    if (!status)
        status = read_word(c, c->from->uv_rule, "faceVaryingLinearInterpolation", uv_rules, &uv_rule);
    c->out->cage.loop = scheme == 1;
    c->out->cage.boundary = (subdiv_boundary)boundary;
    c->out->cage.uv_rule = (subdiv_uv_rule)uv_rule;
    return status;
}

/* ---- faces ---- */

static kd_status check_face(const checker *c, size_t face, const int *corners, int size)
{
    if (size < 3 || size > VALENCE_MAX)
        return BAD(c, "face %zu has %d vertices (%s.extras.faceVertexCounts); faces have 3 to %d", face, size,
                   c->where, VALENCE_MAX);
    if (c->out->cage.loop && size != 3)
        return BAD(
            c, "face %zu has %d vertices (%s.extras.faceVertexCounts); the loop scheme takes triangles only",
            face, size, c->where);
    for (int i = 0; i < size; i++) {
        if ((uint32_t)corners[i] >= c->vertex_count)
            return BAD(c,
                       "face %zu names vertex %d of %u (%s.extras.faceVertexIndices); export the model again",
                       face, corners[i], c->vertex_count, c->where);
        for (int k = 0; k < i; k++)
            if (corners[k] == corners[i])
                return BAD(
                    c, "face %zu uses vertex %d twice (%s.extras.faceVertexIndices); export the model again",
                    face, corners[i], c->where);
    }
    return KD_OK;
}

static kd_status check_faces(const checker *c)
{
    const gltf_ints sizes = c->from->face_sizes, corners = c->from->corners;
    size_t used = 0;
    if (!sizes.count || corners.count > INT32_MAX / 8)
        return BAD(c, "the cage has %s faces (%s.extras.faceVertexCounts); export the model again",
                   sizes.count ? "too many" : "no", c->where);
    for (size_t f = 0; f < sizes.count; f++) {
        if ((size_t)sizes.at[f] > corners.count - used)
            return BAD(
                c,
                "%zu indices are fewer than the faces count (%s.extras.faceVertexIndices); export the model "
                "again",
                corners.count, c->where);
        kd_status status = check_face(c, f, corners.at + used, sizes.at[f]);
        if (status)
            return status;
        used += (size_t)sizes.at[f];
    }
    if (used != corners.count)
        return BAD(
            c,
            "%zu indices are more than the faces count, %zu (%s.extras.faceVertexIndices); export the model "
            "again",
            corners.count, used, c->where);
    c->out->cage.vertex_count = (int)c->vertex_count;
    c->out->cage.face_count = (int)sizes.count;
    c->out->cage.corner_count = (int)corners.count;
    c->out->cage.face_sizes = sizes.at;
    c->out->cage.corners = corners.at;
    return KD_OK;
}

/* ---- edges ---- */

typedef struct half_edge {
    uint32_t low, high, from; /* ends, and the one it leaves */
} half_edge;

static int compare_edges(const void *left, const void *right)
{
    const half_edge *a = left, *b = right;
    if (a->low != b->low)
        return a->low < b->low ? -1 : 1;
    return (a->high > b->high) - (a->high < b->high);
}

static half_edge edge_between(int a, int b)
{
    return (half_edge){(uint32_t)(a < b ? a : b), (uint32_t)(a < b ? b : a), (uint32_t)a};
}

static kd_status list_edges(const checker *c, half_edge **out)
{
    const subdiv_cage *cage = &c->out->cage;
    half_edge *edges;
    kd_status status = gltf_alloc(c->l, &c->l->work, (size_t)cage->corner_count, sizeof *edges, &edges);
    if (status)
        return status;
    for (int f = 0, first = 0; f < cage->face_count; first += cage->face_sizes[f], f++)
        for (int i = 0; i < cage->face_sizes[f]; i++)
            edges[first + i] =
                edge_between(cage->corners[first + i], cage->corners[first + (i + 1) % cage->face_sizes[f]]);
    qsort(edges, (size_t)cage->corner_count, sizeof *edges, compare_edges);
    *out = edges;
    return KD_OK;
}

static kd_status check_edges(const checker *c, const half_edge *edges)
{
    for (int i = 1; i < c->out->cage.corner_count; i++) {
        const half_edge *a = &edges[i - 1], *b = &edges[i];
        if (compare_edges(a, b) != 0)
            continue;
        if (i >= 2 && compare_edges(&edges[i - 2], b) == 0)
            return BAD(c,
                       "more than two faces share the edge of vertices %u and %u "
                       "(%s.extras.faceVertexIndices); part "
                       "them",
                       b->low, b->high, c->where);
        if (a->from == b->from)
            return BAD(c,
                       "two faces run along the edge of vertices %u and %u in one direction "
                       "(%s.extras.faceVertexIndices); turn one over",
                       b->low, b->high, c->where);
    }
    return KD_OK;
}

/* ---- sharpness ---- */

static kd_status read_sharpness(const checker *c, gltf_reals from, const char *name, float **out)
{
    kd_status status = gltf_alloc(c->l, &c->l->work, from.count, sizeof **out, out);
    for (size_t i = 0; !status && i < from.count; i++) {
        if (!(from.at[i] >= 0) || !isfinite(from.at[i]))
            return BAD(c,
                       "the sharpness %g at place %zu is not between 0 and 10 (%s.extras.%s); export the "
                       "model again",
                       from.at[i], i, c->where, name);
        (*out)[i] = (float)fmin(from.at[i], (double)SUBDIV_INFINITELY_SHARP);
    }
    return status;
}

/* USD gives each chain one sharpness, or each edge of each chain one. */
static kd_status check_chains(const checker *c, size_t *edges)
{
    const gltf_cage *from = c->from;
    size_t vertices = 0;
    for (size_t i = 0; i < from->crease_lengths.count; i++) {
        int length = from->crease_lengths.at[i];
        if (length < 2 || (size_t)length > from->creases.count - vertices)
            return BAD(
                c,
                "crease %zu has %d vertices of %zu that are left (%s.extras.creaseLengths); export the model "
                "again",
                i, length, from->creases.count - vertices, c->where);
        vertices += (size_t)length;
    }
    *edges = vertices - from->crease_lengths.count;
    if (vertices != from->creases.count)
        return BAD(c,
                   "%zu vertices of creases belong to none (%s.extras.creaseLengths); export the model again",
                   from->creases.count - vertices, c->where);
    size_t given = from->crease_sharpness.count;
    if (given != from->crease_lengths.count && given != *edges)
        return BAD(
            c,
            "%zu values are neither one a crease, %zu, nor one an edge, %zu (%s.extras.creaseSharpnesses); "
            "export the model again",
            given, from->crease_lengths.count, *edges, c->where);
    return KD_OK;
}

static kd_status check_crease(const checker *c, const half_edge *edges, int a, int b)
{
    half_edge wanted = edge_between(a, b);
    if (!bsearch(&wanted, edges, (size_t)c->out->cage.corner_count, sizeof *edges, compare_edges))
        return BAD(c,
                   "a crease runs from vertex %d to %d, where the cage has no edge "
                   "(%s.extras.creaseIndices); export "
                   "the model again",
                   a, b, c->where);
    return KD_OK;
}

static kd_status read_creases(const checker *c, const half_edge *edges)
{
    const gltf_cage *from = c->from;
    float *given, *sharpness;
    int *pairs;
    size_t count = 0, done = 0;
    kd_status status = check_chains(c, &count);
    if (!status)
        status = read_sharpness(c, from->crease_sharpness, "creaseSharpnesses", &given);
    if (!status)
        status = gltf_alloc(c->l, &c->l->work, count * 2, sizeof *pairs, &pairs);
    if (!status)
        status = gltf_alloc(c->l, &c->l->work, count, sizeof *sharpness, &sharpness);
    bool one_each = from->crease_sharpness.count == from->crease_lengths.count;
    const int *at = from->creases.at;
    for (size_t i = 0; !status && i < from->crease_lengths.count; at += from->crease_lengths.at[i], i++)
        for (int k = 0; !status && k + 1 < from->crease_lengths.at[i]; k++, done++) {
            pairs[2 * done] = at[k];
            pairs[2 * done + 1] = at[k + 1];
            sharpness[done] = given[one_each ? i : done];
            status = check_crease(c, edges, at[k], at[k + 1]);
        }
    if (status)
        return status;
    c->out->cage.crease_count = (int)count;
    c->out->cage.creases = pairs;
    c->out->cage.crease_sharpness = sharpness;
    return KD_OK;
}

static kd_status read_corners(const checker *c)
{
    const gltf_ints corners = c->from->sharp_corners;
    float *sharpness;
    if (corners.count != c->from->corner_sharpness.count)
        return BAD(c, "%zu values for %zu corners (%s.extras.cornerSharpnesses); export the model again",
                   c->from->corner_sharpness.count, corners.count, c->where);
    for (size_t i = 0; i < corners.count; i++)
        if ((uint32_t)corners.at[i] >= c->vertex_count)
            return BAD(c, "a corner names vertex %d of %u (%s.extras.cornerIndices); export the model again",
                       corners.at[i], c->vertex_count, c->where);
    kd_status status = read_sharpness(c, c->from->corner_sharpness, "cornerSharpnesses", &sharpness);
    if (status)
        return status;
    c->out->cage.sharp_corner_count = (int)corners.count;
    c->out->cage.sharp_corners = corners.at;
    c->out->cage.corner_sharpness = sharpness;
    return KD_OK;
}

/* ---- texture coordinates ---- */

static kd_status read_uv(const checker *c)
{
    const gltf_cage *from = c->from;
    kd_vec2 *uv;
    if (!from->uv.count && !from->uv_corners.count)
        return KD_OK;
    if (from->uv.count % 2 || from->uv_corners.count != from->corners.count)
        return BAD(
            c,
            "%zu numbers and %zu indices do not give each corner of a face two coordinates (%s.extras.st, "
            "stIndices); export the model again",
            from->uv.count, from->uv_corners.count, c->where);
    size_t count = from->uv.count / 2;
    for (size_t i = 0; i < from->uv_corners.count; i++)
        if ((size_t)from->uv_corners.at[i] >= count)
            return BAD(c,
                       "index %d at place %zu reaches beyond %zu coordinates (%s.extras.stIndices); export "
                       "the model "
                       "again",
                       from->uv_corners.at[i], i, count, c->where);
    kd_status status = gltf_alloc(c->l, &c->l->work, count, sizeof *uv, &uv);
    if (!status && !gltf_floats(from->uv.at, from->uv.count, &uv->x))
        status = BAD(c, "a coordinate is not finite (%s.extras.st); export the model again", c->where);
    c->out->uv = uv;
    c->out->cage.uv_count = (int)count;
    c->out->cage.uv_corners = from->uv_corners.at;
    return status;
}

/* ---- size ---- */

/* What rows a face's patches will have, from above: an irregular vertex brings in all its neighbours. */
static uint64_t face_cost(const subdiv_cage *cage, const int *corners, int face, const int *valence,
                          int level)
{
    int largest = cage->face_sizes[face];
    for (int i = 0; i < cage->face_sizes[face]; i++)
        largest = valence[corners[i]] > largest ? valence[corners[i]] : largest;
    uint64_t side = (uint64_t)subdiv_segments(cage, face, level) + 1;
    return (uint64_t)subdiv_patches(cage, face) * side * side * (uint64_t)(16 + 2 * largest);
}

static bool rounds_off(float sharpness)
{
    return sharpness > 0 && sharpness < SUBDIV_INFINITELY_SHARP;
}

static kd_status check_size(const checker *c)
{
    const subdiv_cage *cage = &c->out->cage;
    int *valence;
    uint8_t *creased;
    kd_status status = gltf_alloc(c->l, &c->l->work, c->vertex_count, sizeof *valence, &valence);
    if (!status)
        status = gltf_alloc(c->l, &c->l->work, c->vertex_count, 1, &creased);
    if (status)
        return status;
    for (int i = 0; i < cage->corner_count; i++)
        if (++valence[cage->corners[i]] > VALENCE_MAX)
            return gltf_fail(c->l, KD_TOO_LARGE,
                             "more than %d faces meet at vertex %d (%s.extras.faceVertexIndices); "
                             "give them fewer",
                             VALENCE_MAX, cage->corners[i], c->where);
    for (int i = 0; i < cage->crease_count; i++)
        creased[cage->creases[2 * i]] |= rounds_off(cage->crease_sharpness[i]);
    for (int i = 0; i < cage->sharp_corner_count; i++)
        creased[cage->sharp_corners[i]] |= rounds_off(cage->corner_sharpness[i]);
    uint64_t cost = 0;
    int level = (int)c->out->level, isolation = subdiv_isolation(cage, level);
    for (int f = 0, first = 0; f < cage->face_count; first += cage->face_sizes[f], f++) {
        bool deep = false;
        for (int i = 0; i < cage->face_sizes[f]; i++)
            deep |= creased[cage->corners[first + i]];
        cost +=
            face_cost(cage, cage->corners + first, f, valence, deep && isolation > level ? isolation : level);
    }
    if (cost > STENCILS_MAX)
        return gltf_fail(
            c->l, KD_TOO_LARGE,
            "level %u of a cage of %d faces takes some %llu million weights, more than %llu (%s.extras); "
            "lower subdiv.level",
            c->out->level, cage->face_count, (unsigned long long)(cost >> 20),
            (unsigned long long)(STENCILS_MAX >> 20), c->where);
    return KD_OK;
}

static kd_status read_level(const checker *c)
{
    uint32_t asked = c->l->options.subdiv_level;
    if (c->from->level > KD_SUBDIV_LEVEL_MAX)
        return gltf_fail(c->l, KD_TOO_LARGE, "level %lld is more than %u (%s.extras.level); lower it",
                         (long long)c->from->level, KD_SUBDIV_LEVEL_MAX, c->where);
    c->out->level = asked ? asked : c->from->level ? (uint32_t)c->from->level : KD_SUBDIV_LEVEL;
    return KD_OK;
}

kd_status gltf_check_cage(gltf_loader *l, const gltf_primitive *p, const char *where, uint32_t vertex_count,
                          gltf_cage_faces *out)
{
    checker c = {l, p->cage, where, vertex_count, out};
    half_edge *edges = NULL;
    kd_status status = read_words(&c);
    if (!status)
        status = check_faces(&c);
    if (!status)
        status = list_edges(&c, &edges);
    if (!status)
        status = check_edges(&c, edges);
    if (!status)
        status = read_creases(&c, edges);
    if (!status)
        status = read_corners(&c);
    if (!status)
        status = read_uv(&c);
    if (!status)
        status = read_level(&c);
    return status ? status : check_size(&c);
}

kd_status gltf_cage_triangles(gltf_loader *l, const gltf_cage_faces *faces, uint32_t **out, size_t *count)
{
    const subdiv_cage *cage = &faces->cage;
    uint32_t *indices;
    size_t triangles = (size_t)(cage->corner_count - 2 * cage->face_count), n = 0;
    kd_status status = gltf_alloc(l, &l->work, triangles * 3, sizeof *indices, &indices);
    if (status)
        return status;
    const int *corners = cage->corners;
    for (int f = 0; f < cage->face_count; corners += cage->face_sizes[f], f++)
        for (int i = 2; i < cage->face_sizes[f]; i++) {
            indices[n++] = (uint32_t)corners[0];
            indices[n++] = (uint32_t)corners[i - 1];
            indices[n++] = (uint32_t)corners[i];
        }
    *out = indices;
    *count = n;
    return KD_OK;
}
