/* Parameters of the voxels' objects: made for all in every frame, sent where they changed. */
#include "systems/voxel_pages/object_params.h"

#include <stdlib.h>
#include <string.h>

#include "systems/voxel_pages/page_layer.h"

static void fill_params(const kd_scene_store *store, const kd_voxel_scene *scene, const kd_voxel_object *o,
                        struct kd_voxel_object_params *p)
{
    const float *m = o->model_ws.m;
    for (int r = 0; r < 3; r++)
        p->model_ws[r] = (kd_gl_vec4){m[r], m[4 + r], m[8 + r], m[12 + r]};
    /* rows of the cofactor matrix: the inverse transpose up to a factor, and defined for flat matrices too */
    kd_vec3 x = {m[0], m[1], m[2]}, y = {m[4], m[5], m[6]}, z = {m[8], m[9], m[10]};
    kd_vec3 cx = kd_vec3_cross(y, z), cy = kd_vec3_cross(z, x), cz = kd_vec3_cross(x, y);
    float sign = kd_vec3_dot(x, cx) < 0 ? -1.0f : 1.0f;
    p->normal_ws[0] = (kd_gl_vec4){sign * cx.x, sign * cy.x, sign * cz.x, 0};
    p->normal_ws[1] = (kd_gl_vec4){sign * cx.y, sign * cy.y, sign * cz.y, 0};
    p->normal_ws[2] = (kd_gl_vec4){sign * cx.z, sign * cy.z, sign * cz.z, 0};
    const kd_store_primitive *d =
        o->deformed ? &store->deformed_primitives[o->deformed - 1] : &store->primitives[o->primitive];
    p->info =
        (kd_gl_uvec4){o->kind, o->first_matrix, store->primitives[o->primitive].first_index, d->base_vertex};
    kd_vec3 e = store->materials[o->material].desc.emissive;
    float scale = scene->brightest_emission > 0 ? 1 / scene->brightest_emission : 0;
    p->emission = (kd_gl_vec4){e.x * scale, e.y * scale, e.z * scale, 0};
}

void object_params_upload(object_params *params, kd_gpu *gpu, const kd_scene_store *store,
                          kd_voxel_scene *scene, stale_parts *stale)
{
    uint32_t n = scene->object_count;
    if (n > params->capacity) {
        struct kd_voxel_object_params *grown = realloc(params->rows, (size_t)n * 2 * sizeof *grown);
        if (!grown)
            return;
        memset(grown, 0, (size_t)n * 2 * sizeof *grown);
        params->rows = grown;
        params->capacity = n * 2;
    }
    size_t size = sizeof *params->rows;
    uint32_t first = n, end = 0;
    bool made = n && kd_gpu_buffer_size(gpu, scene->object_params) < params->capacity * size;
    if (!n || !page_stream_ensure(gpu, &scene->object_params, params->capacity * size, "voxels.objects"))
        return;
    for (uint32_t i = 0; i < n; i++) {
        if (!scene->objects[i].alive)
            continue; /* its primitive is a link of the free list */
        struct kd_voxel_object_params before = params->rows[i];
        fill_params(store, scene, &scene->objects[i], &params->rows[i]);
        if (memcmp(&before, &params->rows[i], size) == 0)
            continue;
        first = i < first ? i : first;
        end = i + 1;
        if (memcmp(&before.emission, &params->rows[i].emission, sizeof before.emission) != 0)
            for (uint32_t c = 0; c < scene->cascade_count; c++)
                if (scene->objects[i].segment_count[c])
                    stale_note(stale, scene, &scene->objects[i], c, false);
    }
    if (made)
        first = 0, end = n;
    if (first < end)
        kd_gpu_write_buffer(gpu, scene->object_params, first * size, params->rows + first,
                            (end - first) * size);
}

void object_params_fini(object_params *params)
{
    free(params->rows);
}
