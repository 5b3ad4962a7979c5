/* Caches are shared by all objects of one primitive whose voxels lie alike: a table finds them by primitive,
 * material, kind, tile and the place of the lattice. An object says in every run which caches it wants; what
 * nothing has wanted for some time gives its voxels back. */
#include "systems/voxel_pages/caches.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/asset/model.h"
#include "runtime/asset/voxel_file.h"

/* Runs for which a cache stays after its last use: what leaves a cascade often comes back soon. */
#define KEEP_RUNS 64

/* Steps of a voxel's edge in which places of the lattice are told apart. Objects of one step share a cache; a
 * voxel off by half a step sheds less than a share of its splat that counts. */
#define PHASE_STEPS 64

/* Deforming meshes are not cut into tiles, since all of one moves at once: where one has more surface than a
 * square of this many cells, its voxels are coarser. */
#define DEFORMING_CELLS 2048

bool caches_same_tile(kd_voxel_tile a, kd_voxel_tile b)
{
    return a.tiled == b.tiled && (!a.tiled || (a.x == b.x && a.y == b.y && a.z == b.z && a.edge == b.edge));
}

uint32_t caches_tile_hash(kd_voxel_tile t)
{
    return t.tiled ? ((uint32_t)t.x * 73856093u) ^ ((uint32_t)t.y * 19349663u) ^ ((uint32_t)t.z * 83492791u)
                   : 0;
}

/* The point of the world's lattice in model space: voxels of an object that only moves, scales uniformly or
 * turns by right angles then fall on whole cells. A singular matrix has no inverse; its object is flat and
 * may lie anywhere. What moves has no place on the lattice. */
static kd_vec3 lattice_phase(const kd_voxel_object *o, float span)
{
    if (o->kind != KD_VOXEL_RIGID || o->dynamic)
        return (kd_vec3){0, 0, 0};
    kd_mat4 inverse = kd_mat4_inverse(&o->model_ws);
    kd_vec3 p = kd_mat4_point(&inverse, (kd_vec3){0, 0, 0});
    if (!isfinite(p.x) || !isfinite(p.y) || !isfinite(p.z))
        return (kd_vec3){0, 0, 0};
    return (kd_vec3){p.x - floorf(p.x / span) * span, p.y - floorf(p.y / span) * span,
                     p.z - floorf(p.z / span) * span};
}

static uint32_t phase_step(float phase, float span)
{
    return (uint32_t)(int32_t)lroundf(phase / span * PHASE_STEPS) & (PHASE_STEPS - 1);
}

static uint32_t phase_steps(kd_vec3 phase, float span)
{
    return phase_step(phase.x, span) | phase_step(phase.y, span) << 8 | phase_step(phase.z, span) << 16;
}

static float surface_of(const kd_primitive_desc *p)
{
    double doubled = 0;
    for (uint32_t i = 0; i + 2 < p->index_count; i += 3) {
        kd_vec3 a = p->positions[p->indices[i]], b = p->positions[p->indices[i + 1]],
                c = p->positions[p->indices[i + 2]];
        doubled += kd_vec3_length(kd_vec3_cross(kd_vec3_sub(b, a), kd_vec3_sub(c, a)));
    }
    return (float)(doubled / 2);
}

static float span_of(const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c)
{
    float span = scene->span[c] / o->cached_scale;
    if (o->kind == KD_VOXEL_RIGID)
        return span;
    kd_vec3 size = kd_vec3_sub(o->desc->bounds_max, o->desc->bounds_min);
    bool is_long = fmaxf(size.x, fmaxf(size.y, size.z)) > DEFORMING_CELLS * span;
    return is_long ? fmaxf(span, sqrtf(surface_of(o->desc)) / DEFORMING_CELLS) : span;
}

static uint32_t hash_of(const kd_voxel_cache *key)
{
    uint64_t h = ((uint64_t)key->primitive << 32 | key->material << 2 | key->kind) * 0x9E3779B97F4A7C15u;
    return (uint32_t)(h >> 32) ^ caches_tile_hash(key->tile) ^
           phase_steps(key->phase, key->span) * 0x85EBCA6Bu;
}

static bool serves(const kd_voxel_cache *c, const kd_voxel_cache *key)
{
    return c->primitive == key->primitive && c->material == key->material && c->kind == key->kind &&
           c->thin == key->thin && fabsf(c->span - key->span) < key->span * 1e-3f &&
           caches_same_tile(c->tile, key->tile) &&
           phase_steps(c->phase, c->span) == phase_steps(key->phase, key->span);
}

/* Number plus one, or 0. */
static uint32_t find(const voxel_caches *t, const kd_voxel_scene *scene, const kd_voxel_cache *key)
{
    uint32_t at = t->head_count ? t->heads[hash_of(key) & (t->head_count - 1)] : 0;
    while (at && !serves(&scene->caches[at - 1], key))
        at = scene->caches[at - 1].next;
    return at;
}

static void chain(voxel_caches *t, kd_voxel_scene *scene, uint32_t number)
{
    uint32_t *head = &t->heads[hash_of(&scene->caches[number]) & (t->head_count - 1)];
    scene->caches[number].next = *head;
    *head = number + 1;
}

static void unchain(voxel_caches *t, kd_voxel_scene *scene, uint32_t number)
{
    uint32_t *at = &t->heads[hash_of(&scene->caches[number]) & (t->head_count - 1)];
    while (*at != number + 1)
        at = &scene->caches[*at - 1].next;
    *at = scene->caches[number].next;
}

static kd_status grow_heads(voxel_caches *t, kd_voxel_scene *scene)
{
    if (t->live < t->head_count)
        return KD_OK;
    uint32_t count = t->head_count ? t->head_count * 2 : 64;
    uint32_t *heads = calloc(count, sizeof *heads);
    if (!heads)
        return KD_NO_MEMORY;
    free(t->heads);
    t->heads = heads;
    t->head_count = count;
    for (uint32_t i = 0; i < scene->cache_count; i++)
        if (scene->caches[i].alive)
            chain(t, scene, i);
    return KD_OK;
}

static kd_status grow_entries(voxel_caches *t, kd_voxel_scene *scene)
{
    if (t->free_head || scene->cache_count < t->capacity)
        return KD_OK;
    uint32_t capacity = t->capacity ? t->capacity * 2 : 64;
    kd_voxel_cache *grown = realloc(scene->caches, capacity * sizeof *grown);
    if (!grown)
        return KD_NO_MEMORY;
    scene->caches = grown;
    t->capacity = capacity;
    return KD_OK;
}

static kd_status add(voxel_caches *t, kd_voxel_scene *scene, const kd_voxel_cache *key, uint32_t *number)
{
    kd_status status = grow_heads(t, scene);
    if (!status)
        status = grow_entries(t, scene);
    if (status)
        return status;
    uint32_t at = t->free_head ? t->free_head - 1 : scene->cache_count++;
    if (t->free_head)
        t->free_head = scene->caches[at].next;
    scene->caches[at] = *key;
    chain(t, scene, at);
    t->live++;
    scene->unmade++;
    *number = at + 1;
    return KD_OK;
}

/* Thin voxels of two sizes leave gaps where cascades meet: the coarser must have all that the surface
 * touches, then no path by faces gets through there either. Voxels of deforming meshes part where skin
 * stretches, which a second layer closes. */
static bool is_thin(const kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c)
{
    return scene->voxelize_flags & KD_VOXEL_LEVEL_THIN && o->kind == KD_VOXEL_RIGID && c == 0;
}

/* Number plus one of the cache that serves an object in cascade c; entered when there is none. */
static kd_status ensure(voxel_caches *t, kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c,
                        uint32_t *number)
{
    float span = span_of(scene, o, c);
    const kd_voxel_cache key = {.alive = true,
                                .primitive = o->primitive,
                                .material = o->material,
                                .desc = o->desc,
                                .kind = o->kind,
                                .thin = is_thin(scene, o, c),
                                .span = span,
                                .phase = lattice_phase(o, span),
                                .tile = o->tile};
    *number = find(t, scene, &key);
    return *number ? KD_OK : add(t, scene, &key, number);
}

kd_status caches_want(voxel_caches *t, kd_voxel_scene *scene, kd_voxel_object *o, uint32_t c)
{
    kd_status status = o->caches[c] ? KD_OK : ensure(t, scene, o, c, &o->caches[c]);
    if (status)
        return status;
    kd_voxel_cache *cache = &scene->caches[o->caches[c] - 1];
    cache->wanted_at = t->run;
    cache->due = 0;
    return KD_OK;
}

kd_status caches_want_ahead(voxel_caches *t, kd_voxel_scene *scene, const kd_voxel_object *o, uint32_t c,
                            uint32_t frames)
{
    uint32_t number, before = t->live;
    kd_status status = ensure(t, scene, o, c, &number);
    if (status)
        return status;
    kd_voxel_cache *cache = &scene->caches[number - 1];
    if (t->live > before || cache->wanted_at != t->run)
        cache->due = frames;
    cache->wanted_at = t->run;
    return KD_OK;
}

static void release(voxel_caches *t, kd_voxel_scene *scene, uint32_t number)
{
    kd_voxel_cache *cache = &scene->caches[number];
    unchain(t, scene, number);
    kd_voxel_cache_drop(scene, cache);
    scene->unmade -= !cache->made;
    *cache = (kd_voxel_cache){.next = t->free_head};
    t->free_head = number + 1;
    t->live--;
}

void caches_end_run(voxel_caches *t, kd_voxel_scene *scene)
{
    for (uint32_t i = 0; i < scene->cache_count; i++) {
        const kd_voxel_cache *c = &scene->caches[i];
        if (c->alive && t->run - c->wanted_at > (c->made ? KEEP_RUNS : 0))
            release(t, scene, i);
    }
    t->run++;
}

void caches_fini(voxel_caches *t, kd_voxel_scene *scene)
{
    kd_ranges_fini(&scene->voxel_places);
    kd_ranges_fini(&scene->binding_places);
    kd_ranges_fini(&scene->chunk_places);
    free(t->heads);
    free(scene->caches);
    scene->caches = NULL;
    scene->cache_count = scene->unmade = 0;
    *t = (voxel_caches){0};
}
