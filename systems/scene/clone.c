/* A copy of what hangs below an entity, with joints, animated nodes and deformed vertices of its own: the
 * store keeps those in lists that the components number, so that copied numbers would drive the original. */
#include <stdlib.h>
#include <string.h>

#include "components/animation.h"
#include "components/mesh_instance.h"
#include "runtime/core/log.h"
#include "runtime/ecs/instance.h"
#include "systems/scene/internal.h"
#include "systems/scene/scene.h"

typedef struct pair {
    kd_entity from, to;
} pair;

typedef struct copier {
    kd_world *world;
    kd_scene_store *store;
    pair *pairs; /* sorted by .from */
    uint32_t count;
} copier;

static int compare_pairs(const void *left, const void *right)
{
    const pair *a = left, *b = right;
    return (a->from.index > b->from.index) - (a->from.index < b->from.index);
}

/* What stands for an entity in the copy: itself, when it is no part of what was copied. */
static kd_entity copy_of(const copier *c, kd_entity e)
{
    const pair wanted = {.from = e};
    const pair *found = bsearch(&wanted, c->pairs, c->count, sizeof *c->pairs, compare_pairs);
    return found && kd_entity_equal(found->from, e) ? found->to : e;
}

/* Both subtrees have one shape, so that walking them in step pairs them. */
static bool pair_up(copier *c, kd_entity from, kd_entity to)
{
    uint32_t capacity = 0;
    for (kd_entity e = from; e.generation; e = scene_next_below(c->world, from, e))
        capacity++;
    c->pairs = calloc(capacity, sizeof *c->pairs);
    for (kd_entity a = from, b = to; c->pairs && a.generation; c->count++) {
        c->pairs[c->count] = (pair){a, b};
        a = scene_next_below(c->world, from, a);
        b = scene_next_below(c->world, to, b);
    }
    if (c->pairs)
        qsort(c->pairs, c->count, sizeof *c->pairs, compare_pairs);
    return c->pairs != NULL;
}

static kd_status reserve(const copier *c)
{
    kd_scene_store *s = c->store;
    scene_internal *in = s->internal;
    uint64_t joints = s->joint_entity_count, nodes = s->node_entity_count, deformed = s->deformed_count;
    uint64_t primitives = s->deformed_primitive_count, vertices = s->vertex_count;
    for (uint32_t i = 0; i < c->count; i++) {
        const kd_skin_instance *skin = kd_find(c->world, c->pairs[i].to, kd_skin_instance);
        const kd_animation *animation = kd_find(c->world, c->pairs[i].to, kd_animation);
        const kd_mesh_instance *mesh = kd_find(c->world, c->pairs[i].to, kd_mesh_instance);
        joints += skin ? s->skins[skin->skin].joint_count : 0;
        nodes += animation && animation->model ? s->models[animation->model - 1].model->node_count : 0;
        if (!mesh || !mesh->deformed)
            continue;
        const kd_store_mesh *stored = &s->meshes[mesh->mesh];
        deformed++;
        primitives += stored->primitive_count;
        for (uint32_t p = 0; p < stored->primitive_count; p++)
            vertices += scene_primitive_vertices(&s->primitives[stored->first_primitive + p]);
    }
    if (vertices >= INT32_MAX)
        return KD_TOO_LARGE;
    bool room = SCENE_RESERVE(in->instances, in->instance_capacity, in->instance_count + 2ull * c->count) &&
                SCENE_RESERVE(s->joint_entities, in->joint_capacity, joints) &&
                SCENE_RESERVE(s->node_entities, in->node_capacity, nodes) &&
                SCENE_RESERVE(s->deformed, in->deformed_capacity, deformed) &&
                SCENE_RESERVE(s->deformed_primitives, in->deformed_primitive_capacity, primitives);
    return room ? KD_OK : KD_NO_MEMORY;
}

/* Enter what stands for the `count` entities from `first` on at `at`. */
static void copy_list(const copier *c, kd_entity *list, uint32_t at, uint32_t first, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        list[at + i] = copy_of(c, list[first + i]);
}

static void copy_joints(const copier *c, kd_skin_instance *skin)
{
    kd_scene_store *s = c->store;
    scene_internal *in = s->internal;
    uint32_t count = s->skins[skin->skin].joint_count;
    uint32_t at = scene_take(&in->joints, &s->joint_entity_count, count);
    copy_list(c, s->joint_entities, at, skin->first_joint, count);
    in->instances[in->instance_count++] = (scene_instance){.joints = {at, count}};
    skin->first_joint = at;
}

static void copy_nodes(const copier *c, kd_animation *animation)
{
    kd_scene_store *s = c->store;
    scene_internal *in = s->internal;
    uint32_t count = s->models[animation->model - 1].model->node_count;
    uint32_t at = scene_take(&in->nodes, &s->node_entity_count, count);
    copy_list(c, s->node_entities, at, animation->first_node, count);
    in->instances[in->instance_count++] = (scene_instance){.nodes = {at, count}};
    animation->first_node = at;
}

static void renumber(const copier *c, kd_entity e)
{
    kd_scene_store *s = c->store;
    kd_skin_instance *skin = kd_find_mut(c->world, e, kd_skin_instance);
    kd_animation *animation = kd_find_mut(c->world, e, kd_animation);
    kd_mesh_instance *mesh = kd_find_mut(c->world, e, kd_mesh_instance);
    if (skin)
        copy_joints(c, skin);
    if (animation && animation->model)
        copy_nodes(c, animation);
    if (mesh && mesh->deformed) {
        mesh->deformed = scene_add_deformed(s, mesh->mesh, skin != NULL);
        s->deformed[mesh->deformed - 1].entity = e;
    }
}

kd_status kd_scene_clone(kd_world *w, kd_entity prototype, kd_entity parent, kd_entity *out)
{
    copier c = {.world = w, .store = scene_store_get(w)};
    *out = KD_NO_ENTITY;
    if (!c.store)
        return kd_fail(KD_NO_MEMORY, "out of memory");
    kd_status status = kd_instantiate(w, prototype, parent, 1, out);
    if (status != KD_OK)
        return status;
    status = pair_up(&c, prototype, *out) ? reserve(&c) : KD_NO_MEMORY;
    for (uint32_t i = 0; i < c.count && status == KD_OK; i++)
        renumber(&c, c.pairs[i].to);
    free(c.pairs);
    if (status == KD_OK)
        return KD_OK;
    kd_destroy(w, *out);
    *out = KD_NO_ENTITY;
    return kd_fail(status, "the copy could not be made: %s", kd_status_text(status));
}
