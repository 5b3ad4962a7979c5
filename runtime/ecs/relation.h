#ifndef KD_ECS_RELATION_H
#define KD_ECS_RELATION_H

/* Relations between entities: a source, a target, and a value of the relation's type.
 *
 *     typedef struct likes { float how_much; } likes;
 *     KD_RELATION_DEFINE(likes, "likes", 0, KD_FIELD(likes, how_much, KD_F32, NULL, "0 to 1"));
 *     KD_RELATION_TAG_DEFINE(owned_by, "owned_by", KD_COMPONENT_EXCLUSIVE | KD_COMPONENT_CASCADE);
 *
 *     kd_relate_with(w, bob, likes, alice, {0.9f});
 *     kd_relate(w, sword, owned_by, bob);
 *     kd_entities things = kd_sources(w, bob, owned_by);    // things.at[0 … things.count - 1]
 *
 * A relation is a component whose every value has a target: it is described, registered and reflected like
 * one, and its id lives in the world. Pairs lie beside the tables, so that a target costs no table and
 * relating moves no row: 24 to 40 bytes a pair and its value. A world without pairs pays one test a death.
 *
 * Order: the targets of a source come in the order in which they were related. The sources of a target come
 * in that order too until one goes; then the last one takes its place. Both are the same at every run.
 *
 * As a component, an entity has a relation when it has any target: kd_has asks for that, kd_find gives the
 * first pair's value, kd_remove takes all its pairs, KD_WITH and KD_READ work on it in queries. What needs a
 * target refuses to work without one: kd_spawn and kd_set of a relation fail with a message.
 *
 * When an entity dies its pairs go, whichever end it is; with KD_COMPONENT_CASCADE the sources die with their
 * target, after it, with their children. Arrays and pointers are valid until the next structural change. */

#include "runtime/ecs/world.h"

typedef struct kd_entities {
    const kd_entity *at; /* [count] */
    uint32_t count;
} kd_entities;

/* ---- relating ---- */
/** Relate two entities, or set the value of a pair that is there (the old value is released). An exclusive
 * relation leaves its former target.
 *  Errors  NOT_FOUND when one is dead; UNSUPPORTED, with a message, when the component is no relation;
 *          NO_MEMORY, nothing is changed */
kd_status kd_relate_value(kd_world *w, kd_entity source, kd_value relation, kd_entity target);
/** Take a pair away. Does nothing when there is none. */
void kd_unrelate_id(kd_world *w, kd_entity source, kd_component_id relation, kd_entity target);
#define kd_relate(w, source, type, target) kd_relate_value((w), (source), KD_TAG(type), (target))
#define kd_relate_with(w, source, type, target, ...)                                                         \
    kd_relate_value((w), (source), KD_VAL(type, __VA_ARGS__), (target))
#define kd_unrelate(w, source, type, target) kd_unrelate_id((w), (source), KD_ID((w), type), (target))

/* ---- asking ---- */
/** Get the value of a pair. Returns NULL when there is no such pair.
 *  Cost  a search of the source's targets or of the target's sources, whichever are fewer, then of the former
 */
const void *kd_pair_find_id(const kd_world *w, kd_entity source, kd_component_id relation, kd_entity target);
/** Get it to write: marks the relation as changed. */
void *kd_pair_find_mut_id(kd_world *w, kd_entity source, kd_component_id relation, kd_entity target);
/** All targets of a source; count is 0 when it has none or is dead. */
kd_entities kd_targets_id(const kd_world *w, kd_entity source, kd_component_id relation);
/** The values of these pairs, in the order of kd_targets and as many. NULL when there are none, or no values.
 */
const void *kd_target_values_id(const kd_world *w, kd_entity source, kd_component_id relation);
/** All sources of a target: who likes it? */
kd_entities kd_sources_id(const kd_world *w, kd_entity target, kd_component_id relation);
/** The first target, the only one of an exclusive relation. Returns KD_NO_ENTITY when it has none. */
kd_entity kd_target_id(const kd_world *w, kd_entity source, kd_component_id relation);
/** Pairs of the relation in the world. */
uint32_t kd_pair_count_id(const kd_world *w, kd_component_id relation);

#define KD_RELATION_ID(w, type) KD_ID((kd_world *)(uintptr_t)(w), type)
#define kd_related(w, source, type, target)                                                                  \
    (kd_pair_find_id((w), (source), KD_RELATION_ID(w, type), (target)) != NULL)
#define kd_pair_find(w, source, type, target)                                                                \
    ((const type *)kd_pair_find_id((w), (source), KD_RELATION_ID(w, type), (target)))
#define kd_pair_find_mut(w, source, type, target)                                                            \
    ((type *)kd_pair_find_mut_id((w), (source), KD_ID((w), type), (target)))
#define kd_target(w, source, type)  kd_target_id((w), (source), KD_RELATION_ID(w, type))
#define kd_targets(w, source, type) kd_targets_id((w), (source), KD_RELATION_ID(w, type))
#define kd_target_values(w, source, type)                                                                    \
    ((const type *)kd_target_values_id((w), (source), KD_RELATION_ID(w, type)))
#define kd_sources(w, target, type) kd_sources_id((w), (target), KD_RELATION_ID(w, type))
#define kd_pair_count(w, type)      kd_pair_count_id((w), KD_RELATION_ID(w, type))

/* ---- recorded, from jobs and inside loops ---- */
/** Pending handles are allowed at both ends. What is dead by the merge is passed over. */
void kd_commands_relate(kd_commands *c, kd_entity source, kd_value relation, kd_entity target);
void kd_commands_unrelate(kd_commands *c, kd_entity source, const kd_component_desc *relation,
                          kd_entity target);

#endif
