#ifndef KD_ECS_OBSERVER_H
#define KD_ECS_OBSERVER_H

/* Functions that are told when a component comes, is set, goes, or dies with its entity.
 *
 * When they run: a direct call (kd_spawn, kd_set, kd_remove, kd_destroy …) tells its observers after its
 * change is complete and before it returns; kd_world_merge after all commands were applied. So an observer
 * never sees a half-done change, and none runs while a query is iterated or on a worker. Events come in the
 * order of the changes, and observers of one event in the order of registration: the same at any thread
 * count.
 *
 * What they may do: everything. Changes that an observer makes take effect at once; the events of these
 * changes are told after those that wait already, before the outermost call returns. By then an entity may be
 * dead or changed again: ask kd_alive, kd_find. Observers that raise each other without end are stopped after
 * KD_MAX_EVENT_ROUNDS rounds with a message.
 *
 * What raises nothing: writing through a query's column or kd_find_mut (use kd_iter.changed_since), enable
 * bits, a change of parent, kd_world_destroy, restoring a snapshot. A component that nobody observes costs
 * one test a call. */

#include "runtime/ecs/world.h"

#define KD_MAX_EVENT_ROUNDS 64

typedef enum kd_event {
    KD_ON_ADD = 1,    /* the entity has it now and had not before; also when it is spawned with it */
    KD_ON_SET = 2,    /* kd_set on one that was there, by call or by command */
    KD_ON_REMOVE = 4, /* it is gone; also when the entity was destroyed */
    KD_ON_DESTROY =
        8, /* an entity that had it was destroyed; told after KD_ON_REMOVE of the same component */
} kd_event;

typedef struct kd_observed {
    kd_event event;
    kd_entity entity; /* dead after KD_ON_DESTROY; of a relation, the source */
    kd_entity target; /* of a relation, dead when that is why the pair went; else KD_NO_ENTITY */
    const kd_component_desc *component;
    const void *value; /* REMOVE, DESTROY: the bytes as they were (what they owned is released already), valid
                          for the call; NULL for tags, ADD and SET: see kd_find */
} kd_observed;

typedef void kd_observer_fn(kd_world *w, const kd_observed *what, void *user);

/** Register an observer of some events (kd_event bits) of a component. Errors NO_MEMORY.
 *  Threading  the owner of the world */
kd_status kd_observe(kd_world *w, const kd_component_desc *desc, uint32_t events, kd_observer_fn *fn,
                     void *user);
/** Take an observer back; what waits is not told to it any more. Does nothing when there is none such. */
void kd_unobserve(kd_world *w, const kd_component_desc *desc, kd_observer_fn *fn, void *user);

#endif
