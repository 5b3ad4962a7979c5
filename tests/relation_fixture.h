#ifndef RELATION_FIXTURE_H
#define RELATION_FIXTURE_H

/* What the tests of relations share: one of each kind. */

#include "runtime/ecs/relation.h"
#include "runtime/ecs/validate.h"
#include "tests/unit/ecs_fixture.h"

typedef struct likes {
    float much;
    kd_entity because_of;
} likes;
KD_RELATION_DEFINE(likes, "likes", 0, KD_FIELD(likes, much, KD_F32, NULL, "how much"),
                   KD_FIELD(likes, because_of, KD_ENTITY, NULL, "who made it so"));
typedef struct aims_at {
    float since;
} aims_at;
KD_RELATION_DEFINE(aims_at, "aims_at", KD_COMPONENT_EXCLUSIVE,
                   KD_FIELD(aims_at, since, KD_F32, "s", "when it began"));
typedef struct part_of part_of;
KD_RELATION_TAG_DEFINE(part_of, "part_of", KD_COMPONENT_EXCLUSIVE | KD_COMPONENT_CASCADE);
typedef struct knows knows;
KD_RELATION_TAG_DEFINE(knows, "knows", 0);
static const kd_component_desc holds_desc = {.name = "holds",
                                             .size = sizeof(owner),
                                             .align = _Alignof(owner),
                                             .on_remove = owner_release,
                                             .flags = KD_COMPONENT_RELATION | KD_COMPONENT_EXCLUSIVE};
typedef owner holds;

static inline void spawn_all(kd_world *w, kd_entity *e, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++)
        e[i] = kd_spawn(w, KD_VAL(position, {(float)i, 0, 0}));
}

/* A world with pairs of every kind, of which some have come and gone. */
static inline kd_world *related_world(kd_entity *e, uint32_t n)
{
    kd_world *w = kd_world_make();
    uint64_t random = 11;
    spawn_all(w, e, n);
    for (uint32_t i = 0; i < 6 * n; i++) {
        kd_entity a = e[random_below(&random, n)], b = e[random_below(&random, n)];
        switch (i % 6) {
        case 0:
        case 1: kd_relate_with(w, a, likes, b, {(float)i, e[0]}); break;
        case 2: kd_relate_with(w, a, aims_at, b, {(float)i}); break;
        case 3: kd_relate(w, a, knows, b); break;
        case 4:
            if (a.index > b.index)
                kd_relate(w, a, part_of, b);
            break;
        default: kd_unrelate(w, a, likes, kd_target(w, a, likes)); kd_remove(w, b, knows);
        }
    }
    kd_destroy(w, e[n / 2]);
    assert_int_equal(kd_world_validate(w), KD_OK);
    return w;
}

static inline void register_relations(kd_world *w)
{
    const kd_component_desc *const all[] = {&part_of_desc, &knows_desc, &aims_at_desc,
                                            &likes_desc,   &holds_desc, &position_desc};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        assert_true(kd_component_ensure(w, all[i]) != 0);
}

#endif
