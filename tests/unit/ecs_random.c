/* Random programs against a naive model: the same calls on a world and on plain arrays, compared again and
 * again. KANDIL_SLOW=1 runs more and longer programs. */

#include "runtime/ecs/instance.h"
#include "runtime/ecs/internal.h"
#include "runtime/ecs/observer.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/validate.h"
#include "tests/unit/ecs_fixture.h"

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
#define SEEDS 100 /* everything takes its time there */
#else
#define SEEDS 400
#endif
enum { MOST = 4000, COMPONENTS = 9, NAMES = 12 };

typedef struct byte_value {
    uint8_t value;
} byte_value;
typedef struct wide {
    double values[5];
} wide;
typedef struct charge { /* comes and goes: beside the tables, with enable bits */
    float amount, leak;
} charge;
typedef struct lamp { /* in the tables, with enable bits */
    uint32_t power;
} lamp;
KD_COMPONENT_DEFINE(byte_value, "byte", KD_FIELD(byte_value, value, KD_U32, NULL, "a byte"));
KD_COMPONENT_DEFINE_FLAGS(charge, "charge", KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE,
                          KD_FIELD(charge, amount, KD_F32, "C", "how much"),
                          KD_FIELD(charge, leak, KD_F32, "A", "how fast it goes"));
KD_COMPONENT_DEFINE_FLAGS(lamp, "lamp", KD_COMPONENT_TOGGLE, KD_FIELD(lamp, power, KD_U32, "W", "power"));
static const kd_component_desc marked_desc = {.name = "marked", .align = 1, .flags = KD_COMPONENT_SPARSE};
static const kd_component_desc wide_desc = {.name = "wide", .size = sizeof(wide), .align = _Alignof(wide)};

/* Component k of the model; its value is made from one number. */
static const kd_component_desc *const kinds[COMPONENTS] = {&position_desc, &health_desc, &byte_value_desc,
                                                           &wide_desc,     &owner_desc,  &frozen_desc,
                                                           &charge_desc,   &lamp_desc,   &marked_desc};
enum { OWNER = 4, TAG = 5, CHARGE = 6, LAMP = 7, MARKED = 8, QUERIES = 14 };

static bool is_tag(int kind)
{
    return kind == TAG || kind == MARKED;
}

typedef union any_value {
    position p;
    health h;
    byte_value b;
    wide w;
    owner o;
    charge c;
    lamp l;
} any_value;

static any_value value_from(int kind, int number)
{
    any_value v;
    memset(&v, 0, sizeof v);
    switch (kind) {
    case 0: v.p = (position){(float)number, (float)-number, 1}; break;
    case 1: v.h = (health){number, number + 1}; break;
    case 2: v.b = (byte_value){(uint8_t)number}; break;
    case 3:
        for (int i = 0; i < 5; i++)
            v.w.values[i] = number * 0.5 + i;
        break;
    case OWNER: v.o = (owner){owned(number)}; break;
    case CHARGE: v.c = (charge){(float)number, 2}; break;
    case LAMP: v.l = (lamp){(uint32_t)number}; break;
    default: break;
    }
    return v;
}

static bool value_is(int kind, const void *at, int number)
{
    if (is_tag(kind))
        return true;
    if (kind == OWNER)
        return *((const owner *)at)->memory == number;
    any_value v = value_from(kind, number);
    return memcmp(at, &v, kinds[kind]->size) == 0;
}

typedef struct model_entity {
    kd_entity handle;
    bool alive;
    uint32_t has, disabled;
    int numbers[COMPONENTS];
    int parent; /* -1 */
    int name;   /* 0: none */
    uint64_t child_order, name_order;
} model_entity;

typedef struct model {
    kd_world *w;
    model_entity e[MOST];
    int newest[MOST]; /* by index of a handle: who has it now */
    int count, alive, owned;
    uint64_t clock, random;
    bool plain; /* nothing owns memory, so that snapshots can be taken */
    bool observed;
    int told[COMPONENTS][4], expected[COMPONENTS][4]; /* events by component: come, set, gone, died */
    kd_query *queries[QUERIES];
} model;

static const kd_query_desc query_descs[QUERIES] = {
    {{KD_READ(position)}, false, NULL},
    {{KD_READ(position), KD_READ(health)}, false, NULL},
    {{KD_READ(health), KD_WITHOUT(frozen)}, true, NULL},
    {{KD_READ(byte_value), KD_OPTIONAL(position)}, false, NULL},
    {{KD_ANY(position), KD_ANY(byte_value)}, true, NULL},
    {{KD_WITH(owner), KD_WITH(frozen)}, false, NULL},
    {{KD_READ(wide), KD_WITHOUT(position), KD_WITHOUT(byte_value)}, true, NULL},
    {.by_depth = true},
    {{KD_READ(charge), KD_WRITE(position)}, false, NULL},
    {{KD_READ(lamp), KD_WITHOUT(charge)}, true, NULL},
    {{KD_READ(position), KD_WITHOUT(lamp), KD_WITHOUT(marked)}, false, NULL},
    {{KD_ANY(charge), KD_ANY(wide), KD_ANY(lamp)}, false, NULL},
    {{KD_WITH(marked), KD_OPTIONAL(charge), KD_OPTIONAL_WRITE(lamp)}, true, NULL},
    {{KD_WRITE(charge), KD_READ(marked)}, false, NULL},
};

static bool query_wants(int q, uint32_t has)
{
    bool c[COMPONENTS];
    for (int k = 0; k < COMPONENTS; k++)
        c[k] = has >> k & 1;
    switch (q) {
    case 0: return c[0];
    case 1: return c[0] && c[1];
    case 2: return c[1] && !c[5];
    case 3: return c[2];
    case 4: return c[0] || c[2];
    case 5: return c[4] && c[5];
    case 6: return c[3] && !c[0] && !c[2];
    case 8: return c[CHARGE] && c[0];
    case 9: return c[LAMP] && !c[CHARGE];
    case 10: return c[0] && !c[LAMP] && !c[MARKED];
    case 11: return c[CHARGE] || c[3] || c[LAMP];
    case 12: return c[MARKED];
    case 13: return c[CHARGE] && c[MARKED];
    default: return true;
    }
}

/* ---- events ---- */
enum { CAME, SET, GONE, DIED };

static void hear(kd_world *w, const kd_observed *what, void *user)
{
    model *m = user;
    int k = 0, event = what->event == KD_ON_ADD      ? CAME
                       : what->event == KD_ON_SET    ? SET
                       : what->event == KD_ON_REMOVE ? GONE
                                                     : DIED;
    (void)w;
    while (kinds[k] != what->component)
        k++;
    m->told[k][event]++;
    assert_int_equal(what->value != NULL, event >= GONE && !is_tag(k));
}

static void expect_event(model *m, uint32_t has, int event)
{
    for (int k = 0; k < COMPONENTS; k++)
        m->expected[k][event] += (int)(has >> k & 1);
}

/* The model's entity gets a component, or another value of it. */
static void model_set(model *m, model_entity *e, int k, int number)
{
    expect_event(m, 1u << k, e->has >> k & 1 ? SET : CAME);
    e->has |= 1u << k;
    e->numbers[k] = number;
}

static void model_remove(model *m, model_entity *e, int k)
{
    expect_event(m, e->has & 1u << k, GONE);
    e->has &= ~(1u << k);
    e->disabled &= ~(1u << k);
}

/* ---- the model's own moves ---- */
static int pick(model *m)
{
    return m->count ? (int)random_below(&m->random, (uint32_t)m->count) : -1;
}

static int pick_alive(model *m)
{
    for (int tries = 0; m->alive && tries < 50; tries++) {
        int i = pick(m);
        if (m->e[i].alive)
            return i;
    }
    return -1;
}

static void model_drop(model *m, int i)
{
    for (int c = 0; c < m->count; c++)
        if (m->e[c].alive && m->e[c].parent == i)
            model_drop(m, c);
    m->owned -= (int)(m->e[i].has >> OWNER & 1);
    expect_event(m, m->e[i].has, GONE);
    expect_event(m, m->e[i].has, DIED);
    m->e[i].alive = false;
    m->alive--;
}

static bool model_is_below(const model *m, int i, int ancestor)
{
    for (; i >= 0; i = m->e[i].parent)
        if (i == ancestor)
            return true;
    return false;
}

static int model_depth(const model *m, int i)
{
    int depth = 0;
    while ((i = m->e[i].parent) >= 0)
        depth++;
    return depth;
}

static model_entity *model_add(model *m, kd_entity handle, uint32_t has)
{
    model_entity *e = &m->e[m->count];
    m->newest[handle.index] = m->count++;
    *e = (model_entity){.handle = handle, .alive = true, .has = has, .parent = -1};
    m->alive++;
    m->owned += (int)(has >> OWNER & 1);
    expect_event(m, has, CAME);
    return e;
}

/* ---- operations on both ---- */
static void op_spawn(model *m)
{
    kd_value values[COMPONENTS];
    any_value storage[COMPONENTS];
    int numbers[COMPONENTS];
    uint32_t has = 0, count = 0;
    uint32_t first = random_below(&m->random, COMPONENTS);
    for (uint32_t i = 0; i < COMPONENTS; i++) {
        int k = (int)((first + i) % COMPONENTS); /* the order in which they are given must not matter */
        if (random_below(&m->random, 2) || (m->plain && k == OWNER))
            continue;
        numbers[k] = (int)random_below(&m->random, 1000);
        storage[k] = value_from(k, numbers[k]);
        values[count++] = (kd_value){kinds[k], is_tag(k) ? NULL : &storage[k]};
        has |= 1u << k;
    }
    int parent = random_below(&m->random, 3) ? -1 : pick_alive(m);
    kd_entity handle = parent < 0 ? kd_spawn_values(m->w, values, count)
                                  : kd_spawn_child_values(m->w, m->e[parent].handle, values, count);
    assert_true(kd_alive(m->w, handle));
    model_entity *e = model_add(m, handle, has);
    if (parent >= 0) {
        e->parent = parent;
        e->child_order = ++m->clock;
    }
    for (int k = 0; k < COMPONENTS; k++)
        if (has >> k & 1)
            e->numbers[k] = numbers[k];
}

static void op_spawn_n(model *m)
{
    uint32_t n = random_below(&m->random, 20);
    position p[20];
    kd_entity out[20];
    const kd_component_desc *descs[] = {&frozen_desc, &position_desc, &health_desc};
    const void *columns[] = {NULL, p, NULL};
    if (m->count + (int)n >= MOST)
        return;
    for (uint32_t i = 0; i < n; i++)
        p[i] = value_from(0, (int)i * 3).p;
    assert_int_equal(kd_spawn_n(m->w, n, descs, columns, 3, out), KD_OK);
    for (uint32_t i = 0; i < n; i++) {
        model_entity *e = model_add(m, out[i], 1u << 0 | 1u << 1 | 1u << TAG);
        e->numbers[0] = (int)i * 3;
        e->numbers[1] = 100;
        kd_set(m->w, out[i], health, {100, 101}); /* value_from(1, 100) */
        expect_event(m, 1u << 1, SET);
    }
}

static void op_destroy(model *m)
{
    int i = pick(m); /* dead ones too: nothing may happen */
    if (i < 0)
        return;
    kd_destroy(m->w, m->e[i].handle);
    if (m->e[i].alive)
        model_drop(m, i);
}

static void op_set(model *m)
{
    int i = pick(m), k = (int)random_below(&m->random, COMPONENTS),
        number = (int)random_below(&m->random, 1000);
    if (i < 0)
        return;
    model_entity *e = &m->e[i];
    if (k == OWNER && (m->plain || !e->alive))
        return; /* the caller keeps what a refused value owns */
    any_value v = value_from(k, number);
    kd_status status = kd_set_value(m->w, e->handle, (kd_value){kinds[k], is_tag(k) ? NULL : &v});
    assert_int_equal(status, e->alive ? KD_OK : KD_NOT_FOUND);
    if (!e->alive)
        return;
    m->owned += k == OWNER && !(e->has >> OWNER & 1);
    model_set(m, e, k, number);
}

static void op_remove(model *m)
{
    int i = pick(m), k = (int)random_below(&m->random, COMPONENTS);
    if (i < 0)
        return;
    kd_remove_id(m->w, m->e[i].handle, kd_component_ensure(m->w, kinds[k]));
    if (m->e[i].alive) {
        m->owned -= k == OWNER && (m->e[i].has >> OWNER & 1);
        model_remove(m, &m->e[i], k);
    }
}

static void op_write(model *m)
{
    int i = pick(m);
    health *h = i < 0 ? NULL : kd_find_mut(m->w, m->e[i].handle, health);
    if (i < 0)
        return;
    assert_int_equal(h != NULL, m->e[i].alive && (m->e[i].has >> 1 & 1));
    if (h) {
        h->now++;
        h->most++;
        m->e[i].numbers[1]++;
    }
}

static void op_parent(model *m)
{
    int child = pick(m), parent = random_below(&m->random, 4) ? pick(m) : -1;
    if (child < 0)
        return;
    kd_entity to = parent < 0 ? KD_NO_ENTITY : m->e[parent].handle;
    kd_status status = kd_set_parent(m->w, m->e[child].handle, to), expected = KD_OK;
    if (!m->e[child].alive || (parent >= 0 && !m->e[parent].alive))
        expected = KD_NOT_FOUND;
    else if (parent >= 0 && model_is_below(m, parent, child))
        expected = KD_OUT_OF_RANGE;
    assert_int_equal(status, expected);
    if (status)
        return;
    m->e[child].parent = parent;
    m->e[child].child_order = ++m->clock;
}

static const char *name_text(int name)
{
    static char text[16];
    snprintf(text, sizeof text, "name%d", name);
    return name ? text : "";
}

static void op_name(model *m)
{
    int i = pick_alive(m), name = (int)random_below(&m->random, NAMES);
    if (i < 0)
        return;
    assert_int_equal(kd_set_name(m->w, m->e[i].handle, name_text(name)), KD_OK);
    if (m->e[i].name != name)
        m->e[i].name_order = ++m->clock;
    m->e[i].name = name;
}

/* Through a call or a command: the bit is the same. */
static void op_enable(model *m)
{
    int i = pick(m), k = random_below(&m->random, 2) ? CHARGE : LAMP;
    bool on = random_below(&m->random, 3) == 0, deferred = random_below(&m->random, 3) == 0;
    if (i < 0)
        return;
    model_entity *e = &m->e[i];
    bool here = e->alive && (e->has >> k & 1);
    if (deferred) {
        kd_commands_enable(kd_world_commands(m->w, 1), e->handle, kinds[k], on);
        assert_int_equal(kd_world_merge(m->w), KD_OK);
    } else {
        kd_status status = kd_enable_id(m->w, e->handle, kd_component_ensure(m->w, kinds[k]), on);
        assert_int_equal(status, here ? KD_OK : KD_NOT_FOUND);
    }
    if (here)
        e->disabled = on ? e->disabled & ~(1u << k) : e->disabled | 1u << k;
}

/* The same changes through a command buffer, merged at once. */
static void op_commands(model *m)
{
    kd_commands *c = kd_world_commands(m->w, random_below(&m->random, KD_MAX_WORKERS));
    int number = (int)random_below(&m->random, 1000), i = pick(m), doomed = pick(m);
    any_value v = value_from(0, number);
    kd_entity made = kd_commands_spawn(c, &(kd_value){&position_desc, &v}, 1);
    if (doomed >= 0)
        kd_commands_destroy(c, m->e[doomed].handle);
    if (i >= 0)
        kd_commands_set(c, m->e[i].handle, (kd_value){&position_desc, &v});
    assert_int_equal(kd_world_merge(m->w), KD_OK);
    model_add(m, kd_entity_resolve(m->w, made), 1u << 0)->numbers[0] = number;
    if (doomed >= 0 && m->e[doomed].alive)
        model_drop(m, doomed);
    if (i >= 0 && m->e[i].alive)
        model_set(m, &m->e[i], 0, number);
}

/* What a loop over a query records: one component for many neighbouring rows. */
static void op_run(model *m)
{
    static const int choice[] = {3, TAG, CHARGE, LAMP};
    int k = choice[random_below(&m->random, 4)], number = (int)random_below(&m->random, 1000);
    uint32_t skip = 1 + random_below(&m->random, 40), row = 0;
    any_value v = value_from(k, number);
    kd_commands *c = kd_world_commands(m->w, 2);
    for (kd_iter it = kd_query_iter(m->queries[0]); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++)
            if (row++ % skip || skip == 1)
                kd_commands_set(c, it.entities[i], (kd_value){kinds[k], is_tag(k) ? NULL : &v});
    row = 0;
    for (kd_iter it = kd_query_iter(m->queries[0]); kd_iter_next(&it);)
        for (uint32_t i = 0; i < it.count; i++) {
            if (!(row++ % skip || skip == 1))
                continue;
            model_set(m, &m->e[m->newest[it.entities[i].index]], k, number);
        }
    assert_int_equal(kd_world_merge(m->w), KD_OK);
}

/* ---- what several workers record, merged in the order of keys ---- */
typedef struct recorded {
    uint64_t key;
    uint32_t place; /* in the order of recording */
    enum { MADE, KILLED, GIVEN, TAKEN, ENABLED, HUNG, NAMED, RECORDS } what;
    int i, other, k, number; /* of the model; KILLED, HUNG, NAMED of the one that was MADE before it: i < 0 */
    kd_entity handle;
} recorded;

static void record(model *m, kd_commands *c, recorded *r, const recorded *made)
{
    any_value v = value_from(r->k, r->number);
    kd_value value = {kinds[r->k], is_tag(r->k) ? NULL : &v};
    kd_entity e = r->i < 0 && made ? made->handle : m->e[r->i < 0 ? 0 : r->i].handle;
    switch (r->what) {
    case MADE: r->handle = kd_commands_spawn(c, &value, 1); break;
    case KILLED: kd_commands_destroy(c, e); break;
    case GIVEN: kd_commands_set(c, e, value); break;
    case TAKEN: kd_commands_remove(c, e, kinds[r->k]); break;
    case ENABLED: kd_commands_enable(c, e, kinds[r->k], r->number & 1); break;
    case HUNG: kd_commands_set_parent(c, e, r->other < 0 ? KD_NO_ENTITY : m->e[r->other].handle); break;
    default: kd_commands_set_name(c, e, name_text(r->number % NAMES));
    }
    if (r->what != MADE)
        r->handle = e;
}

/* What the merge did, done to the model. `i` is who it is about: a handle that died meanwhile leads nowhere.
 * Returns whether the command was refused: a circle. */
static bool model_apply(model *m, const recorded *r, int i)
{
    model_entity *e = i < 0 ? NULL : &m->e[i];
    if (!e || !e->alive)
        return false;
    if (r->what == KILLED) {
        model_drop(m, i);
    } else if (r->what == GIVEN) {
        model_set(m, e, r->k, r->number);
    } else if (r->what == TAKEN) {
        model_remove(m, e, r->k);
    } else if (r->what == ENABLED && e->has >> r->k & 1) {
        e->disabled = r->number & 1 ? e->disabled & ~(1u << r->k) : e->disabled | 1u << r->k;
    } else if (r->what == HUNG) {
        if (r->other >= 0 && !m->e[r->other].alive)
            return false;
        if (r->other >= 0 && model_is_below(m, r->other, i))
            return true;
        if (r->other < 0 && e->parent < 0)
            return false;
        e->parent = r->other;
        e->child_order = ++m->clock;
    } else if (r->what == NAMED) {
        if (e->name != r->number % NAMES)
            e->name_order = ++m->clock;
        e->name = r->number % NAMES;
    }
    return false;
}

static int by_key(const void *a, const void *b)
{
    const recorded *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return x->place < y->place ? -1 : x->place > y->place;
}

static void op_workers(model *m)
{
    enum { MOST_RECORDED = 24 };
    recorded all[MOST_RECORDED];
    int made_at[MOST_RECORDED], kinds_of[] = {0, 1, 2, 3, TAG, CHARGE, LAMP, MARKED};
    uint32_t count = 1 + random_below(&m->random, MOST_RECORDED), last_made = ECS_NONE;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t worker = random_below(&m->random, 5);
        kd_commands *c = kd_world_commands(m->w, worker);
        recorded *r = &all[n];
        *r = (recorded){.key = random_below(&m->random, 6) * 8 + worker, /* no two workers share one */
                        .place = n,
                        .what = random_below(&m->random, RECORDS),
                        .i = pick_alive(m),
                        .other = pick_alive(m),
                        .k = kinds_of[random_below(&m->random, 8)],
                        .number = (int)random_below(&m->random, 1000)};
        if (r->what == ENABLED)
            r->k = r->number & 2 ? CHARGE : LAMP;
        if (r->what == HUNG && r->number % 4 == 0)
            r->other = -1;
        if (r->i < 0)
            r->what = MADE;
        bool of_made =
            last_made != ECS_NONE && all[last_made].key == r->key && r->what != MADE && r->number & 4;
        if (of_made)
            r->i = -1;
        kd_commands_key(c, r->key);
        record(m, c, r, of_made ? &all[last_made] : NULL);
        if (r->what == MADE)
            last_made = n;
    }
    bool refused = false;
    kd_log_set_sink(silent, NULL);
    kd_status status = kd_world_merge(m->w);
    kd_log_set_sink(NULL, NULL);
    qsort(all, count, sizeof *all, by_key);
    for (uint32_t n = 0; n < count; n++) {
        int i = all[n].i;
        if (all[n].what == MADE) {
            made_at[n] = m->count;
            /* the handle even of one that was killed in the same merge */
            model_add(m, ecs_commands_resolve(m->w, all[n].handle), 1u << all[n].k)->numbers[all[n].k] =
                all[n].number;
            continue;
        }
        for (uint32_t k = 0; i < 0 && k < n; k++)
            if (all[k].what == MADE && kd_entity_equal(all[k].handle, all[n].handle))
                i = made_at[k];
        refused |= model_apply(m, &all[n], i);
    }
    assert_int_equal(status, refused ? KD_OUT_OF_RANGE : KD_OK);
}

enum { MOST_NODES = 24, MOST_COPIES = 3 };

/* The model's subtree in preorder; returns how many nodes, at most `room`. */
static int model_subtree(const model *m, int root, int *nodes, int room)
{
    int count = 1;
    uint64_t after = 0;
    if (room < 1)
        return 0;
    nodes[0] = root;
    for (;;) {
        int next = -1;
        for (int c = 0; c < m->count; c++)
            if (m->e[c].alive && m->e[c].parent == root && m->e[c].child_order > after &&
                (next < 0 || m->e[c].child_order < m->e[next].child_order))
                next = c;
        if (next < 0)
            return count;
        after = m->e[next].child_order;
        int below = model_subtree(m, next, nodes + count, room - count);
        if (!below)
            return 0;
        count += below;
    }
}

/* Copies are made node by node; where a copy came to lie is read from the world's lists of children. */
static void op_instantiate(model *m)
{
    int nodes[MOST_NODES], copies[MOST_NODES][MOST_COPIES];
    uint32_t n = 1 + random_below(&m->random, MOST_COPIES);
    int root = pick_alive(m), parent = random_below(&m->random, 2) ? pick_alive(m) : -1;
    int count = root < 0 ? 0 : model_subtree(m, root, nodes, MOST_NODES);
    kd_entity roots[MOST_COPIES], above = parent < 0 ? KD_NO_ENTITY : m->e[parent].handle;
    bool owns = false;
    for (int k = 0; k < count; k++)
        owns |= m->e[nodes[k]].has >> OWNER & 1;
    if (!count || owns || m->count + count * MOST_COPIES > MOST - 30)
        return;
    assert_int_equal(kd_instantiate(m->w, m->e[root].handle, above, n, roots), KD_OK);
    for (int k = 0; k < count; k++)
        for (uint32_t i = 0; i < n; i++) {
            const model_entity *of = &m->e[nodes[k]];
            int from = 0;
            kd_entity handle = roots[i];
            if (k) {
                while (nodes[from] != of->parent)
                    from++;
                handle = kd_first_child(m->w, m->e[copies[from][i]].handle);
                for (int before = from + 1; before < k; before++)
                    if (m->e[nodes[before]].parent == of->parent)
                        handle = kd_next_sibling(m->w, handle);
            }
            assert_true(kd_alive(m->w, handle));
            model_entity *e = model_add(m, handle, of->has);
            copies[k][i] = (int)(e - m->e);
            memcpy(e->numbers, of->numbers, sizeof e->numbers);
            e->disabled = of->disabled;
            e->parent = k ? copies[from][i] : parent;
            e->child_order = ++m->clock;
            e->name = of->name;
            e->name_order = ++m->clock;
        }
}

static void op_destroy_query(model *m)
{
    int q = (int)random_below(&m->random, QUERIES);
    bool doomed[MOST] = {false};
    if (q == 7 || !m->queries[q])
        return; /* that one is everybody */
    for (int i = 0; i < m->count; i++)
        doomed[i] = m->e[i].alive && query_wants(q, m->e[i].has & ~m->e[i].disabled);
    assert_int_equal(kd_destroy_query(m->queries[q]), KD_OK);
    for (int i = 0; i < m->count; i++)
        if (doomed[i] && m->e[i].alive)
            model_drop(m, i);
}

/* Through bytes and back: the world that comes back is the one that was written. */
static void op_snapshot(model *m)
{
    kd_snapshot s = {0};
    uint64_t before = kd_world_checksum(m->w);
    assert_int_equal(kd_snapshot_write(m->w, &s), KD_OK);
    if (random_below(&m->random, 2)) {
        kd_spawn(m->w, KD_TAG(position), KD_TAG(padded)); /* what is taken back with it, in silence */
        expect_event(m, 1u << 0, CAME);
    }
    assert_int_equal(kd_snapshot_restore(m->w, s.data, s.size), KD_OK);
    assert_true(kd_world_checksum(m->w) == before);
    kd_snapshot_fini(&s);
}

/* ---- comparison ---- */
static void check_entity(const model *m, int i)
{
    const model_entity *e = &m->e[i];
    assert_int_equal(kd_alive(m->w, e->handle), e->alive);
    for (int k = 0; k < COMPONENTS; k++) {
        const void *at = kd_find_id(m->w, e->handle, kd_component_ensure(m->w, kinds[k]));
        assert_int_equal(at != NULL, e->alive && (e->has >> k & 1));
        assert_int_equal(kd_is_enabled_id(m->w, e->handle, kd_component_ensure(m->w, kinds[k])),
                         e->alive && (e->has & ~e->disabled) >> k & 1);
        if (at && k != OWNER)
            assert_true(value_is(k, at, e->numbers[k]));
        else if (at)
            assert_int_equal(*((const owner *)at)->memory, e->numbers[k]);
    }
    if (!e->alive)
        return;
    assert_string_equal(kd_get_name(m->w, e->handle), name_text(e->name));
    assert_entity(kd_get_parent(m->w, e->handle), e->parent < 0 ? KD_NO_ENTITY : m->e[e->parent].handle);
    assert_int_equal(kd_get_depth(m->w, e->handle), model_depth(m, i));
}

static void check_children(const model *m, int i)
{
    uint64_t after = 0;
    kd_entity child = kd_first_child(m->w, m->e[i].handle);
    for (;; child = kd_next_sibling(m->w, child)) {
        int next = -1; /* the child that came next after `after` */
        for (int c = 0; c < m->count; c++)
            if (m->e[c].alive && m->e[c].parent == i && m->e[c].child_order > after &&
                (next < 0 || m->e[c].child_order < m->e[next].child_order))
                next = c;
        assert_entity(child, next < 0 ? KD_NO_ENTITY : m->e[next].handle);
        if (next < 0)
            return;
        after = m->e[next].child_order;
    }
}

static void check_names(const model *m)
{
    for (int name = 1; name < NAMES; name++) {
        int first = -1;
        for (int i = 0; i < m->count; i++)
            if (m->e[i].alive && m->e[i].name == name &&
                (first < 0 || m->e[i].name_order < m->e[first].name_order))
                first = i;
        assert_entity(kd_find_named(m->w, name_text(name)), first < 0 ? KD_NO_ENTITY : m->e[first].handle);
    }
}

/* What an accessed column shows at this row is the entity's own value, and nothing when it is not to be seen.
 */
static void check_columns(const model *m, int q, const kd_iter *it, uint32_t row)
{
    const model_entity *e = &m->e[m->newest[it->entities[row].index]];
    for (uint32_t t = 0; query_descs[q].terms[t].kind != KD_TERM_END; t++) {
        const kd_term *term = &query_descs[q].terms[t];
        int k = 0;
        if (term->kind == KD_TERM_WITH || term->kind == KD_TERM_WITHOUT)
            continue;
        while (kinds[k] != term->desc)
            k++;
        bool shown = (e->has & ~e->disabled) >> k & 1;
        assert_int_equal(it->columns[t] != NULL, shown);
        if (shown)
            assert_true(
                value_is(k, (const uint8_t *)it->columns[t] + (size_t)row * term->desc->size, e->numbers[k]));
    }
}

static void check_query(const model *m, int q)
{
    uint32_t expected = 0, rows = 0, depth = 0;
    uint64_t expected_sum = 0, sum = 0;
    for (int i = 0; i < m->count; i++)
        if (m->e[i].alive && query_wants(q, m->e[i].has & ~m->e[i].disabled)) {
            expected++;
            expected_sum += (uint64_t)m->e[i].handle.index * 31 + m->e[i].handle.generation;
        }
    for (kd_iter it = kd_query_iter(m->queries[q]); kd_iter_next(&it); rows += it.count)
        for (uint32_t i = 0; i < it.count; i++) {
            sum += (uint64_t)it.entities[i].index * 31 + it.entities[i].generation;
            uint32_t d = kd_get_depth(m->w, it.entities[i]);
            assert_true(!query_descs[q].by_depth || d >= depth);
            depth = d;
            check_columns(m, q, &it, i);
        }
    assert_int_equal(rows, expected);
    assert_int_equal(kd_query_count(m->queries[q]), expected);
    assert_true(sum == expected_sum);
}

static void check_all(const model *m)
{
    assert_int_equal(kd_entity_count(m->w), m->alive);
    for (int i = 0; i < m->count; i++)
        check_entity(m, i);
    for (int i = 0; i < m->count; i += 7)
        if (m->e[i].alive)
            check_children(m, i);
    check_names(m);
    for (int q = 0; q < QUERIES; q++)
        check_query(m, q);
    assert_int_equal(kd_world_validate(m->w), KD_OK);
    if (m->observed)
        assert_memory_equal(m->told, m->expected, sizeof m->told);
}

static void step(model *m)
{
    static void (*const ops[])(model *) = {op_spawn, op_spawn,    op_spawn_n, op_destroy, op_set,
                                           op_set,   op_remove,   op_write,   op_parent,  op_parent,
                                           op_name,  op_commands, op_remove,  op_enable};
    uint32_t op = random_below(&m->random, m->alive > 250 ? 28 : 14);
    if (op >= 14)
        op = 3; /* enough of them: destroy more */
    if (random_below(&m->random, 50) == 0)
        op_run(m);
    if (m->alive < 300 && m->count < MOST - 100 && random_below(&m->random, 25) == 0)
        op_instantiate(m);
    if (random_below(&m->random, 200) == 0)
        op_destroy_query(m);
    if (m->count < MOST - 100 && random_below(&m->random, 12) == 0)
        op_workers(m);
    if (m->plain && random_below(&m->random, 80) == 0)
        op_snapshot(m);
    if (m->count < MOST - 30)
        ops[op](m);
}

/* Run a program of `steps` operations; returns the checksum of the world at its end. */
static uint64_t run_program(uint64_t seed, int steps, int check_every)
{
    static model m;
    memset(&m, 0, sizeof m);
    m.random = seed * 0x9e3779b97f4a7c15u + 1;
    m.plain = seed % 4 == 0;
    m.w = kd_world_make();
    assert_non_null(m.w);
    owner_releases = 0;
    for (int q = 0; q < QUERIES; q += 2)
        m.queries[q] = kd_query_make(m.w, &query_descs[q]);
    m.observed = seed % 3 != 0;
    for (int k = 0; k < COMPONENTS && m.observed; k++)
        assert_int_equal(kd_observe(m.w, kinds[k], 15, hear, &m), KD_OK);
    for (int i = 0; i < steps; i++) {
        step(&m);
        if (i == steps / 2)
            for (int q = 1; q < QUERIES; q += 2)
                m.queries[q] = kd_query_make(m.w, &query_descs[q]);
        if (check_every && i >= steps / 2 && i % check_every == 0)
            check_all(&m);
    }
    if (check_every)
        check_all(&m);
    uint64_t checksum = kd_world_checksum(m.w);
    int releases = owner_releases, left = m.owned;
    kd_world_destroy(m.w);
    assert_int_equal(owner_releases - releases, left);
    return checksum;
}

static bool slow(void)
{
    return getenv("KANDIL_SLOW") && *getenv("KANDIL_SLOW") == '1';
}

static void random_programs_agree_with_the_model(void **state)
{
    (void)state;
    uint64_t seeds = slow() ? 5000 : SEEDS;
    for (uint64_t seed = 1; seed <= seeds; seed++)
        run_program(seed, 3000, slow() ? 100 : 300);
}

static void random_programs_repeat_exactly(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 40; seed++)
        assert_true(run_program(seed, 2000, 0) == run_program(seed, 2000, 0));
    assert_true(run_program(1, 2000, 0) != run_program(2, 2000, 0));
}

/* Memory runs out at every possible moment in turn: calls fail, nothing breaks, and what lives can still be
 * read. */
static void programs_survive_without_memory(void **state)
{
    (void)state;
    kd_log_set_sink(silent, NULL);
    for (uint32_t round = 0; round < (slow() ? 3000u : 300u); round++) {
        kd_world *w = kd_world_make();
        uint64_t random = round + 1;
        kd_entity e[64] = {{0}};
        kd_world_limit_bytes(w, kd_world_bytes(w) + round * 96);
        for (int i = 0; i < 400; i++) {
            kd_entity *one = &e[random_below(&random, 64)], *two = &e[random_below(&random, 64)];
            kd_commands *c = kd_world_commands(w, i % 3 ? 0 : 1);
            switch (random_below(&random, 12)) {
            case 0:
            case 1: *one = kd_spawn(w, KD_VAL(position, {1, 2, 3}), KD_TAG(health)); break;
            case 2: kd_set(w, *one, velocity, {1, 2, 3}); break;
            case 3: kd_remove(w, *one, position); break;
            case 4:
                if (i & 1)
                    kd_set_parent(w, *one, *two);
                else
                    *one = kd_spawn_child(w, *two, KD_TAG(position));
                break;
            case 5: kd_set_name(w, *one, name_text(i % 40 + 1)); break;
            case 10:
                kd_set(w, *one, charge, {1, 2});
                kd_disable(w, *one, charge);
                break;
            case 11:
                *two = kd_spawn(w, KD_TAG(charge), KD_TAG(lamp));
                kd_disable(w, *two, lamp);
                break;
            case 6: kd_commands_spawn(c, (kd_value[]){KD_VAL(bond, {*one, 1})}, 1); break;
            case 7: kd_query_make(w, &query_descs[i % QUERIES]); break;
            case 8:
                (void)kd_singleton(w, health);
                kd_world_merge(w);
                break;
            default: kd_destroy(w, *one);
            }
        }
        uint32_t living = 0, rows = 0;
        kd_world_limit_bytes(w, 0);
        kd_query *q = kd_query_make(w, &(kd_query_desc){0});
        for (kd_iter it = kd_query_iter(q); kd_iter_next(&it); rows += it.count)
            for (uint32_t i = 0; i < it.count; i++)
                living += kd_alive(w, it.entities[i]);
        assert_int_equal(rows, kd_entity_count(w));
        assert_int_equal(living, rows);
        kd_world_destroy(w);
    }
    kd_log_set_sink(NULL, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_programs_agree_with_the_model),
        cmocka_unit_test(random_programs_repeat_exactly),
        cmocka_unit_test(programs_survive_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
