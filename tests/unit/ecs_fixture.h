#ifndef ECS_FIXTURE_H
#define ECS_FIXTURE_H

/* What the tests of the ECS share: cmocka, a few components, and one that owns memory and counts its
 * releases. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/core/log.h"
#include "runtime/core/math.h"
#include "runtime/ecs/query.h"
#include "runtime/ecs/world.h"

typedef struct position {
    float x, y, z;
} position;
typedef struct velocity {
    float x, y, z;
} velocity;
typedef struct health {
    int32_t now, most;
} health;
typedef struct bond {
    kd_entity target;
    uint32_t weight;
} bond;
typedef struct owner { /* owns what it points to */
    int *memory;
} owner;
typedef struct padded { /* three bytes of padding after flag */
    uint8_t flag;
    uint32_t value;
} padded;
typedef struct frozen {
    int unused;
} frozen;

KD_COMPONENT_DEFINE(position, "position", KD_FIELD(position, x, KD_F32, "m", "x"),
                    KD_FIELD(position, y, KD_F32, "m", "y"), KD_FIELD(position, z, KD_F32, "m", "z"));
KD_COMPONENT_DEFINE(velocity, "velocity", KD_FIELD(velocity, x, KD_F32, "m/s", "x"),
                    KD_FIELD(velocity, y, KD_F32, "m/s", "y"), KD_FIELD(velocity, z, KD_F32, "m/s", "z"));
static const health health_default = {100, 100};
KD_COMPONENT_DEFINE_DEFAULT(health, "health", &health_default,
                            KD_FIELD_RANGE(health, now, KD_I32, NULL, 0, 1000, "points left"),
                            KD_FIELD(health, most, KD_I32, NULL, "points when unhurt"));
KD_COMPONENT_DEFINE(bond, "bond", KD_FIELD(bond, target, KD_ENTITY, NULL, "where it leads"),
                    KD_FIELD(bond, weight, KD_U32, NULL, "how strongly"));
KD_COMPONENT_DEFINE(padded, "padded", KD_FIELD(padded, flag, KD_BOOL, NULL, "on"),
                    KD_FIELD(padded, value, KD_U32, NULL, "a number"));
KD_TAG_DEFINE(frozen, "frozen");

static _Atomic int owner_releases; /* worlds of several threads may release at once */
static void owner_release(void *value, void *user)
{
    owner *o = value;
    (void)user;
    free(o->memory);
    owner_releases++;
}
static const kd_component_desc owner_desc = {
    .name = "owner", .size = sizeof(owner), .align = _Alignof(owner), .on_remove = owner_release};

static inline int *owned(int value)
{
    int *memory = malloc(sizeof *memory);
    assert_non_null(memory);
    *memory = value;
    return memory;
}

/* Fails the test when a handle is not the one expected. */
#define assert_entity(a, b) assert_true(kd_entity_equal((a), (b)))

/* xorshift64*: the same numbers everywhere. */
static inline uint32_t random_u32(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (uint32_t)(*state * 2685821657736338717u >> 32);
}
static inline uint32_t random_below(uint64_t *state, uint32_t n)
{
    return random_u32(state) % n;
}

static inline void silent(void *user, kd_log_level level, const char *text)
{
    (void)user, (void)level, (void)text;
}

#endif
