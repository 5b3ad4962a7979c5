/* Every allocation of every public call fails in turn: the call says so, the world is as it was and agrees
 * with itself, and the same call succeeds once memory is there again. Under the address sanitizer nothing
 * leaks. */

#include "tests/allocation_fixture.h"

#include <unistd.h>

#include "runtime/ecs/instance.h"
#include "runtime/ecs/observer.h"
#include "runtime/ecs/reflect.h"
#include "runtime/ecs/relation.h"
#include "runtime/ecs/snapshot.h"
#include "runtime/ecs/statistics.h"
#include "runtime/ecs/system.h"
#include "runtime/ecs/validate.h"
#include "runtime/jobs/jobs.h"
#include "tests/unit/ecs_fixture.h"

typedef struct charge {
    float amount;
} charge;
typedef struct lamp {
    uint32_t power;
} lamp;
typedef struct label {
    char text[24];
} label;
typedef struct late { /* not registered before the call */
    float value;
} late;
typedef struct wide { /* in no entity's archetype before the call */
    double values[4];
} wide;
KD_COMPONENT_DEFINE_FLAGS(charge, "charge", KD_COMPONENT_SPARSE | KD_COMPONENT_TOGGLE,
                          KD_FIELD(charge, amount, KD_F32, "C", "how much"));
KD_COMPONENT_DEFINE_FLAGS(lamp, "lamp", KD_COMPONENT_TOGGLE, KD_FIELD(lamp, power, KD_U32, "W", "power"));
KD_COMPONENT_DEFINE(label, "label", KD_FIELD(label, text, KD_STRING, NULL, "what it says"));
KD_COMPONENT_DEFINE(late, "late", KD_FIELD(late, value, KD_F32, NULL, "a number"));
KD_COMPONENT_DEFINE_FLAGS(wide, "wide", KD_COMPONENT_SPARSE,
                          KD_FIELD_ARRAY(wide, values, KD_F32, 8, NULL, "numbers"));

typedef struct likes {
    float how_much;
} likes;
KD_RELATION_DEFINE(likes, "likes", 0, KD_FIELD(likes, how_much, KD_F32, NULL, "0 to 1"));
KD_RELATION_TAG_DEFINE(part_of, "part_of", KD_COMPONENT_EXCLUSIVE | KD_COMPONENT_CASCADE);

enum { MOST = 300, DESCS = 10 };

/* What a call works on: `fill` decides how full every array of the world is. */
typedef struct stage {
    kd_world *w;
    kd_jobs *jobs;
    kd_schedule *schedule;
    kd_query *positions, *charges;
    uint32_t fill;
    kd_entity root, roots[MOST], children[MOST];
    kd_snapshot snapshot;
    char path[40];
    bool recorded; /* the call records commands: it fails at the merge */
    int told;
} stage;

static int messages;
static void count_message(void *user, kd_log_level level, const char *text)
{
    (void)user, (void)text;
    messages += level == KD_LOG_ERROR;
}

static void hear(kd_world *w, const kd_observed *what, void *user)
{
    (void)w, (void)what;
    ++*(int *)user;
}

static void furnish(stage *s, uint32_t fill)
{
    *s = (stage){.w = kd_world_make(), .fill = fill, .jobs = s->jobs};
    assert_non_null(s->w);
    kd_world *w = s->w;
    s->root = kd_spawn(w, KD_TAG(position));
    for (uint32_t i = 0; i < fill; i++) {
        char name[16];
        s->roots[i] = kd_spawn(w, KD_VAL(position, {(float)i, 1, 2}), KD_TAG(health));
        s->children[i] = kd_spawn_child(w, s->root, KD_TAG(position), KD_VAL(bond, {s->roots[i], i}),
                                        KD_VAL(charge, {(float)i}));
        snprintf(name, sizeof name, "name %u", i);
        assert_int_equal(kd_set_name(w, s->children[i], name), KD_OK);
        assert_int_equal(i % 3 ? KD_OK : kd_disable(w, s->children[i], charge), KD_OK);
    }
    (void)KD_ID(w, velocity), (void)KD_ID(w, lamp), (void)KD_ID(w, frozen), (void)KD_ID(w, label);
    s->positions = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(position)}});
    s->charges = kd_query_make(w, &(kd_query_desc){.terms = {KD_WRITE(charge)}, .by_depth = true});
    assert_true(s->positions && s->charges);
}

static void clear(stage *s)
{
    kd_schedule_destroy(s->schedule);
    kd_world_destroy(s->w);
    kd_snapshot_fini(&s->snapshot);
    if (s->path[0])
        unlink(s->path);
}

/* ---- what is called ---- */
static void relate_all(stage *s)
{
    for (uint32_t i = 0; i < s->fill; i++) {
        assert_int_equal(kd_relate_with(s->w, s->children[i], likes, s->roots[i / 2], {1}), KD_OK);
        assert_int_equal(kd_relate(s->w, s->roots[i], part_of, s->root), KD_OK);
    }
}
static void relate_and_observe(stage *s)
{
    relate_all(s);
    assert_int_equal(kd_observe(s->w, &likes_desc, 15, hear, &s->told), KD_OK);
    assert_int_equal(kd_observe(s->w, &part_of_desc, 15, hear, &s->told), KD_OK);
}
static void observe_all(stage *s)
{
    static const kd_component_desc *const all[] = {&position_desc, &health_desc, &charge_desc, &bond_desc,
                                                   &velocity_desc};
    for (int i = 0; i < 5; i++)
        assert_int_equal(kd_observe(s->w, all[i], 15, hear, &s->told), KD_OK);
}

static bool call_component(stage *s)
{
    return kd_component_ensure(s->w, &late_desc) != 0;
}
static bool call_find(stage *s)
{
    return !kd_find(s->w, s->root, late) && KD_ID(s->w, late);
}
static bool call_spawn(stage *s)
{
    return kd_spawn(s->w, KD_VAL(position, {1, 2, 3}), KD_TAG(health)).generation != 0;
}
static bool call_spawn_late(stage *s)
{
    return kd_spawn(s->w, KD_VAL(late, {1}), KD_TAG(lamp), KD_VAL(charge, {4})).generation != 0;
}
static bool call_spawn_many(stage *s)
{
    return kd_spawn(s->w, KD_TAG(position), KD_TAG(velocity), KD_TAG(health), KD_TAG(bond), KD_TAG(padded),
                    KD_TAG(frozen), KD_TAG(charge), KD_TAG(lamp), KD_TAG(label), KD_TAG(late), KD_TAG(wide))
               .generation != 0;
}
static bool call_spawn_child(stage *s)
{
    kd_entity parent = s->fill ? s->children[s->fill - 1] : s->root;
    return kd_spawn_child(s->w, parent, KD_TAG(position), KD_TAG(bond), KD_TAG(charge)).generation != 0;
}
static bool call_spawn_child_many(stage *s)
{
    return kd_spawn_child(s->w, s->root, KD_TAG(position), KD_TAG(velocity), KD_TAG(health), KD_TAG(bond),
                          KD_TAG(padded), KD_TAG(frozen), KD_TAG(charge), KD_TAG(lamp), KD_TAG(label))
               .generation != 0;
}
static bool call_spawn_n(stage *s)
{
    static const kd_component_desc *const descs[] = {&position_desc, &late_desc, &charge_desc};
    return kd_spawn_n(s->w, 20, descs, NULL, 3, NULL) == KD_OK;
}
enum { LARGE = 400000 }; /* of positions: a column that is mapped on its own */
static void prepare_large(stage *s)
{
    static const kd_component_desc *const descs[] = {&position_desc};
    assert_int_equal(kd_spawn_n(s->w, LARGE, descs, NULL, 1, NULL), KD_OK);
}
static bool call_spawn_large(stage *s)
{
    static const kd_component_desc *const descs[] = {&position_desc};
    return kd_spawn_n(s->w, LARGE, descs, NULL, 1, NULL) == KD_OK;
}
static bool call_destroy(stage *s)
{
    kd_destroy(s->w, s->root);
    return true;
}
static bool call_set(stage *s)
{
    return kd_set(s->w, s->root, velocity, {1, 2, 3}) == KD_OK;
}
static bool call_set_late(stage *s)
{
    return kd_set(s->w, s->fill ? s->roots[0] : s->root, late, {1}) == KD_OK;
}
static bool call_set_sparse(stage *s)
{
    return kd_set(s->w, s->root, charge, {1}) == KD_OK;
}
static bool call_set_new_sparse(stage *s)
{
    return kd_set(s->w, s->root, wide, {{1}}) == KD_OK;
}
static bool call_remove(stage *s)
{
    return kd_remove(s->w, s->root, position) == KD_OK;
}
static bool call_remove_sparse(stage *s)
{
    if (s->fill)
        kd_remove(s->w, s->children[0], charge);
    return true;
}
static bool call_enable(stage *s)
{
    return !s->fill || kd_disable(s->w, s->children[s->fill - 1], charge) == KD_OK;
}
static bool call_singleton(stage *s)
{
    return kd_singleton(s->w, late) != NULL;
}
static bool call_name(stage *s)
{
    return kd_set_name(s->w, s->root, "a name that nobody bears yet") == KD_OK;
}
static bool call_name_again(stage *s)
{
    return kd_set_name(s->w, s->root, "name 0") == KD_OK;
}
static bool call_rename(stage *s)
{
    return !s->fill || kd_set_name(s->w, s->children[0], "another") == KD_OK;
}
static bool call_parent(stage *s)
{
    kd_entity to = s->fill ? s->roots[0] : KD_NO_ENTITY;
    return kd_set_parent(s->w, s->root, to) == KD_OK; /* with all that hangs on it */
}
static bool call_orphan(stage *s)
{
    return !s->fill || kd_set_parent(s->w, s->children[s->fill / 2], KD_NO_ENTITY) == KD_OK;
}
static bool call_query(stage *s)
{
    return kd_query_make(s->w,
                         &(kd_query_desc){.terms = {KD_READ(position), KD_OPTIONAL(late), KD_WITH(bond)},
                                          .by_depth = true,
                                          .name = "a query"}) != NULL;
}
static bool call_destroy_query(stage *s)
{
    return kd_destroy_query(s->charges) == KD_OK;
}
static bool call_destroy_plain_query(stage *s)
{
    return kd_destroy_query(s->positions) == KD_OK;
}
static bool call_destroy_n(stage *s)
{
    kd_destroy_n(s->w, s->children, s->fill);
    return true;
}
static bool call_instantiate(stage *s)
{
    kd_entity out[3];
    kd_entity to = s->fill ? s->roots[0] : KD_NO_ENTITY;
    return kd_instantiate(s->w, s->root, to, 3, out) == KD_OK;
}
static bool call_clone(stage *s)
{
    return kd_clone(s->w, s->root).generation != 0;
}
static bool call_observe(stage *s)
{
    return kd_observe(s->w, &late_desc, KD_ON_ADD, hear, &s->told) == KD_OK;
}
static bool call_unobserve(stage *s)
{
    kd_unobserve(s->w, &late_desc, hear, &s->told);
    return true;
}

/* ---- commands: a failed recording shows at the merge ---- */
static bool merged(stage *s)
{
    s->recorded = true;
    allocation.countdown = -1;
    return kd_world_merge(s->w) == KD_OK;
}
static bool call_record_spawn(stage *s)
{
    kd_commands_spawn(kd_world_commands(s->w, 0), (kd_value[]){KD_TAG(position), KD_VAL(late, {1})}, 2);
    return merged(s);
}
static bool call_record_destroy(stage *s)
{
    kd_commands_destroy(kd_world_commands(s->w, 0), s->root);
    return merged(s);
}
static bool call_record_set(stage *s)
{
    kd_commands_set(kd_world_commands(s->w, 0), s->root, KD_VAL(late, {1}));
    return merged(s);
}
static bool call_record_remove(stage *s)
{
    kd_commands_remove(kd_world_commands(s->w, 0), s->root, &position_desc);
    return merged(s);
}
static bool call_record_enable(stage *s)
{
    if (s->fill > 1)
        kd_commands_enable(kd_world_commands(s->w, 0), s->children[1], &charge_desc, false);
    return merged(s);
}
static bool call_record_parent(stage *s)
{
    if (s->fill > 1)
        kd_commands_set_parent(kd_world_commands(s->w, 0), s->children[0], s->children[1]);
    return merged(s);
}
static bool call_record_name(stage *s)
{
    kd_commands_set_name(kd_world_commands(s->w, 0), s->root, "named by a command");
    return merged(s);
}

static void record_all(stage *s)
{
    kd_world *w = s->w;
    for (uint32_t worker = 0; worker < 3; worker++) {
        kd_commands *c = kd_world_commands(w, worker);
        kd_commands_key(c, 10 - worker);
        kd_entity e = kd_commands_spawn(c, (kd_value[]){KD_TAG(position), KD_TAG(lamp)}, 2);
        kd_commands_set_parent(c, e, s->root);
        kd_commands_set_name(c, e, "commanded");
        kd_commands_enable(c, e, &lamp_desc, false);
        kd_commands_set(c, e, KD_VAL(bond, {e, 1}));
        kd_commands_remove(c, e, &position_desc);
    }
    kd_commands *c = kd_world_commands(w, 3);
    for (uint32_t i = 0; i < s->fill; i++)
        kd_commands_set(c, s->roots[i], KD_VAL(velocity, {1, 2, 3})); /* neighbours: moved as one */
    for (uint32_t i = 0; i < s->fill / 2; i++)
        kd_commands_destroy(c, s->children[i]);
}
static bool call_merge(stage *s)
{
    if (!kd_world_has_commands(s->w)) /* a merge that could not begin leaves them */
        record_all(s);
    return kd_world_merge(s->w) == KD_OK;
}

/* ---- relations ---- */
static bool call_relate(stage *s)
{
    return kd_relate_with(s->w, s->root, likes, s->fill ? s->roots[0] : s->root, {2}) == KD_OK;
}
static bool call_relate_exclusive(stage *s)
{
    kd_entity source = s->fill ? s->roots[0] : s->root; /* leaves its target for another */
    return kd_relate(s->w, source, part_of, s->fill > 1 ? s->children[1] : s->root) == KD_OK;
}
static bool call_unrelate(stage *s)
{
    if (s->fill)
        kd_unrelate(s->w, s->children[0], likes, s->roots[0]);
    return true;
}
static bool call_remove_relation(stage *s)
{
    return !s->fill || kd_remove(s->w, s->children[0], likes) == KD_OK;
}
static bool call_query_target(stage *s)
{
    return kd_query_make(s->w, &(kd_query_desc){.terms = {KD_READ(position), KD_WITH(likes)}}) != NULL;
}
static bool call_record_relate(stage *s)
{
    kd_commands_relate(kd_world_commands(s->w, 0), s->root, KD_VAL(likes, {3}), s->root);
    return merged(s);
}
static bool call_record_unrelate(stage *s)
{
    if (s->fill)
        kd_commands_unrelate(kd_world_commands(s->w, 0), s->children[0], &likes_desc, s->roots[0]);
    return merged(s);
}

/* ---- loops, reflection, snapshots ---- */
static void push_rows(kd_iter *rows, kd_commands *commands, void *user)
{
    position *p = KD_COLUMN_MUT(rows, position, 0);
    (void)commands, (void)user;
    for (uint32_t i = 0; i < rows->count; i++)
        p[i].x += 1;
}
static void prepare_tables(stage *s)
{
    static const kd_component_desc *const some[] = {&velocity_desc, &health_desc, &bond_desc,
                                                    &padded_desc,   &frozen_desc, &lamp_desc,
                                                    &label_desc,    &late_desc,   &position_desc};
    for (uint32_t set = 0; set < 256; set++) { /* more tables than a query numbers without a list */
        kd_value values[9];
        uint32_t count = 0;
        for (uint32_t k = 0; k < 9; k++)
            if (k == 8 || set >> k & 1)
                values[count++] = (kd_value){some[k], NULL};
        assert_true(kd_spawn_values(s->w, values, count).generation);
    }
}
static bool call_parallel(stage *s)
{
    return kd_query_parallel(s->positions, s->jobs, 0, push_rows, NULL) == KD_OK;
}
static bool call_field(stage *s)
{
    kd_field_ref ref;
    char text[64];
    return kd_field_resolve(s->w, "position.x", &ref) == KD_OK &&
           kd_field_write(s->w, s->root, &ref, &(double){1}, 1) == KD_OK &&
           kd_field_write_text(s->w, s->root, &ref, "2") == KD_OK &&
           *kd_field_read_text(s->w, s->root, &ref, text, sizeof text);
}
static bool call_field_of_singleton(stage *s)
{
    kd_field_ref ref;
    double number;
    return kd_field_resolve(s->w, "label.text", &ref) == KD_OK &&
           kd_field_write_text(s->w, KD_NO_ENTITY, &ref, "of the world") == KD_OK &&
           kd_field_resolve(s->w, "velocity.y", &ref) == KD_OK &&
           kd_field_write(s->w, KD_NO_ENTITY, &ref, &(double){1}, 1) == KD_OK &&
           kd_field_read(s->w, KD_NO_ENTITY, &ref, &number, 1) == KD_OK;
}
static bool call_snapshot(stage *s)
{
    bool done = kd_snapshot_write(s->w, &s->snapshot) == KD_OK;
    assert_true(done == (s->snapshot.size != 0));
    return done;
}
static void prepare_restore(stage *s)
{
    relate_all(s);
    kd_singleton(s->w, label)->text[0] = 'a';
    assert_int_equal(kd_snapshot_write(s->w, &s->snapshot), KD_OK);
    kd_world_destroy(s->w); /* into a world that holds other things */
    s->w = kd_world_make();
    kd_spawn(s->w, KD_TAG(position), KD_TAG(health), KD_TAG(bond), KD_TAG(charge), KD_VAL(owner, {owned(1)}));
    s->root = kd_spawn(s->w, KD_TAG(label));
    (void)KD_ID(s->w, label), (void)KD_ID(s->w, likes), (void)KD_ID(s->w, part_of);
    s->positions = kd_query_make(s->w, &(kd_query_desc){.terms = {KD_WRITE(position)}});
}
static bool call_restore(stage *s)
{
    return kd_snapshot_restore(s->w, s->snapshot.data, s->snapshot.size) == KD_OK;
}
static void prepare_file(stage *s)
{
    strcpy(s->path, "/tmp/kandil-allocation-XXXXXX");
    int fd = mkstemp(s->path);
    assert_true(fd >= 0);
    close(fd);
}
static bool call_save(stage *s)
{
    return kd_snapshot_save(s->w, s->path) == KD_OK;
}
static void prepare_load(stage *s)
{
    prepare_file(s);
    assert_int_equal(kd_snapshot_save(s->w, s->path), KD_OK);
    kd_destroy(s->w, s->root);
}
static bool call_load(stage *s)
{
    return kd_snapshot_load(s->w, s->path) == KD_OK;
}
static void prepare_json(stage *s)
{
    assert_int_equal(kd_set(s->w, s->root, label, {"lettered"}), KD_OK);
}
static bool call_json(stage *s)
{
    kd_json j = {0};
    kd_world_write_json(s->w, &j);
    const char *text = kd_json_text(&j);
    bool done = text && strstr(text, "lettered");
    assert_true(done || !text); /* whole or not at all */
    kd_json_fini(&j);
    return done;
}
static bool call_statistics(stage *s)
{
    kd_json j = {0};
    kd_world_write_statistics(s->w, &j);
    bool done = kd_json_text(&j) != NULL;
    kd_json_fini(&j);
    return done;
}
static bool call_diff(stage *s)
{
    kd_difference d;
    char text[64];
    return kd_world_diff(s->w, s->w, &d, 1) == 0 &&
           *kd_difference_text(s->w, s->w, &(kd_difference){.entity = s->root}, text, sizeof text);
}

/* ---- schedules ---- */
static void run_system(kd_system_context *context)
{
    kd_commands_set_name(context->commands, KD_NO_ENTITY, "nobody");
}
static const kd_system_desc a_system = {.name = "a system",
                                        .phase = KD_PHASE_ANIMATE,
                                        .components = {KD_USES(late), KD_CHANGES(velocity)},
                                        .run = run_system};
static bool call_schedule_make(stage *s)
{
    s->schedule = kd_schedule_make(s->w, NULL, NULL);
    return s->schedule != NULL;
}
static void prepare_schedule(stage *s)
{
    s->schedule = kd_schedule_make(s->w, s->jobs, NULL);
    assert_non_null(s->schedule);
}
static bool call_schedule_add(stage *s)
{
    uint32_t count = kd_schedule_count(s->schedule);
    bool done = kd_schedule_add(s->schedule, &a_system) == KD_OK;
    assert_int_equal(kd_schedule_count(s->schedule), count + done);
    return done;
}
static void prepare_systems(stage *s)
{
    prepare_schedule(s);
    assert_true(call_schedule_add(s));
}
static bool call_schedule_run(stage *s)
{
    return kd_schedule_init(s->schedule) == KD_OK && kd_schedule_run(s->schedule) == KD_OK;
}
static void prepare_dot(stage *s)
{
    prepare_systems(s);
    prepare_file(s);
    assert_true(call_schedule_run(s));
}
static bool call_dot(stage *s)
{
    return kd_schedule_write_dot(s->schedule, s->path) == KD_OK;
}

typedef struct attempt {
    const char *name;
    bool (*call)(stage *s);
    void (*prepare)(stage *s);
    enum {
        QUIET = 1,  /* the failure shows in what is returned, without a message */
        PARTLY = 2, /* what failed may have been done in part: what is left is sound all the same */
        SPENDS = 4, /* a failed attempt uses handles up: the next one gives others */
        HEAVY = 8,  /* once is enough */
        LONG = 16,  /* as many allocations as entities: small worlds are enough */
    } flags;
} attempt;

static const attempt attempts[] = {
    {"kd_component_ensure", call_component, NULL, 0},
    {"kd_find of an unknown component", call_find, NULL, 0},
    {"kd_spawn", call_spawn, NULL, 0},
    {"kd_spawn, observed", call_spawn, observe_all, 0},
    {"kd_spawn of new components", call_spawn_late, NULL, 0},
    {"kd_spawn of many components", call_spawn_many, NULL, 0},
    {"kd_spawn_child", call_spawn_child, NULL, 0},
    {"kd_spawn_child of many components", call_spawn_child_many, NULL, 0},
    {"kd_spawn_n", call_spawn_n, NULL, 0},
    {"kd_spawn_n, observed", call_spawn_n, observe_all, 0},
    {"kd_spawn_n that makes blocks mapped", call_spawn_large, NULL, HEAVY},
    {"kd_spawn_n that moves mapped blocks", call_spawn_large, prepare_large, HEAVY},
    {"kd_destroy", call_destroy, NULL, 0},
    {"kd_destroy, observed", call_destroy, observe_all, 0},
    {"kd_set", call_set, NULL, 0},
    {"kd_set, observed", call_set, observe_all, 0},
    {"kd_set of a new component", call_set_late, NULL, 0},
    {"kd_set of a sparse component", call_set_sparse, NULL, 0},
    {"kd_set of a new sparse component", call_set_new_sparse, NULL, 0},
    {"kd_remove", call_remove, NULL, 0},
    {"kd_remove, observed", call_remove, observe_all, 0},
    {"kd_remove of a sparse component", call_remove_sparse, observe_all, 0},
    {"kd_disable", call_enable, NULL, 0},
    {"kd_singleton", call_singleton, NULL, 0},
    {"kd_set_name", call_name, NULL, 0},
    {"kd_set_name to one that is known", call_name_again, NULL, 0},
    {"kd_set_name of a named one", call_rename, NULL, 0},
    {"kd_set_parent", call_parent, NULL, 0},
    {"kd_set_parent to none", call_orphan, NULL, 0},
    {"kd_query_make", call_query, NULL, 0},
    {"kd_destroy_query", call_destroy_query, NULL, 0},
    {"kd_destroy_query, observed", call_destroy_plain_query, observe_all, 0},
    {"kd_destroy_n", call_destroy_n, observe_all, 0},
    {"kd_instantiate", call_instantiate, NULL, SPENDS},
    {"kd_instantiate, observed", call_instantiate, observe_all, SPENDS},
    {"kd_clone", call_clone, NULL, SPENDS},
    {"kd_observe", call_observe, NULL, 0},
    {"kd_unobserve", call_unobserve, NULL, 0},
    {"kd_commands_spawn", call_record_spawn, NULL, 0},
    {"kd_commands_destroy", call_record_destroy, NULL, 0},
    {"kd_commands_set", call_record_set, NULL, 0},
    {"kd_commands_remove", call_record_remove, NULL, 0},
    {"kd_commands_enable", call_record_enable, NULL, 0},
    {"kd_commands_set_parent", call_record_parent, NULL, 0},
    {"kd_commands_set_name", call_record_name, NULL, 0},
    {"kd_world_merge", call_merge, record_all, PARTLY},
    {"kd_relate", call_relate, NULL, 0},
    {"kd_relate among pairs", call_relate, relate_and_observe, 0},
    {"kd_relate of an exclusive relation", call_relate_exclusive, relate_all, 0},
    {"kd_unrelate", call_unrelate, relate_and_observe, 0},
    {"kd_remove of a relation", call_remove_relation, relate_and_observe, 0},
    {"kd_destroy of related entities", call_destroy, relate_and_observe, 0},
    {"kd_instantiate of related entities", call_instantiate, relate_all, SPENDS},
    {"kd_query_make with a relation", call_query_target, relate_all, 0},
    {"kd_commands_relate", call_record_relate, relate_all, 0},
    {"kd_commands_unrelate", call_record_unrelate, relate_all, 0},
    {"kd_snapshot_write of pairs", call_snapshot, relate_all, 0},
    {"kd_query_parallel", call_parallel, prepare_tables, 0},
    {"kd_field_write", call_field, NULL, 0},
    {"kd_field_write of a singleton", call_field_of_singleton, NULL, 0},
    {"kd_snapshot_write", call_snapshot, NULL, 0},
    {"kd_snapshot_restore", call_restore, prepare_restore, LONG},
    {"kd_snapshot_save", call_save, prepare_file, 0},
    {"kd_snapshot_load", call_load, prepare_load, LONG},
    {"kd_world_write_json", call_json, prepare_json, QUIET},
    {"kd_world_write_statistics", call_statistics, NULL, QUIET},
    {"kd_world_diff", call_diff, NULL, 0},
    {"kd_schedule_make", call_schedule_make, NULL, 0},
    {"kd_schedule_add", call_schedule_add, prepare_schedule, 0},
    {"kd_schedule_run", call_schedule_run, prepare_systems, 0},
    {"kd_schedule_write_dot", call_dot, prepare_dot, 0},
};

static stage the_stage;

static void set_stage(const attempt *a, uint32_t fill)
{
    furnish(&the_stage, fill);
    if (a->prepare)
        a->prepare(&the_stage);
}

/* The checksum after a call that nothing disturbs. */
static uint64_t undisturbed(const attempt *a, uint32_t fill)
{
    set_stage(a, fill);
    assert_true(a->call(&the_stage));
    assert_int_equal(kd_world_validate(the_stage.w), KD_OK);
    uint64_t checksum = kd_world_checksum(the_stage.w);
    clear(&the_stage);
    return checksum;
}

/* One attempt whose k-th allocation fails. Returns false when there were not that many. */
static bool disturb(const attempt *a, uint32_t fill, long k, failure_kind kind, uint64_t expected)
{
    set_stage(a, fill);
    kd_world *w = the_stage.w;
    uint64_t before = kd_world_checksum(w);
    uint32_t alive = kd_entity_count(w);
    messages = 0;
    allocations_fail_at(k, kind);
    bool done = a->call(&the_stage);
    long failed = allocations_succeed();
    assert_true(done || failed);
    assert_true(!failed || messages || a->flags & QUIET);
    assert_int_equal(kd_world_validate(w), KD_OK);
    if (!done && (!(a->flags & PARTLY) || kd_world_has_commands(w))) {
        assert_true(kd_world_checksum(w) == before);
        assert_int_equal(kd_entity_count(w), alive);
    }
    if (!done)
        assert_true(a->call(&the_stage));
    assert_int_equal(kd_world_validate(w), KD_OK);
    if (done || !(a->flags & (PARTLY | SPENDS)))
        assert_true(kd_world_checksum(w) == expected);
    clear(&the_stage);
    return failed != 0;
}

static void every_allocation_may_fail(void **state)
{
    static const uint32_t fills[] = {0, 1, 3, 4, 7, 8, 15, 16, 127, 255};
    (void)state;
    the_stage.jobs = kd_jobs_make(2);
    assert_non_null(the_stage.jobs);
    kd_log_set_sink(count_message, NULL);
    for (size_t i = 0; i < sizeof attempts / sizeof *attempts; i++) {
        long most = 0;
        size_t all = sizeof fills / sizeof *fills;
        size_t fill_count = attempts[i].flags & HEAVY ? 1 : attempts[i].flags & LONG ? all - 2 : all;
        for (size_t f = 0; f < fill_count; f++) {
            uint64_t expected = undisturbed(&attempts[i], fills[f]);
            for (int kind = FAIL_ONCE; kind <= FAIL_ON; kind++) {
                long k = 0;
                while (disturb(&attempts[i], fills[f], k, (failure_kind)kind, expected))
                    k++;
                most = k > most ? k : most;
            }
        }
        print_message("%-36s %ld\n", attempts[i].name, most);
    }
    kd_log_set_sink(NULL, NULL);
    kd_jobs_destroy(the_stage.jobs);
}

static void a_world_is_made_or_not(void **state)
{
    long k = 0, failed;
    (void)state;
    kd_log_set_sink(count_message, NULL);
    do {
        messages = 0;
        allocations_fail_at(k++, FAIL_ONCE);
        kd_world *w = kd_world_make();
        failed = allocations_succeed();
        assert_int_equal(w == NULL, failed != 0);
        assert_int_equal(messages != 0, failed != 0);
        kd_world_destroy(w);
    } while (failed);
    assert_true(k > 3);
    kd_log_set_sink(NULL, NULL);
}

/* What could not be recorded is reported by the merge that applies the rest, even if an earlier one could not
 * begin. */
static void a_lost_command_is_not_forgotten(void **state)
{
    (void)state;
    kd_log_set_sink(count_message, NULL);
    kd_world *w = kd_world_make();
    kd_entity e = kd_spawn(w, KD_TAG(position));
    kd_commands_key(kd_world_commands(w, 0), 2);
    kd_commands_spawn(kd_world_commands(w, 0), (kd_value[]){KD_TAG(position)}, 1);
    kd_commands_set(kd_world_commands(w, 2), e, KD_VAL(velocity, {1, 2, 3}));
    allocations_fail_at(0, FAIL_ON);
    kd_commands_set(kd_world_commands(w, 1), e, KD_VAL(health, {1, 2}));
    assert_int_equal(kd_world_merge(w), KD_NO_MEMORY);
    assert_true(allocations_succeed() > 1 && kd_world_has_commands(w));
    assert_int_equal(kd_world_merge(w), KD_NO_MEMORY);
    assert_true(kd_has(w, e, velocity) && !kd_has(w, e, health) && kd_entity_count(w) == 2);
    assert_int_equal(kd_world_merge(w), KD_OK);
    kd_world_destroy(w);
    kd_log_set_sink(NULL, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(a_world_is_made_or_not),
        cmocka_unit_test(a_lost_command_is_not_forgotten),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
