#include "systems/voxel_cache/key.h"

#include <stdlib.h>
#include <string.h>

#include <xxhash.h>

#include "runtime/core/log.h"
#include "runtime/gpu/source.h"
#include "systems/voxel_cache/rebind.h"
#include "systems/voxel_cache/voxelizer.h"

/* Raised when code outside of the shaders changes what voxels look like: columns.c, creases.c, geodesic.c,
 * maker.c, pack.c of the scene. */
#define MAKER_VERSION 3u

kd_status keys_init(voxel_keys *keys)
{
    static const char *const paths[] = {"shaders/voxel_cache/mark.comp",
                                        "shaders/voxel_cache/accumulate.comp",
                                        "shaders/voxel_cache/pack.comp", "shaders/voxel_cache/bind.comp"};
    XXH64_state_t *state = XXH64_createState();
    kd_status status = state ? KD_OK : KD_NO_MEMORY;
    if (state)
        XXH64_reset(state, MAKER_VERSION);
    for (size_t i = 0; i < sizeof paths / sizeof *paths && !status; i++) {
        gpu_source source = {0};
        if (gpu_source_expand(&source, paths[i], NULL))
            XXH64_update(state, source.text, strlen(source.text));
        else
            status = KD_GPU;
        gpu_source_fini(&source);
    }
    keys->program = state && !status ? XXH64_digest(state) : 0;
    XXH64_freeState(state);
    return status;
}

void keys_fini(voxel_keys *keys)
{
    free(keys->primitives);
    free(keys->images);
    *keys = (voxel_keys){0};
}

static bool reserve(uint64_t **hashes, uint32_t *capacity, uint32_t count)
{
    if (count <= *capacity)
        return true;
    uint32_t more = count + count / 2;
    uint64_t *grown = realloc(*hashes, more * sizeof *grown);
    if (!grown)
        return false;
    memset(grown + *capacity, 0, (more - *capacity) * sizeof *grown);
    *hashes = grown;
    *capacity = more;
    return true;
}

/* An array that may be missing; what is missing hashes otherwise than what is empty. */
static uint64_t hash_array(uint64_t seed, const void *items, size_t bytes)
{
    return items ? XXH3_64bits_withSeed(items, bytes, seed) : seed * 0x9E3779B97F4A7C15u + 1;
}

static uint64_t hash_primitive(const kd_primitive_desc *p)
{
    const size_t n = p->vertex_count;
    uint64_t h = hash_array(p->vertex_count, p->indices, p->index_count * sizeof *p->indices);
    h = hash_array(h, p->positions, n * sizeof *p->positions);
    h = hash_array(h, p->normals, n * sizeof *p->normals);
    h = hash_array(h, p->uv0, n * sizeof *p->uv0);
    h = hash_array(h, p->uv1, n * sizeof *p->uv1);
    h = hash_array(h, p->colors, n * sizeof *p->colors);
    h = hash_array(h, p->joints, n * sizeof *p->joints);
    h = hash_array(h, p->weights, n * sizeof *p->weights);
    return hash_array(h, &p->bounds_min, 2 * sizeof p->bounds_min) | 1;
}
_Static_assert(offsetof(kd_primitive_desc, bounds_max) ==
                   offsetof(kd_primitive_desc, bounds_min) + sizeof(kd_vec3),
               "both bounds are hashed at once");

static const kd_image *find_image(const kd_scene_store *store, uint32_t number)
{
    for (uint32_t i = 0; i < store->model_count; i++) {
        const kd_store_model *m = &store->models[i];
        if (number >= m->first_image && number - m->first_image < m->model->image_count)
            return &m->model->images[number - m->first_image];
    }
    return NULL;
}

/* What a map shows, and how it lies on the surface. */
static bool hash_map(voxel_keys *keys, const kd_scene_store *store, const kd_texture_ref *map, uint64_t *hash)
{
    const kd_image *image = map->image == KD_NONE ? NULL : find_image(store, map->image);
    if (!image)
        return true;
    if (!reserve(&keys->images, &keys->image_capacity, map->image + 1))
        return false;
    uint64_t *pixels = &keys->images[map->image];
    if (!*pixels)
        *pixels = hash_array(image->width, image->rgba, (size_t)image->width * image->height * 4) | 1;
    const float place[5] = {map->offset.x, map->offset.y, map->scale.x, map->scale.y, map->rotation};
    const uint32_t how[4] = {map->uv_set, map->wrap_s, map->wrap_t, map->nearest};
    *hash = hash_array(hash_array(hash_array(*hash, pixels, sizeof *pixels), place, sizeof place), how,
                       sizeof how);
    return true;
}

static bool hash_material(voxel_keys *keys, const kd_scene_store *store, const kd_material_desc *m,
                          uint64_t *hash)
{
    const float cutoff = m->alpha_mode == KD_ALPHA_MASK ? m->alpha_cutoff
                         : m->alpha_ignored             ? -m->transmission
                                                        : m->transmission;
    const uint32_t how[3] = {m->alpha_mode, m->double_sided, kd_material_glows(m)};
    *hash = hash_array(hash_array(hash_array(*hash, &m->base_color, sizeof m->base_color), how, sizeof how),
                       &cutoff, sizeof cutoff);
    if (!hash_map(keys, store, &m->base_color_map, hash))
        return false;
    *hash += 0x85EBCA77C2B2AE63u; /* the same map as the other is something else */
    return hash_map(keys, store, &m->emissive_map, hash);
}

bool keys_of(voxel_keys *keys, const kd_scene_store *store, const kd_voxel_scene *scene,
             const kd_voxel_cache *c, kd_voxel_key *out)
{
    uint64_t material = keys->program;
    if (!reserve(&keys->primitives, &keys->primitive_capacity, c->primitive + 1) ||
        !hash_material(keys, store, &store->materials[c->material].desc, &material))
        return false;
    if (voxelizer_flags(scene, c) & KD_VOXEL_LEVEL_GEODESIC &&
        rebind_hash(store, c->primitive, &material) != KD_OK)
        return false;
    if (!keys->primitives[c->primitive])
        keys->primitives[c->primitive] = hash_primitive(c->desc);
    struct {
        uint64_t primitive, material;
        float place[5];
        int32_t tile[4];
        uint32_t how[3];
    } all = {keys->primitives[c->primitive],
             material,
             {c->span, c->phase.x, c->phase.y, c->phase.z, c->tile.tiled ? c->tile.edge : 0},
             {c->tile.tiled, c->tile.x, c->tile.y, c->tile.z},
             {c->kind, voxelizer_flags(scene, c), KD_VOXEL_FILE_VERSION}};
    _Static_assert(sizeof all == 64, "no padding is hashed");
    XXH128_hash_t h = XXH3_128bits(&all, sizeof all);
    *out = (kd_voxel_key){h.low64, h.high64};
    return true;
}
