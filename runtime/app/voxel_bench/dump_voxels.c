/* Voxels of the dynamic pages in the world, of the caches in their models, and the objects that join them. */
#include <stdlib.h>
#include <string.h>

#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/app/voxel_bench/dump.h"
#include "runtime/app/voxel_bench/unpack.h"

/* ---- pages ---- */

typedef struct page_row {
    uint32_t object, cascade;
    int32_t cell[3];      /* low cell of the 2x2x2 block that it covers */
    uint32_t fraction[3]; /* share of the far cells, of 256 */
    float centre_m[3], normal[3];
} page_row;

static const dump_column page_columns[] = {
    {"object", "<u4"},     {"cascade", "<u4"},    {"x", "<i4"},          {"y", "<i4"},        {"z", "<i4"},
    {"fraction_x", "<u4"}, {"fraction_y", "<u4"}, {"fraction_z", "<u4"}, {"m_x", "<f4"},      {"m_y", "<f4"},
    {"m_z", "<f4"},        {"normal_x", "<f4"},   {"normal_y", "<f4"},   {"normal_z", "<f4"}, {NULL, NULL},
};

static void put_page_voxel(dump *d, const kd_voxel_scene *scene, const struct kd_voxel_segment *segment,
                           const uint32_t voxel[KD_PAGE_WORDS])
{
    uint32_t c = segment->chunk_cascade >> 28;
    page_row row = {.object = segment->object, .cascade = c};
    if (voxel[0] == KD_NO_VOXEL)
        return;
    for (int k = 0; k < 3; k++) {
        row.cell[k] = scene->origin_cells[c][k] + (int32_t)(voxel[0] >> (10 * k) & 1023u) - 1;
        row.fraction[k] = voxel[1] >> (8 * k) & 255u;
        row.centre_m[k] = ((float)row.cell[k] + 0.5f + (float)row.fraction[k] / 256) * scene->span[c];
    }
    unpack_normal(voxel[2], row.normal);
    dump_row(d, &row, sizeof row);
}

kd_status dump_pages(dump *d)
{
    const kd_voxel_scene *scene = kd_singleton(d->rig->world, kd_voxel_scene);
    const kd_voxel_pages *pages = &scene->pages[KD_LAYER_DYNAMIC];
    uint32_t slots = pages->page_count * KD_PAGE_SEGMENTS;
    kd_status status = dump_begin(d, "pages.bin");
    if (status != KD_OK)
        return status;
    struct kd_voxel_segment *segments = dump_read(d, pages->segments, 0, slots * sizeof *segments);
    uint32_t(*voxels)[KD_PAGE_WORDS] =
        dump_read(d, pages->voxels, 0, (size_t)slots * KD_SEGMENT_VOXELS * sizeof *voxels);
    if (segments && voxels) {
        for (uint32_t s = 0; s < slots; s++)
            for (uint32_t i = 0; i < segments[s].count; i++)
                put_page_voxel(d, scene, &segments[s], voxels[(size_t)s * KD_SEGMENT_VOXELS + i]);
        status = dump_end(d, "pages.bin", page_columns);
    } else {
        kd_file_out_cancel(&d->file);
        status = KD_NO_MEMORY;
    }
    free(segments);
    free(voxels);
    return status;
}

/* ---- caches ---- */

typedef struct cache_row {
    uint32_t cache;
    float centre[3], span, normal[3], albedo[3], emission;
} cache_row;

static const dump_column cache_columns[] = {
    {"cache", "<u4"},    {"x", "<f4"},        {"y", "<f4"},        {"z", "<f4"},        {"span", "<f4"},
    {"normal_x", "<f4"}, {"normal_y", "<f4"}, {"normal_z", "<f4"}, {"albedo_r", "<f4"}, {"albedo_g", "<f4"},
    {"albedo_b", "<f4"}, {"emission", "<f4"}, {NULL, NULL},
};

static void put_chunk(dump *d, uint32_t cache, const kd_voxel_chunk *chunk, uint32_t (*shape)[2],
                      const uint32_t *color)
{
    for (uint32_t i = chunk->first; i < chunk->first + chunk->count; i++) {
        cache_row row = {.cache = cache, .span = chunk->span};
        const float *origin = &chunk->origin.x;
        for (int k = 0; k < 3; k++)
            row.centre[k] = origin[k] + ((float)(shape[i][0] >> (10 * k) & 1023u) + 0.5f) * chunk->span;
        unpack_normal(shape[i][1], row.normal);
        unpack_color(color[i], row.albedo);
        row.emission = (float)(shape[i][1] >> 24) / 255.0f;
        dump_row(d, &row, sizeof row);
    }
}

kd_status dump_caches(dump *d)
{
    const kd_voxel_scene *scene = kd_singleton(d->rig->world, kd_voxel_scene);
    kd_status status = dump_begin(d, "caches.bin");
    if (status != KD_OK)
        return status;
    size_t end = scene->voxel_places.end;
    uint32_t(*shape)[2] = dump_read(d, scene->cache_shape, 0, end * 8);
    uint32_t *color = dump_read(d, scene->cache_color, 0, end * 4);
    if (shape && color) {
        for (uint32_t i = 0; i < scene->cache_count; i++)
            for (uint32_t k = 0;
                 scene->caches[i].alive && scene->caches[i].made && k < scene->caches[i].chunk_count; k++)
                put_chunk(d, i, &scene->chunks[scene->caches[i].first_chunk + k], shape, color);
        status = dump_end(d, "caches.bin", cache_columns);
    } else {
        kd_file_out_cancel(&d->file);
        status = KD_NO_MEMORY;
    }
    free(shape);
    free(color);
    return status;
}

/* ---- objects ---- */

typedef struct object_row {
    uint32_t object, entity, primitive, kind, dynamic, cache[KD_MAX_CASCADES], voxels[KD_MAX_CASCADES];
    float model_ws[16];
} object_row;

static const dump_column object_columns[] = {
    {"object", "<u4"},   {"entity", "<u4"},   {"primitive", "<u4"}, {"kind", "<u4"},    {"dynamic", "<u4"},
    {"cache_0", "<u4"},  {"cache_1", "<u4"},  {"cache_2", "<u4"},   {"cache_3", "<u4"}, {"voxels_0", "<u4"},
    {"voxels_1", "<u4"}, {"voxels_2", "<u4"}, {"voxels_3", "<u4"},  {"m00", "<f4"},     {"m10", "<f4"},
    {"m20", "<f4"},      {"m30", "<f4"},      {"m01", "<f4"},       {"m11", "<f4"},     {"m21", "<f4"},
    {"m31", "<f4"},      {"m02", "<f4"},      {"m12", "<f4"},       {"m22", "<f4"},     {"m32", "<f4"},
    {"m03", "<f4"},      {"m13", "<f4"},      {"m23", "<f4"},       {"m33", "<f4"},     {NULL, NULL},
};

kd_status dump_objects(dump *d)
{
    const kd_voxel_scene *scene = kd_singleton(d->rig->world, kd_voxel_scene);
    kd_status status = dump_begin(d, "objects.bin");
    for (uint32_t i = 0; i < scene->object_count && status == KD_OK; i++) {
        const kd_voxel_object *o = &scene->objects[i];
        object_row row = {.object = i,
                          .entity = o->entity.index,
                          .primitive = o->primitive,
                          .kind = o->kind,
                          .dynamic = o->dynamic};
        if (!o->alive)
            continue;
        for (uint32_t c = 0; c < KD_MAX_CASCADES; c++) {
            bool in_pages = c < scene->cascade_count && o->segment_count[c];
            row.cache[c] = in_pages ? o->caches[c] - 1 : KD_EMPTY;
            row.voxels[c] = in_pages ? o->voxels[c] : 0;
        }
        memcpy(row.model_ws, o->model_ws.m, sizeof row.model_ws);
        dump_row(d, &row, sizeof row);
    }
    return status == KD_OK ? dump_end(d, "objects.bin", object_columns) : status;
}
