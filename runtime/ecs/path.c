/* Paths of names. A name on the way is looked up once as a group of equal names; siblings are then compared
 * by the number of their group. */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "runtime/ecs/path.h"
#include "runtime/ecs/internal.h"

static bool is_special(char c)
{
    return c == '/' || c == '\\';
}

/* ---- writing ---- */
static size_t escaped_length(const char *name)
{
    size_t length = 0;
    for (; *name; name++)
        length += is_special(*name) ? 2 : 1;
    return length;
}

/* Write the name so that it ends before `end`; what lies past the text's room is left out. Returns where it
 * begins. */
static size_t write_before(char *out, size_t size, size_t end, const char *name)
{
    size_t begin = end - escaped_length(name), at = begin;
    for (; *name; name++) {
        if (is_special(*name) && at++ + 1 < size)
            out[at - 1] = '\\';
        if (at++ + 1 < size)
            out[at - 1] = *name;
    }
    return begin;
}

size_t kd_entity_path(const kd_world *w, kd_entity e, char *out, size_t size)
{
    size_t length = 0;
    if (size)
        *out = 0;
    for (kd_entity at = e; at.generation; at = kd_get_parent(w, at)) {
        const char *name = kd_get_name(w, at);
        if (!*name)
            return 0;
        length += escaped_length(name) + (length != 0);
    }
    size_t end = length;
    for (kd_entity at = e; at.generation && size; at = kd_get_parent(w, at)) {
        end = write_before(out, size, end, kd_get_name(w, at));
        if (end && end-- < size)
            out[end] = '/';
    }
    if (size)
        out[length < size ? length : size - 1] = 0;
    return length;
}

/* ---- looking up ---- */
/* The bytes of a name up to the next escape or its end; *name moves behind them. */
static size_t next_part(const char **name, const char **part)
{
    *name += **name == '\\' && (*name)[1];
    *part = *name;
    do
        ++*name;
    while (**name && !is_special(**name));
    return (size_t)(*name - *part);
}

static bool at_end(const char *name)
{
    return !*name || *name == '/';
}

/* Compare the text of a group with a name on the path. */
static bool group_is(const ecs_name_group *g, const char *name)
{
    const char *text = g->text, *part;
    while (!at_end(name)) {
        size_t length = next_part(&name, &part);
        if (strncmp(text, part, length) != 0)
            return false;
        text += length;
    }
    return !*text;
}

/* The group of the first name on the path, 0 when nobody is called that; *path moves behind it. */
static uint32_t next_group(const kd_world *w, const char **path)
{
    const char *name = *path, *part;
    XXH3_state_t state;
    XXH3_64bits_reset(&state);
    while (!at_end(*path)) {
        size_t length = next_part(path, &part);
        XXH3_64bits_update(&state, part, length);
    }
    uint64_t hash = XXH3_64bits_digest(&state);
    uint32_t mask = w->name_slot_count - 1;
    for (uint32_t s = (uint32_t)hash & mask; w->name_slot_count && w->name_slots[s]; s = (s + 1) & mask) {
        const ecs_name_group *g = &w->name_groups[w->name_slots[s] - 1];
        if (g->hash == hash && group_is(g, name))
            return w->name_slots[s];
    }
    return 0;
}

static uint32_t group_of(const kd_world *w, uint32_t index)
{
    return index < w->name_limit ? w->name_links[index].group : 0;
}

static uint32_t child_of_group(const kd_world *w, uint32_t parent, uint32_t group)
{
    uint32_t child = ecs_first_child(w, parent);
    while (child != ECS_NONE && group_of(w, child) != group)
        child = w->nodes[child].next;
    return child;
}

static uint32_t root_of_group(const kd_world *w, uint32_t group)
{
    uint32_t root = w->name_groups[group - 1].first;
    while (root != ECS_NONE && ecs_table_of(w, root)->depth)
        root = w->name_links[root].next;
    return root;
}

kd_entity kd_find_path(const kd_world *w, kd_entity from, const char *path)
{
    bool below = from.generation != 0;
    from = kd_entity_resolve(w, from);
    if (!path || (below && !from.generation))
        return KD_NO_ENTITY;
    for (uint32_t at = from.index;; path++) {
        uint32_t group = at_end(path) ? 0 : next_group(w, &path);
        at = !group ? ECS_NONE : below ? child_of_group(w, at, group) : root_of_group(w, group);
        if (at == ECS_NONE)
            return KD_NO_ENTITY;
        if (!*path)
            return ecs_handle_at(w, at);
        below = true;
    }
}
