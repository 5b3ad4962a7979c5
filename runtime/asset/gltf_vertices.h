#ifndef KD_ASSET_GLTF_VERTICES_H
#define KD_ASSET_GLTF_VERTICES_H

/* The vertex attributes of one primitive, gathered for the vertices that its triangles use. */

#include "runtime/asset/gltf_loader.h"

typedef struct gltf_selection {
    const uint32_t *vertices; /* [vertex_count] elements of the accessors */
    uint32_t vertex_count;
    const uint32_t *indices; /* [index_count] into the selection */
    size_t index_count;
} gltf_selection;

/** Find an attribute's accessor, or -1. */
int gltf_find_attribute(const gltf_attributes *attributes, const char *name);

/** Fill everything of `out` but material and indices. source_count: elements each attribute must have. */
kd_status gltf_load_vertices(gltf_loader *l, const gltf_primitive *p, const char *where,
                             uint32_t source_count, const gltf_selection *s, gltf_mesh_facts *facts,
                             kd_primitive_desc *out);

#endif
