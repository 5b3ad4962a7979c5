/* Meshes: each primitive becomes an indexed triangle list of its own. Vertices that its triangles do not
 * touch are left behind, so that primitives sharing one large buffer do not each carry all of it. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/asset/gltf_cage.h"
#include "runtime/asset/gltf_loader.h"
#include "runtime/asset/gltf_vertices.h"
#include "runtime/asset/mesh_build.h"

/* ---- triangles ---- */

static kd_status read_indices(gltf_loader *l, const gltf_primitive *p, const char *mesh_where,
                              uint32_t vertex_count, uint32_t **out, size_t *count)
{
    char where[96];
    snprintf(where, sizeof where, "%s.indices", mesh_where);
    gltf_span span = {.count = vertex_count};
    kd_status status = p->indices == -1 ? KD_OK : gltf_span_of(l, p->indices, where, &span);
    if (status)
        return status;
    bool is_unsigned =
        span.component == GLTF_UBYTE || span.component == GLTF_USHORT || span.component == GLTF_UINT;
    if (p->indices != -1 && (span.width != 1 || !is_unsigned))
        return gltf_fail(l, KD_BAD_FORMAT,
                         "indices are not unsigned integers (%s, accessor %d); export the model again", where,
                         p->indices);
    uint32_t *indices;
    status = gltf_alloc(l, &l->work, span.count, sizeof *indices, &indices);
    if (status)
        return status;
    for (uint32_t i = 0; i < span.count; i++) {
        indices[i] = p->indices == -1 ? i : gltf_read_uint(&span, i, 0);
        if (indices[i] >= vertex_count)
            return gltf_fail(
                l, KD_BAD_FORMAT,
                "index %u at place %u reaches beyond %u vertices (%s, accessor %d); export the model again",
                indices[i], i, vertex_count, where, p->indices);
    }
    *out = indices;
    *count = span.count;
    return KD_OK;
}

static kd_status make_triangles(gltf_loader *l, const gltf_primitive *p, const char *where,
                                uint32_t vertex_count, uint32_t **out, size_t *out_count)
{
    uint32_t *raw = NULL, *unrolled;
    size_t count = 0;
    kd_status status = read_indices(l, p, where, vertex_count, &raw, &count);
    if (status)
        return status;
    mesh_topology topology = p->mode == GLTF_STRIP ? MESH_STRIP : p->mode == GLTF_FAN ? MESH_FAN : MESH_LIST;
    if (topology == MESH_LIST && count % 3)
        gltf_warn(l, "%s: %zu indices are no multiple of three; the last are left out", where, count);
    *out = raw;
    *out_count = count / 3 * 3;
    if (topology == MESH_LIST)
        return KD_OK;
    status = gltf_alloc(l, &l->work, mesh_unroll_bound(topology, count), sizeof *unrolled, &unrolled);
    if (status)
        return status;
    *out_count = mesh_unroll(topology, raw, count, unrolled);
    *out = unrolled;
    return KD_OK;
}

/* ---- which vertices stay ---- */

/* Number the vertices in use in rising order, and rewrite the indices. */
static kd_status select_used(gltf_loader *l, uint32_t vertex_count, gltf_selection *s)
{
    uint32_t *number, *select, *indices, used = 0;
    kd_status status = gltf_alloc(l, &l->work, vertex_count, sizeof *number, &number);
    if (!status)
        status = gltf_alloc(l, &l->kept, s->index_count, sizeof *indices, &indices);
    if (status)
        return status;
    for (size_t i = 0; i < s->index_count; i++)
        number[s->indices[i]] = 1;
    for (uint32_t v = 0; v < vertex_count; v++)
        used += number[v];
    status = gltf_alloc(l, &l->work, used, sizeof *select, &select);
    if (status)
        return status;
    for (uint32_t v = 0, n = 0; v < vertex_count; v++)
        if (number[v]) {
            select[n] = v;
            number[v] = n++;
        }
    for (size_t i = 0; i < s->index_count; i++)
        indices[i] = number[s->indices[i]];
    *s = (gltf_selection){select, used, indices, s->index_count};
    return KD_OK;
}

/* Flat normals need each corner to be a vertex of its own. */
static kd_status select_corners(gltf_loader *l, gltf_selection *s)
{
    uint32_t *indices;
    kd_status status = gltf_alloc(l, &l->kept, s->index_count, sizeof *indices, &indices);
    if (status)
        return status;
    for (size_t i = 0; i < s->index_count; i++)
        indices[i] = (uint32_t)i;
    *s = (gltf_selection){s->indices, (uint32_t)s->index_count, indices, s->index_count};
    return KD_OK;
}

/* ---- a primitive ---- */

/* The primitive's material in the chosen variant; -1: none. */
static int material_of(const gltf_loader *l, const gltf_primitive *p)
{
    int material = l->variant != KD_NONE && p->variant_of ? p->variant_of[l->variant] : -1;
    return material == -1 ? p->material : material;
}

static kd_status load_primitive(gltf_loader *l, size_t mesh, const gltf_primitive *p, const char *where,
                                kd_primitive_desc *out)
{
    int position = gltf_find_attribute(&p->attributes, "POSITION");
    if (position == -1) {
        gltf_warn(l, "%s: has no positions and is left out", where);
        return KD_OK;
    }
    gltf_span span;
    gltf_selection selection = {0};
    uint32_t *triangles = NULL;
    char position_where[96];
    snprintf(position_where, sizeof position_where, "%s.POSITION", where);
    kd_status status = gltf_unpack_primitive(l, p, where);
    if (!status)
        status = gltf_span_of(l, position, position_where, &span);
    gltf_cage_faces faces = {0};
    if (!status && p->cage)
        status = gltf_check_cage(l, p, where, span.count, &faces);
    if (!status && p->cage)
        status = gltf_cage_triangles(l, &faces, &triangles, &selection.index_count);
    else if (!status)
        status = make_triangles(l, p, where, span.count, &triangles, &selection.index_count);
    if (status || !selection.index_count)
        return status;
    if (selection.index_count > GLTF_VERTICES_MAX)
        return gltf_fail(l, KD_TOO_LARGE, "%zu indices are more than the limit of %u (%s); split the mesh",
                         selection.index_count, GLTF_VERTICES_MAX, where);
    selection.indices = triangles;
    bool flat = gltf_find_attribute(&p->attributes, "NORMAL") == -1 && !p->cage;
    status = flat ? select_corners(l, &selection) : select_used(l, span.count, &selection);
    if (status)
        return status;
    int material = material_of(l, p);
    out->material = material == -1 ? KD_NONE : (uint32_t)material;
    out->indices = selection.indices;
    out->index_count = (uint32_t)selection.index_count;
    out->vertex_count = selection.vertex_count;
    status = gltf_load_vertices(l, p, where, span.count, &selection, &l->facts[mesh], out);
    if (!status && p->cage)
        status = gltf_subdivide(l, where, &faces, &selection, out);
    return status;
}

static kd_status check_primitive(gltf_loader *l, const gltf_primitive *p, const char *where)
{
    if (p->mode < GLTF_POINTS || p->mode > GLTF_FAN)
        return gltf_fail(l, KD_BAD_FORMAT, "%d is no primitive mode (%s); export the model again", p->mode,
                         where);
    int material = material_of(l, p);
    if (material < -1 || (material >= 0 && (size_t)material >= l->doc.material_count))
        return gltf_fail(l, KD_BAD_FORMAT, "there is no material %d (%s); export the model again", material,
                         where);
    return KD_OK;
}

/* ---- a mesh ---- */

static kd_status check_morphs(gltf_loader *l, const gltf_mesh *m, size_t index, kd_mesh_desc *out)
{
    size_t count = m->primitive_count ? m->primitives[0].target_count : 0;
    for (size_t i = 1; i < m->primitive_count; i++)
        if (m->primitives[i].target_count != count)
            return gltf_fail(
                l, KD_BAD_FORMAT,
                "primitives have different numbers of morph targets (meshes[%zu]); export the model again",
                index);
    if (count > GLTF_MORPHS_MAX)
        return gltf_fail(l, KD_TOO_LARGE,
                         "%zu morph targets are more than the limit of %u (meshes[%zu]); split the mesh",
                         count, GLTF_MORPHS_MAX, index);
    if (m->weights.count && m->weights.count != count)
        return gltf_fail(l, KD_BAD_FORMAT,
                         "%zu weights for %zu morph targets (meshes[%zu].weights); export the model again",
                         m->weights.count, count, index);
    float *weights;
    kd_status status = gltf_alloc(l, &l->kept, count, sizeof *weights, &weights);
    if (status)
        return status;
    if (!gltf_floats(m->weights.at, m->weights.count, weights))
        return gltf_fail(l, KD_BAD_FORMAT,
                         "a weight is not finite (meshes[%zu].weights); export the model again", index);
    out->morph_count = (uint32_t)count;
    out->morph_weights = weights;
    return KD_OK;
}

static kd_status load_mesh(gltf_loader *l, size_t index, kd_mesh_desc *out)
{
    const gltf_mesh *m = &l->doc.meshes[index];
    kd_primitive_desc *primitives;
    out->name = gltf_name(l, m->name, "mesh", index);
    kd_status status = check_morphs(l, m, index, out);
    if (!status)
        status = gltf_alloc(l, &l->kept, m->primitive_count, sizeof *primitives, &primitives);
    for (size_t i = 0; !status && i < m->primitive_count; i++) {
        char where[64];
        snprintf(where, sizeof where, "meshes[%zu].primitives[%zu]", index, i);
        kd_primitive_desc *p = &primitives[out->primitive_count];
        status = check_primitive(l, &m->primitives[i], where);
        if (!status && m->primitives[i].mode < GLTF_TRIANGLES) {
            gltf_warn(l, "%s: points and lines are not drawn and are left out", where);
            continue;
        }
        if (!status)
            status = load_primitive(l, index, &m->primitives[i], where, p);
        gltf_reset_work(l);
        out->primitive_count += p->index_count > 0;
    }
    out->primitives = primitives;
    return status;
}

kd_status gltf_load_meshes(gltf_loader *l)
{
    kd_mesh_desc *meshes;
    kd_status status = gltf_alloc(l, &l->kept, l->doc.mesh_count, sizeof *meshes, &meshes);
    if (!status)
        status = gltf_alloc(l, &l->scratch, l->doc.mesh_count, sizeof *l->facts, &l->facts);
    for (size_t i = 0; !status && i < l->doc.mesh_count; i++)
        status = load_mesh(l, i, &meshes[i]);
    l->model->meshes = meshes;
    l->model->mesh_count = (uint32_t)l->doc.mesh_count;
    return status;
}
