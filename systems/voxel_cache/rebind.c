#include "systems/voxel_cache/rebind.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <xxhash.h>

#include "runtime/core/log.h"
#include "systems/voxel_cache/geodesic.h"

/* Whose voxels these are: a mesh of a model, and the skin that it is drawn with there. */
typedef struct owner {
    const kd_model *model;
    const kd_mesh_desc *mesh;
    const kd_skin_desc *skin;
} owner;

static bool find_owner(const kd_scene_store *store, uint32_t primitive, owner *out)
{
    for (uint32_t i = 0; i < store->model_count; i++) {
        const kd_store_model *m = &store->models[i];
        for (uint32_t n = 0; n < m->model->node_count; n++) {
            const kd_node_desc *node = &m->model->nodes[n];
            if (node->mesh == KD_NONE || node->skin == KD_NONE)
                continue;
            const kd_store_mesh *mesh = &store->meshes[m->first_mesh + node->mesh];
            if (primitive - mesh->first_primitive >= mesh->primitive_count)
                continue;
            *out = (owner){m->model, mesh->desc, &m->model->skins[node->skin]};
            return true;
        }
    }
    return false;
}

kd_status rebind_hash(const kd_scene_store *store, uint32_t primitive, uint64_t *hash)
{
    owner o;
    uint32_t *first;
    geodesic_bone *bones;
    if (!find_owner(store, primitive, &o))
        return KD_OK;
    kd_status status = geodesic_bones(o.model, o.skin, &first, &bones);
    if (status)
        return status;
    *hash = XXH3_64bits_withSeed(first, (o.skin->joint_count + 1u) * sizeof *first, *hash);
    for (uint32_t i = 0; i < first[o.skin->joint_count]; i++) {
        *hash = XXH3_64bits_withSeed(&bones[i].from, 2 * sizeof bones[i].from, *hash);
        *hash += bones[i].open_ended;
    }
    for (uint32_t i = 0; i < o.mesh->primitive_count; i++) {
        const kd_primitive_desc *p = &o.mesh->primitives[i];
        *hash = XXH3_64bits_withSeed(p->positions, p->vertex_count * sizeof *p->positions, *hash);
        *hash = XXH3_64bits_withSeed(p->indices, p->index_count * sizeof *p->indices, *hash);
    }
    free(first);
    free(bones);
    return KD_OK;
}
_Static_assert(offsetof(geodesic_bone, to) == sizeof(kd_vec3), "both ends are hashed at once");

/* Everything that is known of a cache's voxels while they are bound. */
typedef struct binding {
    uint32_t count;
    kd_vec3 *points; /* [count] their centres */
    uint16_t (*joints)[4];
    float (*weights)[4];
    uint32_t (*words)[KD_BINDING_WORDS];
} binding;

static kd_status open_binding(kd_gpu *gpu, const kd_voxel_scene *scene, const kd_voxel_chunk *chunks,
                              uint32_t count, binding *b)
{
    uint32_t done = 0, most = 0;
    for (uint32_t i = 0; i < count; i++) {
        b->count += chunks[i].count;
        most = chunks[i].count > most ? chunks[i].count : most;
    }
    uint32_t(*shape)[2] = malloc(most * sizeof *shape + 1);
    b->points = malloc(b->count * sizeof *b->points + 1);
    b->joints = malloc(b->count * sizeof *b->joints + 1);
    b->weights = malloc(b->count * sizeof *b->weights + 1);
    b->words = malloc(b->count * sizeof *b->words + 1);
    bool made = shape && b->points && b->joints && b->weights && b->words;
    for (uint32_t i = 0; made && i < count; i++) {
        const kd_voxel_chunk *c = &chunks[i];
        kd_gpu_read_buffer(gpu, scene->cache_shape, (size_t)c->first * 8, shape, c->count * sizeof *shape);
        for (uint32_t n = 0; n < c->count; n++, done++)
            for (int k = 0; k < 3; k++)
                (&b->points[done].x)[k] =
                    (&c->origin.x)[k] + ((float)(shape[n][0] >> (10 * k) & 1023u) + 0.5f) * c->span;
    }
    free(shape);
    return made ? KD_OK : KD_NO_MEMORY;
}

static void close_binding(binding *b)
{
    free(b->points);
    free(b->joints);
    free(b->weights);
    free(b->words);
}

/* As shaders/shared/voxel.h has it; the rounding goes to the largest. */
static void pack(const uint16_t joints[4], const float weights[4], uint32_t words[KD_BINDING_WORDS])
{
    uint32_t bytes[4], sum = 0;
    for (int k = 0; k < 4; k++)
        sum += bytes[k] = (uint32_t)lroundf(weights[k] * 255);
    bytes[0] += 255 - sum;
    words[0] = joints[0] | (uint32_t)joints[1] << 16;
    words[1] = joints[2] | (uint32_t)joints[3] << 16;
    words[2] = bytes[0] | bytes[1] << 8 | bytes[2] << 16 | bytes[3] << 24;
}

static void write_words(kd_gpu *gpu, const kd_voxel_scene *scene, const kd_voxel_chunk *chunks,
                        uint32_t count, binding *b)
{
    const size_t size = sizeof *b->words;
    for (uint32_t i = 0, at = 0; i < count; at += chunks[i++].count) {
        size_t place = chunks[i].first_binding * size, bytes = chunks[i].count * size;
        kd_gpu_read_buffer(gpu, scene->cache_binding, place, b->words[at], bytes);
        for (uint32_t n = at; n < at + chunks[i].count; n++)
            if (b->weights[n][0] > 0)
                pack(b->joints[n], b->weights[n], b->words[n]);
        kd_gpu_write_buffer(gpu, scene->cache_binding, place, b->words[at], bytes);
    }
}

static kd_status bind_body(kd_gpu *gpu, const kd_voxel_scene *scene, const owner *o,
                           const geodesic_body *body, const kd_voxel_chunk *chunks, uint32_t count)
{
    binding b = {0};
    uint32_t *first = NULL;
    geodesic_bone *bones = NULL;
    kd_status status = open_binding(gpu, scene, chunks, count, &b);
    if (!status)
        status = geodesic_bones(o->model, o->skin, &first, &bones);
    if (!status)
        status = geodesic_weights(body, first, bones, o->skin->joint_count, b.points, b.count, b.joints,
                                  b.weights);
    if (!status)
        write_words(gpu, scene, chunks, count, &b);
    free(first);
    free(bones);
    close_binding(&b);
    return status;
}

kd_status rebind_geodesic(kd_gpu *gpu, const kd_scene_store *store, const kd_voxel_scene *scene,
                          const kd_voxel_cache *cache, const kd_voxel_chunk *chunks, uint32_t count,
                          bool *told)
{
    owner o;
    geodesic_body body;
    if (!find_owner(store, cache->primitive, &o))
        return KD_OK;
    kd_status status = geodesic_body_make(o.mesh, cache->span, &body);
    if (status)
        return status;
    if (body.inside) {
        status = bind_body(gpu, scene, &o, &body, chunks, count);
    } else if (!*told) {
        kd_log(
            KD_LOG_WARNING,
            "%s: mesh %s is not closed or thinner than its voxels (nothing is inside); they are bound to the "
            "nearest surface: close it, or leave voxels.binding at nearest",
            o.model->path, o.mesh->name ? o.mesh->name : "without a name");
        *told = true;
    }
    geodesic_body_fini(&body);
    return status;
}
