#include "runtime/asset/gltf_vertices.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/asset/mesh_build.h"

/* What is common to the attributes of a primitive while they are read. */
typedef struct reader {
    gltf_loader *l;
    const gltf_primitive *p;
    const gltf_selection *s;
    const char *where;
    uint32_t source_count;
} reader;

enum { IS_FLOAT = 1, IS_BYTE = 2, IS_UBYTE = 4, IS_SHORT = 8, IS_USHORT = 16 };
/* KHR_mesh_quantization allows the small integers wherever it makes sense. */
enum {
    ANY_SMALL = IS_FLOAT | IS_BYTE | IS_UBYTE | IS_SHORT | IS_USHORT,
    SIGNED_SMALL = IS_FLOAT | IS_BYTE | IS_SHORT,
    UNSIGNED_SMALL = IS_FLOAT | IS_UBYTE | IS_USHORT
};

int gltf_find_attribute(const gltf_attributes *attributes, const char *name)
{
    for (size_t i = 0; i < attributes->count; i++)
        if (strcmp(attributes->at[i].name, name) == 0)
            return attributes->at[i].accessor < 0 ? -2 : attributes->at[i].accessor;
    return -1;
}

static int type_bit(int component)
{
    switch (component) {
    case GLTF_FLOAT: return IS_FLOAT;
    case GLTF_BYTE: return IS_BYTE;
    case GLTF_UBYTE: return IS_UBYTE;
    case GLTF_SHORT: return IS_SHORT;
    case GLTF_USHORT: return IS_USHORT;
    default: return 0;
    }
}

/* Find and check one attribute. *found is false, without an error, when the file has none. */
static kd_status find_span(const reader *r, const gltf_attributes *from, const char *name, const char *where,
                           int types, int width_min, int width_max, gltf_span *span, bool *found)
{
    int accessor = gltf_find_attribute(from, name);
    *found = accessor != -1;
    if (!*found)
        return KD_OK;
    kd_status status = gltf_span_of(r->l, accessor, where, span);
    if (status)
        return status;
    if (!(type_bit(span->component) & types) || span->width < width_min || span->width > width_max)
        return gltf_fail(
            r->l, KD_BAD_FORMAT,
            "the attribute has a type that it may not have (%s, accessor %d); export the model again", where,
            accessor);
    if (span->count != r->source_count)
        return gltf_fail(r->l, KD_BAD_FORMAT,
                         "%u elements, but POSITION has %u (%s, accessor %d); export the model again",
                         span->count, r->source_count, where, accessor);
    return KD_OK;
}

/* Read a float attribute into the model: *out stays NULL when the file has none. */
static kd_status read_floats(const reader *r, const gltf_attributes *from, const char *name, int types,
                             int width_min, uint32_t row_floats, float **out)
{
    char where[112];
    snprintf(where, sizeof where, "%s.%s", r->where, name);
    gltf_span span;
    bool found;
    *out = NULL;
    kd_status status = find_span(r, from, name, where, types, width_min, (int)row_floats, &span, &found);
    if (status || !found)
        return status;
    status = gltf_alloc(r->l, &r->l->kept, (size_t)r->s->vertex_count * row_floats, sizeof(float), out);
    if (status)
        return status;
    if (span.width < (int)row_floats) /* an RGB colour is opaque */
        for (uint32_t i = 0; i < r->s->vertex_count; i++)
            (*out)[(size_t)i * row_floats + row_floats - 1] = 1;
    return gltf_read_floats(r->l, &span, r->s->vertices, r->s->vertex_count, *out, row_floats, where);
}

/* ---- positions, normals, tangents ---- */

static kd_status load_positions(const reader *r, kd_primitive_desc *out)
{
    float *positions;
    kd_status status = read_floats(r, &r->p->attributes, "POSITION", ANY_SMALL, 3, 3, &positions);
    if (status)
        return status;
    out->positions = (const kd_vec3 *)(void *)positions;
    out->bounds_min = out->bounds_max = out->positions[0];
    for (uint32_t i = 1; i < out->vertex_count; i++) {
        kd_vec3 p = out->positions[i];
        out->bounds_min = (kd_vec3){fminf(out->bounds_min.x, p.x), fminf(out->bounds_min.y, p.y),
                                    fminf(out->bounds_min.z, p.z)};
        out->bounds_max = (kd_vec3){fmaxf(out->bounds_max.x, p.x), fmaxf(out->bounds_max.y, p.y),
                                    fmaxf(out->bounds_max.z, p.z)};
    }
    return KD_OK;
}

static kd_status load_normals(const reader *r, kd_primitive_desc *out)
{
    float *read;
    kd_vec3 *normals, *scratch;
    kd_status status = read_floats(r, &r->p->attributes, "NORMAL", SIGNED_SMALL, 3, 3, &read);
    if (!status && !read)
        status = gltf_alloc(r->l, &r->l->kept, out->vertex_count, sizeof *normals, &normals);
    else
        normals = (kd_vec3 *)(void *)read;
    if (status)
        return status;
    out->normals = normals;
    if (!read && !r->p->cage) {
        mesh_flat_normals(out->positions, out->vertex_count, normals);
        return KD_OK;
    }
    status = gltf_alloc(r->l, &r->l->work, out->vertex_count, sizeof *scratch, &scratch);
    if (status)
        return status;
    size_t mended = mesh_mend_normals(out->positions, out->indices, out->index_count, normals,
                                      out->vertex_count, scratch);
    if (mended && read)
        gltf_warn(r->l, "%s.NORMAL: %zu normals have no length and are made from the triangles", r->where,
                  mended);
    return KD_OK;
}

static const kd_vec2 *tangent_uv(const reader *r, const kd_primitive_desc *out)
{
    if (out->material != KD_NONE) {
        const kd_texture_ref *map = &r->l->model->materials[out->material].normal_map;
        if (map->image != KD_NONE && map->uv_set == 1)
            return out->uv1;
    }
    return out->uv0;
}

/* Tangents of the file count only beside its normals (glTF 2.0, section 3.7.2.1). */
static kd_status load_tangents(const reader *r, kd_primitive_desc *out)
{
    float *read = NULL;
    kd_vec4 *tangents;
    kd_vec3 *scratch;
    kd_status status = KD_OK;
    if (gltf_find_attribute(&r->p->attributes, "NORMAL") != -1)
        status = read_floats(r, &r->p->attributes, "TANGENT", SIGNED_SMALL, 4, 4, &read);
    if (!status)
        status = gltf_alloc(r->l, &r->l->kept, out->vertex_count, sizeof *tangents, &tangents);
    if (!status)
        status = gltf_alloc(r->l, &r->l->work, (size_t)out->vertex_count * 2, sizeof *scratch, &scratch);
    if (status)
        return status;
    mesh_make_tangents(out->positions, out->normals, tangent_uv(r, out), out->indices, out->index_count,
                       tangents, out->vertex_count, scratch);
    for (uint32_t i = 0; read && i < out->vertex_count; i++) { /* one without a length keeps the made one */
        kd_vec3 t = {read[i * 4], read[i * 4 + 1], read[i * 4 + 2]};
        float length = kd_vec3_length(t);
        if (length > 1e-6f && isfinite(length))
            tangents[i] =
                (kd_vec4){t.x / length, t.y / length, t.z / length, read[i * 4 + 3] < 0 ? -1.0f : 1.0f};
    }
    out->tangents = tangents;
    return KD_OK;
}

/* ---- colours and texture coordinates ---- */

static kd_status load_uv_and_colors(const reader *r, kd_primitive_desc *out)
{
    float *uv0, *uv1 = NULL, *colors = NULL;
    const gltf_attributes *from = &r->p->attributes;
    kd_status status = read_floats(r, from, "TEXCOORD_0", ANY_SMALL, 2, 2, &uv0);
    if (!status)
        status = read_floats(r, from, "TEXCOORD_1", ANY_SMALL, 2, 2, &uv1);
    if (!status)
        status = read_floats(r, from, "COLOR_0", UNSIGNED_SMALL, 3, 4, &colors);
    for (size_t i = 0; !status && colors && i < (size_t)out->vertex_count * 4; i++)
        colors[i] = fmaxf(colors[i], 0);
    out->uv0 = (const kd_vec2 *)(void *)uv0;
    out->uv1 = (const kd_vec2 *)(void *)uv1;
    out->colors = (const kd_vec4 *)(void *)colors;
    return status;
}

/* ---- skin ---- */

typedef struct influence {
    uint32_t joint;
    float weight;
} influence;

/* Keep the four largest, in falling order, with sum 1. Returns false if there is no weight at all. */
static bool pick_four(influence *in, uint32_t count, uint16_t joints[4], kd_vec4 *weights)
{
    float sum = 0, picked[4] = {0};
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t best = k;
        for (uint32_t i = k + 1; i < count; i++)
            if (in[i].weight > in[best].weight)
                best = i;
        influence swap = in[k];
        in[k] = in[best];
        in[best] = swap;
        picked[k] = in[k].weight;
        joints[k] = (uint16_t)(picked[k] > 0 ? in[k].joint : 0);
        sum += picked[k];
    }
    if (!(sum > 0) || !isfinite(sum))
        return false;
    *weights = (kd_vec4){picked[0] / sum, picked[1] / sum, picked[2] / sum, picked[3] / sum};
    return true;
}

typedef struct skin_source {
    gltf_span joints[2];
    float *weights[2];
    uint32_t sets;
} skin_source;

static kd_status find_skin(const reader *r, skin_source *out)
{
    static const char *const names[2][2] = {{"JOINTS_0", "WEIGHTS_0"}, {"JOINTS_1", "WEIGHTS_1"}};
    for (uint32_t set = 0; set < 2; set++) {
        char where[112];
        bool found;
        snprintf(where, sizeof where, "%s.%s", r->where, names[set][0]);
        kd_status status = find_span(r, &r->p->attributes, names[set][0], where, IS_UBYTE | IS_USHORT, 4, 4,
                                     &out->joints[set], &found);
        if (!status)
            status =
                read_floats(r, &r->p->attributes, names[set][1], UNSIGNED_SMALL, 4, 4, &out->weights[set]);
        if (status)
            return status;
        if (found != (out->weights[set] != NULL))
            return gltf_fail(r->l, KD_BAD_FORMAT,
                             "joints and weights do not come together (%s); export the model again", where);
        if (!found)
            break;
        out->sets = set + 1;
    }
    return KD_OK;
}

/* Returns false for a negative weight. */
static bool gather(const reader *r, const skin_source *source, uint32_t vertex, influence in[8])
{
    for (uint32_t i = 0; i < source->sets * 4; i++) {
        in[i].joint = gltf_read_uint(&source->joints[i / 4], r->s->vertices[vertex], (int)(i % 4));
        in[i].weight = source->weights[i / 4][(size_t)vertex * 4 + i % 4];
        if (in[i].weight < 0)
            return false;
    }
    return true;
}

static kd_status load_skin(const reader *r, gltf_mesh_facts *facts, kd_primitive_desc *out)
{
    skin_source source = {0};
    uint16_t(*joints)[4] = NULL;
    kd_vec4 *weights = NULL;
    uint32_t bad = 0;
    kd_status status = find_skin(r, &source);
    if (status || !source.sets)
        return status;
    status = gltf_alloc(r->l, &r->l->kept, out->vertex_count, sizeof *joints, &joints);
    if (!status)
        status = gltf_alloc(r->l, &r->l->kept, out->vertex_count, sizeof *weights, &weights);
    if (status)
        return status;
    for (uint32_t v = 0; v < out->vertex_count; v++) {
        influence in[8];
        if (!gather(r, &source, v, in))
            return gltf_fail(r->l, KD_BAD_FORMAT,
                             "a joint weight is negative (%s.WEIGHTS_0, vertex %u); export the model again",
                             r->where, r->s->vertices[v]);
        if (!pick_four(in, source.sets * 4, joints[v], &weights[v])) {
            joints[v][0] = (uint16_t)in[0].joint;
            weights[v] = (kd_vec4){1, 0, 0, 0};
            bad++;
        }
        for (int k = 0; k < 4; k++)
            facts->max_joint = joints[v][k] > facts->max_joint ? joints[v][k] : facts->max_joint;
    }
    if (bad)
        gltf_warn(r->l, "%s.WEIGHTS_0: %u vertices have no weight and follow their first joint", r->where,
                  bad);
    facts->skinned = true;
    out->joints = (const uint16_t(*)[4])joints;
    out->weights = weights;
    return KD_OK;
}

/* ---- morph targets ---- */

/* Flat normals of the fully moved target, less those at rest: what a target adds to normals that were made.
 */
static kd_status flat_morph_normals(const reader *r, const kd_primitive_desc *out, const float *moves,
                                    float **normals)
{
    kd_vec3 *moved, *made;
    kd_status status = gltf_alloc(r->l, &r->l->work, out->vertex_count, sizeof *moved, &moved);
    if (!status)
        status = gltf_alloc(r->l, &r->l->kept, out->vertex_count, sizeof *made, &made);
    if (status)
        return status;
    for (uint32_t i = 0; i < out->vertex_count; i++)
        moved[i] =
            kd_vec3_add(out->positions[i], (kd_vec3){moves[i * 3], moves[i * 3 + 1], moves[i * 3 + 2]});
    mesh_flat_normals(moved, out->vertex_count, made);
    for (uint32_t i = 0; i < out->vertex_count; i++)
        made[i] = kd_vec3_sub(made[i], out->normals[i]);
    *normals = (float *)(void *)made;
    return KD_OK;
}

static kd_status load_target(const reader *r, size_t index, const kd_primitive_desc *out, float **moves,
                             float **normals)
{
    char where[112];
    snprintf(where, sizeof where, "%s.targets[%zu]", r->where, index);
    reader inner = *r;
    inner.where = where;
    const gltf_attributes *from = &r->p->targets[index];
    bool flat = gltf_find_attribute(&r->p->attributes, "NORMAL") == -1 && !r->p->cage;
    *normals = NULL;
    kd_status status = read_floats(&inner, from, "POSITION", ANY_SMALL, 3, 3, moves);
    if (!status && !flat)
        status = read_floats(&inner, from, "NORMAL", SIGNED_SMALL, 3, 3, normals);
    else if (!status && *moves)
        status = flat_morph_normals(&inner, out, *moves, normals);
    return status;
}

static kd_status load_targets(const reader *r, kd_primitive_desc *out)
{
    const kd_vec3 **moves, **normals;
    size_t count = r->p->target_count;
    kd_status status = gltf_alloc(r->l, &r->l->kept, count, sizeof *moves, &moves);
    if (!status)
        status = gltf_alloc(r->l, &r->l->kept, count, sizeof *normals, &normals);
    for (size_t i = 0; !status && i < count; i++) {
        float *m = NULL, *n = NULL;
        status = load_target(r, i, out, &m, &n);
        moves[i] = (const kd_vec3 *)(void *)m;
        normals[i] = (const kd_vec3 *)(void *)n;
    }
    out->morph_count = (uint32_t)count;
    out->morph_positions = moves;
    out->morph_normals = normals;
    return status;
}

kd_status gltf_load_vertices(gltf_loader *l, const gltf_primitive *p, const char *where,
                             uint32_t source_count, const gltf_selection *s, gltf_mesh_facts *facts,
                             kd_primitive_desc *out)
{
    reader r = {l, p, s, where, source_count};
    kd_status status = load_positions(&r, out);
    if (!status)
        status = load_normals(&r, out);
    if (!status)
        status = load_uv_and_colors(&r, out);
    if (!status)
        status = load_tangents(&r, out);
    if (!status)
        status = load_skin(&r, facts, out);
    if (!status)
        status = load_targets(&r, out);
    return status;
}
