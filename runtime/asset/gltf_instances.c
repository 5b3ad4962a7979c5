/* EXT_mesh_gpu_instancing: copies of a node's mesh, each with its own translation, rotation and scale. They
 * become nodes of their own, so that everything else need not know. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "runtime/asset/gltf_loader.h"
#include "runtime/asset/gltf_vertices.h"

static const struct {
    const char *name;
    int width;
    bool small; /* normalised bytes and shorts are allowed */
} parts[] = {{"TRANSLATION", 3, false}, {"ROTATION", 4, true}, {"SCALE", 3, false}};
enum { TRANSLATION, ROTATION, SCALE, PARTS };

static kd_status part_span(gltf_loader *l, uint32_t node, int part, gltf_span *out)
{
    char where[96];
    int accessor = gltf_find_attribute(&l->doc.nodes[node].instances, parts[part].name);
    snprintf(where, sizeof where, "nodes[%u].extensions.EXT_mesh_gpu_instancing.%s", node, parts[part].name);
    *out = (gltf_span){0};
    if (accessor == -1)
        return KD_OK;
    kd_status status = gltf_span_of(l, accessor, where, out);
    if (status)
        return status;
    bool right =
        out->component == GLTF_FLOAT || (parts[part].small && out->normalized &&
                                         (out->component == GLTF_BYTE || out->component == GLTF_SHORT));
    return right && out->width == parts[part].width
               ? KD_OK
               : gltf_fail(l, KD_BAD_FORMAT,
                           "its type is not one that it may have (%s); export the model again", where);
}

static kd_status find_spans(gltf_loader *l, uint32_t node, gltf_span spans[PARTS], uint32_t *count)
{
    kd_status status = KD_OK;
    *count = 0;
    for (int part = 0; !status && part < PARTS; part++) {
        status = part_span(l, node, part, &spans[part]);
        if (!status && *count && spans[part].count && spans[part].count != *count)
            return gltf_fail(
                l, KD_BAD_FORMAT,
                "its lists differ in length (nodes[%u].extensions.EXT_mesh_gpu_instancing); export "
                "the model again",
                node);
        *count = spans[part].count ? spans[part].count : *count;
    }
    return status;
}

static bool has_copies(const gltf_loader *l, uint32_t node)
{
    return l->doc.nodes[node].instances.count && l->doc.nodes[node].mesh != -1;
}

kd_status gltf_count_instances(gltf_loader *l, uint32_t node, size_t *count)
{
    gltf_span spans[PARTS];
    uint32_t copies = 0;
    kd_status status = has_copies(l, node) ? find_spans(l, node, spans, &copies) : KD_OK;
    *count += copies;
    return status;
}

static kd_status read_copy(gltf_loader *l, const gltf_span spans[PARTS], uint32_t index, kd_node_desc *out)
{
    float values[PARTS][4] = {{0, 0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1, 0}};
    kd_status status = KD_OK;
    for (int part = 0; !status && part < PARTS; part++)
        if (spans[part].count)
            status = gltf_read_floats(l, &spans[part], &index, 1, values[part], (uint32_t)parts[part].width,
                                      parts[part].name);
    const float *t = values[TRANSLATION], *q = values[ROTATION], *s = values[SCALE];
    out->translation = (kd_vec3){t[0], t[1], t[2]};
    out->rotation = kd_quat_normalize((kd_quat){q[0], q[1], q[2], q[3]});
    out->scale = (kd_vec3){s[0], s[1], s[2]};
    return status;
}

kd_status gltf_load_instances(gltf_loader *l, uint32_t node, uint32_t parent, kd_node_desc *nodes,
                              uint32_t *used)
{
    gltf_span spans[PARTS];
    uint32_t copies = 0;
    if (!has_copies(l, node))
        return KD_OK;
    kd_status status = find_spans(l, node, spans, &copies);
    for (uint32_t i = 0; !status && i < copies; i++) {
        kd_node_desc *out = &nodes[*used];
        *out = nodes[parent];
        out->parent = parent;
        out->has_matrix = false;
        out->matrix = KD_MAT4_IDENTITY;
        out->camera = out->light = KD_NONE;
        out->name = kd_arena_printf(&l->kept, "%s copy %u", nodes[parent].name, i);
        status =
            out->name ? read_copy(l, spans, i, out) : gltf_fail(l, KD_NO_MEMORY, "out of memory for names");
        (*used)++;
    }
    if (copies)
        nodes[parent].mesh = nodes[parent].skin = KD_NONE;
    return status;
}
