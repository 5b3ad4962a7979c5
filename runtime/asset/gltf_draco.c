/* KHR_draco_mesh_compression: what Draco holds takes the place of the accessors that the primitive names,
 * whose counts and types still say what is expected. */

#include <stdio.h>
#include <string.h>

#include "runtime/asset/draco_shim.h"
#include "runtime/asset/gltf_loader.h"
#include "runtime/asset/gltf_vertices.h"

static kd_status draco_fail(gltf_loader *l, const char *where, const char *what)
{
    return gltf_fail(l, KD_BAD_FORMAT,
                     "%s (%s.extensions.KHR_draco_mesh_compression); export the model again", what, where);
}

/* Let an accessor read `count` tight elements. */
static kd_status replace(gltf_loader *l, int accessor, const char *where, uint32_t count, void **out)
{
    if (accessor < 0 || (size_t)accessor >= l->doc.accessor_count)
        return draco_fail(l, where, "it stands for an accessor that is not there");
    const gltf_accessor *a = &l->doc.accessors[accessor];
    uint32_t size = gltf_element_bytes(a);
    if (a->count != count || !size || a->width > 4)
        return draco_fail(l, where, "what is in it is not what the accessor announces");
    kd_status status = gltf_alloc(l, &l->scratch, count, size, out);
    if (!status)
        l->spans[accessor] = (gltf_span){.base = *out,
                                         .stride = size,
                                         .count = count,
                                         .component = a->component,
                                         .width = a->width,
                                         .normalized = a->normalized};
    return status;
}

static kd_status replace_indices(gltf_loader *l, const gltf_primitive *p, const char *where,
                                 const draco_shim *mesh)
{
    uint32_t count = draco_shim_triangles(mesh) * 3, *indices;
    if (p->indices < 0 || (size_t)p->indices >= l->doc.accessor_count)
        return draco_fail(l, where, "the primitive has no indices");
    if (l->doc.accessors[p->indices].count != count)
        return draco_fail(l, where, "what is in it is not what the accessor announces");
    kd_status status = gltf_alloc(l, &l->scratch, count, sizeof *indices, &indices);
    if (status)
        return status;
    draco_shim_indices(mesh, indices);
    l->spans[p->indices] = (gltf_span){.base = (const uint8_t *)indices,
                                       .stride = sizeof *indices,
                                       .count = count,
                                       .component = GLTF_UINT,
                                       .width = 1};
    return KD_OK;
}

static kd_status replace_all(gltf_loader *l, const gltf_primitive *p, const char *where,
                             const draco_shim *mesh)
{
    uint32_t points = draco_shim_points(mesh);
    if (points > GLTF_VERTICES_MAX || draco_shim_triangles(mesh) > GLTF_VERTICES_MAX / 3)
        return gltf_fail(l, KD_TOO_LARGE,
                         "more than the limit of %u vertices or indices (%s); split the mesh",
                         GLTF_VERTICES_MAX, where);
    kd_status status = replace_indices(l, p, where, mesh);
    for (size_t i = 0; !status && i < p->unique.count; i++) {
        void *values;
        int accessor = gltf_find_attribute(&p->attributes, p->unique.at[i].name);
        if (accessor == -1)
            return draco_fail(l, where, "it holds an attribute that the primitive lacks");
        status = replace(l, accessor, where, points, &values);
        if (!status &&
            !draco_shim_attribute(mesh, p->unique.at[i].accessor, l->doc.accessors[accessor].component,
                                  l->doc.accessors[accessor].width, values))
            status = draco_fail(l, where, "an attribute is missing or of another type");
    }
    return status;
}

kd_status gltf_unpack_primitive(gltf_loader *l, const gltf_primitive *p, const char *where)
{
    char error[128] = "";
    if (p->draco == -1)
        return KD_OK;
    if (p->draco < 0 || (size_t)p->draco >= l->doc.view_count)
        return draco_fail(l, where, "its buffer view is not there");
    if (p->mode != GLTF_TRIANGLES && p->mode != GLTF_STRIP)
        return draco_fail(l, where, "the primitive is no list of triangles");
    const gltf_view *view = &l->doc.views[p->draco];
    const uint8_t *bytes = gltf_view_bytes(l, view);
    if (!bytes)
        return draco_fail(l, where, "its buffer is not there");
    draco_shim *mesh;
    kd_status status = draco_shim_open(bytes, (size_t)view->length, &mesh, error, sizeof error);
    if (status)
        return gltf_fail(l, status, "Draco: %s (%s); export the model again", error, where);
    status = replace_all(l, p, where, mesh);
    draco_shim_close(mesh);
    return status;
}
