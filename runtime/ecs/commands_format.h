#ifndef KD_ECS_COMMANDS_FORMAT_H
#define KD_ECS_COMMANDS_FORMAT_H

/* What commands.c records and commands_merge.c applies. A command lies at a multiple of 8 in its buffer's
 * bytes:
 *
 *   command_set, then `count` × (kd_entity, value)     of a component given to many, one behind the other
 *   command, then what its kind tells                  all others */

#include "runtime/ecs/internal.h"

enum {
    COMMAND_SPAWN, /* count × (command_value, value) */
    COMMAND_DESTROY,
    COMMAND_SET,      /* command_set */
    COMMAND_REMOVE,   /* count is the component */
    COMMAND_ENABLE,   /* count is the component; uint64_t: 1 or 0 */
    COMMAND_PARENT,   /* kd_entity */
    COMMAND_NAME,     /* text, ended by a zero */
    COMMAND_RELATE,   /* kd_entity, command_value, value */
    COMMAND_UNRELATE, /* count is the relation; kd_entity */
};

typedef struct command {
    uint32_t kind;
    uint32_t count; /* values that follow; serial number of a spawn comes in e.index */
    kd_entity e;
} command;

typedef struct command_value {
    kd_component_id id;
    uint32_t size; /* bytes of a value, padded to 8; 0: the default */
} command_value;

typedef struct command_set {
    uint32_t kind, count;
    command_value value; /* of every item */
} command_set;
_Static_assert(sizeof(command_set) == sizeof(command), "the kind is read before it is known which one it is");

static inline uint32_t command_units(size_t bytes)
{
    return (uint32_t)((bytes + 7) / 8);
}
/* Bytes from one item of a command_set to the next. */
static inline size_t command_stride(const command_set *s)
{
    return sizeof(kd_entity) + (size_t)command_units(s->value.size) * 8;
}

/** Of the states of several commands the one to report: memory first, else the first that was refused. A
 * command on who is dead does nothing, which is no failure. */
static inline kd_status ecs_worse(kd_status status, kd_status next)
{
    return next == KD_NO_MEMORY || (!status && next != KD_NOT_FOUND) ? next : status;
}

/** Replace the pending handles in the fields of a value by those known now. */
void ecs_commands_settle_fields(const kd_world *w, kd_component_id id, uint8_t *value);

#endif
