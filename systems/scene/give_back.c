/* Characters come and go; what they hold in the store is given back. A component that goes raises a flag, and
 * the next frame marks what entities still refer to and frees the rest: no counts to keep in step, and copies
 * of an entity, which share its parts, keep them alive. A frame in which nothing has gone costs one test. */

#include <stdlib.h>
#include <string.h>

#include "components/animation.h"
#include "runtime/core/log.h"
#include "runtime/ecs/observer.h"
#include "systems/scene/internal.h"

/* Frames after which buffers are cut to what is in use: what is spawned again meanwhile finds its room. */
#define TRIM_FRAMES 64

uint32_t scene_take(kd_ranges *ranges, uint32_t *end, uint32_t count)
{
    ranges->end = *end;
    uint32_t first = kd_ranges_take(ranges, count);
    *end = ranges->end;
    return first;
}

static void give(kd_ranges *ranges, uint32_t *end, uint32_t first, uint32_t count)
{
    ranges->end = *end;
    if (!kd_ranges_give(ranges, first, count))
        kd_log(KD_LOG_WARNING, "out of memory: room of an entity that left stays taken");
    *end = ranges->end;
}

/* A byte for each entry of a list: some entity refers to it. */
typedef struct marks {
    uint8_t *deformed, *joints, *nodes;
} marks;

static void mark_held(const kd_scene_store *s, const scene_internal *in, const marks *m)
{
    for (kd_iter it = kd_query_iter(in->holders); kd_iter_next(&it);) {
        const kd_mesh_instance *instances = KD_COLUMN(&it, kd_mesh_instance, 0);
        const kd_skin_instance *skins = KD_COLUMN(&it, kd_skin_instance, 1);
        for (uint32_t i = 0; i < it.count; i++) {
            if (instances[i].deformed && instances[i].deformed <= s->deformed_count)
                m->deformed[instances[i].deformed - 1] = 1;
            if (skins && skins[i].first_joint < s->joint_entity_count)
                m->joints[skins[i].first_joint] = 1;
        }
    }
    for (kd_iter it = kd_query_iter(in->players); kd_iter_next(&it);) {
        const kd_animation *animations = KD_COLUMN(&it, kd_animation, 0);
        for (uint32_t i = 0; i < it.count; i++)
            if (animations[i].first_node < s->node_entity_count)
                m->nodes[animations[i].first_node] = 1;
    }
}

/* Entries that were given back before are known by having no mesh. */
static bool is_free(const kd_store_deformed *d)
{
    return d->mesh == KD_NONE;
}

static void give_back_deformed(kd_scene_store *s, uint32_t number)
{
    scene_internal *in = s->internal;
    kd_store_deformed *d = &s->deformed[number];
    const kd_store_mesh *mesh = &s->meshes[d->mesh];
    for (uint32_t i = 0; i < mesh->primitive_count; i++) {
        const kd_store_primitive *own = &s->deformed_primitives[d->first_primitive + i];
        if (own->base_vertex != s->primitives[mesh->first_primitive + i].base_vertex)
            give(&in->vertices, &s->vertex_count, own->base_vertex, scene_primitive_vertices(own));
    }
    give(&in->deformed_primitives, &s->deformed_primitive_count, d->first_primitive, mesh->primitive_count);
    in->waiting_deformed -= d->waiting;
    *d = (kd_store_deformed){.mesh = KD_NONE};
    give(&in->deformed, &s->deformed_count, number, 1);
}

static bool any_marked(const uint8_t *marked, kd_range range)
{
    return range.count && memchr(marked + range.first, 1, range.count) != NULL;
}

static void give_back_unmarked(kd_scene_store *s, const marks *m)
{
    scene_internal *in = s->internal;
    for (uint32_t i = s->deformed_count; i-- > 0;)
        if (i < s->deformed_count && !m->deformed[i] && !is_free(&s->deformed[i]))
            give_back_deformed(s, i);
    for (uint32_t i = in->instance_count; i-- > 0;) {
        scene_instance *one = &in->instances[i];
        if (any_marked(m->joints, one->joints) || any_marked(m->nodes, one->nodes))
            continue;
        give(&in->joints, &s->joint_entity_count, one->joints.first, one->joints.count);
        give(&in->nodes, &s->node_entity_count, one->nodes.first, one->nodes.count);
        *one = in->instances[--in->instance_count];
    }
    if (in->uploaded_deformed > s->deformed_count)
        in->uploaded_deformed = s->deformed_count;
}

void scene_give_back(kd_scene_store *s)
{
    scene_internal *in = s->internal;
    size_t bytes = (size_t)s->deformed_count + s->joint_entity_count + s->node_entity_count;
    uint8_t *memory = calloc(bytes + 1, 1);
    marks m = {memory, memory + s->deformed_count, memory + s->deformed_count + s->joint_entity_count};
    if (!memory)
        return; /* the flag stays: tried again next frame */
    mark_held(s, in, &m);
    give_back_unmarked(s, &m);
    free(memory);
    in->something_left = false;
    in->trim_in = TRIM_FRAMES;
}

static void note_removal(kd_world *w, const kd_observed *what, void *user)
{
    kd_scene_store *s = kd_singleton(w, kd_scene_store);
    scene_internal *in = s->internal;
    (void)user;
    if (what->component == &kd_mesh_instance_desc && !((const kd_mesh_instance *)what->value)->deformed)
        return; /* rigid: holds nothing */
    if (in)
        in->something_left = true;
}

static const kd_component_desc *const watched[] = {&kd_mesh_instance_desc, &kd_skin_instance_desc,
                                                   &kd_animation_desc};

kd_status scene_give_back_init(kd_world *w, scene_internal *in)
{
    in->holders =
        kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(kd_mesh_instance), KD_OPTIONAL(kd_skin_instance)},
                                          .name = "scene.holders"});
    in->players =
        kd_query_make(w, &(kd_query_desc){.terms = {KD_READ(kd_animation)}, .name = "scene.players"});
    kd_status status = in->holders && in->players ? KD_OK : KD_NO_MEMORY;
    for (size_t i = 0; i < sizeof watched / sizeof *watched && status == KD_OK; i++)
        status = kd_observe(w, watched[i], KD_ON_REMOVE, note_removal, NULL);
    return status;
}

void scene_give_back_fini(kd_world *w, scene_internal *in)
{
    kd_query_destroy(in->holders);
    kd_query_destroy(in->players);
    in->holders = in->players = NULL;
    for (size_t i = 0; i < sizeof watched / sizeof *watched; i++)
        kd_unobserve(w, watched[i], note_removal, NULL);
}
