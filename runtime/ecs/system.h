#ifndef KD_ECS_SYSTEM_H
#define KD_ECS_SYSTEM_H

/* Systems: behaviour with declared access. From the declarations of all systems the scheduler derives one
 * graph for the frame: the order, what runs in parallel, and which memory barrier stands before which GPU
 * system. Two systems conflict when one writes a component or GPU resource that the other reads or writes;
 * conflicting systems run in order of (phase, registration). Systems that do not conflict may run at the same
 * time, whatever their phase, up to the next merge: after each phase with a system that may record commands
 * (it is exclusive, or changes a component and is not marked no_commands) everything waits for the commands
 * to be merged on the GPU lane, so that what a system sees never depends on timing. */

#include "runtime/ecs/query.h"

struct kd_gpu;
struct kd_jobs;
struct kd_arena;

#define KD_PHASE_LIST(X)                                                                                     \
    X(INPUT, "input")                                                                                        \
    X(SCRIPT, "script")                                                                                      \
    X(ANIMATE, "animate") X(HIERARCHY, "hierarchy") X(DEFORM, "deform") X(CULL, "cull") X(SHADOW, "shadow")  \
        X(VOXEL_IO, "voxel_io") X(VOXEL_TRANSFORM, "voxel_transform") X(SVO_BUILD, "svo_build")              \
            X(VOXEL_AGAIN, "voxel_again") X(SVO_AGAIN, "svo_again") X(LIGHT_INJECT, "light_inject")          \
                X(SVO_FILTER, "svo_filter") X(BOUNCE, "bounce") X(BOUNCE_INJECT, "bounce_inject")            \
                    X(BOUNCE_FILTER, "bounce_filter") X(GEOMETRY, "geometry") X(GATHER, "gather")            \
                        X(RESOLVE, "resolve") X(VIEW, "view") X(CAPTURE, "capture")
typedef enum kd_phase {
#define KD_PHASE_ENUM(name, text) KD_PHASE_##name,
    KD_PHASE_LIST(KD_PHASE_ENUM)
#undef KD_PHASE_ENUM
        KD_PHASE_COUNT
} kd_phase;
const char *kd_phase_name(kd_phase phase);

typedef enum kd_where { KD_ON_CPU, KD_ON_GPU } kd_where; /* KD_ON_GPU: run on the GPU lane, in graph order */

/* How a GPU system touches a resource: decides the barrier before it. Values combine. */
typedef enum kd_gpu_use {
    KD_USE_STORAGE_READ = 1,
    KD_USE_STORAGE_WRITE = 2,
    KD_USE_IMAGE_READ = 4,
    KD_USE_IMAGE_WRITE = 8,
    KD_USE_SAMPLED = 16,
    KD_USE_VERTEX = 32,
    KD_USE_INDEX = 64,
    KD_USE_INDIRECT = 128,
    KD_USE_UNIFORM = 256,
    KD_USE_TARGET = 512, /* rendered to */
    KD_USE_COPY_READ = 1024,
    KD_USE_COPY_WRITE = 2048, /* kd_gpu_write/read/copy/fill_buffer, readback, texture copies */
} kd_gpu_use;
#define KD_USE_WRITES (KD_USE_STORAGE_WRITE | KD_USE_IMAGE_WRITE | KD_USE_TARGET | KD_USE_COPY_WRITE)

typedef struct kd_resource_use {
    const char *resource; /* name of a GPU resource: "svo.nodes", "gbuffer", … NULL ends the list */
    uint32_t use;         /* kd_gpu_use bits */
} kd_resource_use;

typedef struct kd_component_use {
    const kd_component_desc *desc; /* NULL ends the list; singletons are listed here too */
    bool write;
} kd_component_use;

typedef struct kd_system_context {
    kd_world *world;
    struct kd_gpu *gpu; /* NULL for CPU systems */
    struct kd_jobs *jobs;
    struct kd_arena *scratch; /* emptied every frame; one per worker */
    kd_commands
        *commands; /* of the worker that runs the system, its key set to command_key; NULL with no_commands */
    void *user;
    uint32_t worker;
    double time_s;        /* simulated: at the frame's beginning; of a fixed rate: the end of the step */
    double dt_s;          /* simulated time that this run stands for, see kd_system_rate */
    uint32_t frame;       /* frames run before this one */
    uint64_t command_key; /* of this run: parallel loops record under command_key + row in
                           * kd_world_commands(world, worker); < 2^32 rows. A loop of jobs that set keys
                           * leaves one on every worker: set that of `commands` anew before going on */
} kd_system_context;

/* How often a system runs. What is due follows from the world's clock (kd_schedule_clock) and nothing else:
 * the same frames at any thread count, with a system disabled and enabled again, after a snapshot was
 * restored.
 *
 * {0}           every frame, dt_s = the frame's step
 * every_s       fixed: the k-th run stands for the time from (k-1) every_s to k every_s, and happens in the
 * frame that reaches its end: none, one or several a frame, dt_s = every_s. Of a long frame only the last
 * max_runs are made, and the time before them is not made up for every_frames  variable: the frames whose
 * number is offset_frames, offset_frames + every_frames, …; dt_s is that many of the frame's steps. Offsets
 * spread costly systems over the frames */
typedef struct kd_system_rate {
    double every_s;                       /* 0: by frames */
    uint32_t max_runs;                    /* of a fixed rate in one frame; 0: 8 */
    uint32_t every_frames, offset_frames; /* 0 as 1: every frame; offset_frames < every_frames */
} kd_system_rate;

#define KD_MAX_COMPONENT_USES 24
#define KD_MAX_RESOURCE_USES  24
typedef struct kd_system_desc {
    const char *name; /* copied */
    kd_phase phase;
    kd_where where;
    kd_component_use components[KD_MAX_COMPONENT_USES];
    kd_resource_use resources[KD_MAX_RESOURCE_USES]; /* the names must outlive the schedule */
    bool exclusive;   /* touches what cannot be listed (a scripting host): conflicts with every system */
    bool no_commands; /* changes components but never records commands: needs no merge after its phase */
    void (*run)(kd_system_context *context);
    kd_system_rate rate;
    bool (*run_if)(kd_system_context
                       *context); /* asked before each run that is due, with what it declares; NULL: always */
    kd_status (*init)(
        kd_system_context *context); /* once before the first frame, on the lane it runs on; NULL allowed */
    void (*fini)(kd_system_context *context); /* at the end, reverse order */
    uint64_t (*bytes_moved)(
        const kd_system_context *context); /* of the last run, for the profile; NULL: unknown */
    void *user;
} kd_system_desc;

#define KD_USES(type)                                                                                        \
    {                                                                                                        \
        &type##_desc, false                                                                                  \
    }
#define KD_CHANGES(type)                                                                                     \
    {                                                                                                        \
        &type##_desc, true                                                                                   \
    }

typedef struct kd_schedule kd_schedule;

kd_schedule *kd_schedule_make(kd_world *w, struct kd_jobs *jobs, struct kd_gpu *gpu);
void kd_schedule_destroy(kd_schedule *s); /* runs every fini */
/** Leave out every system of the GPU lane, its init and fini too: for those who want the state of the world
 * and no picture. To be called before the schedule's init. */
void kd_schedule_leave_out_gpu(kd_schedule *s);
/** Register a system. All must be registered before the first run. Errors KD_OUT_OF_RANGE for too many (256);
 * KD_USAGE, with a message, for one that comes later, without a name or a function, or with a rate that makes
 * no sense. */
kd_status kd_schedule_add(kd_schedule *s, const kd_system_desc *desc);
/** Run every init in registration order. */
kd_status kd_schedule_init(kd_schedule *s);
/** Run one frame: every system once, then merge commands at each phase border at which some were recorded.
 * Returns the first status of a merge that is not KD_OK (refused commands, no memory); the frame was run all
 * the same. */
kd_status kd_schedule_run(kd_schedule *s);
/** Let a system run or not, and all of the same name. Takes effect with the next frame. Errors NOT_FOUND,
 * with a message. */
kd_status kd_schedule_enable(kd_schedule *s, const char *name, bool enabled);

/* ---- simulated time ---- */
/* Singleton of the world, so that snapshots hold it and restoring one brings the rates back. */
typedef struct kd_schedule_clock {
    double time_s; /* at the beginning of the next frame */
    double step_s; /* of the last frame */
    uint32_t frame;
} kd_schedule_clock;
KD_COMPONENT_DECLARE(kd_schedule_clock);
/** Say how much simulated time each frame from now on stands for; 1/60 s at first. */
void kd_schedule_set_step(kd_schedule *s, double step_s);

/* Called round each system on the thread that runs it (worker KD_GPU_LANE for GPU systems); the profiler
 * hooks in here. */
typedef struct kd_schedule_hooks {
    void (*begin)(void *user, uint32_t system, uint32_t worker);
    void (*end)(void *user, uint32_t system, uint32_t worker);
    void *user;
    /* Issue the derived barrier, between begin and the system: `uses` are the kd_gpu_use bits by which the
     * next reader touches what was written. */
    void (*barrier)(void *user, struct kd_gpu *gpu, uint32_t uses);
    /* Called round what the schedule itself does on the GPU lane: merging commands (merge) or waiting for
     * systems on other workers, helping them meanwhile. */
    void (*own)(void *user, bool merge, bool begin);
} kd_schedule_hooks;
void kd_schedule_set_hooks(kd_schedule *s, const kd_schedule_hooks *hooks);

uint32_t kd_schedule_count(const kd_schedule *s);
const kd_system_desc *kd_schedule_system(const kd_schedule *s, uint32_t index); /* NULL: there is none */
/** Ask a system how much memory its last run moved; 0 when it cannot tell, or is not there. Threading: the
 * lane, between frames. */
uint64_t kd_schedule_bytes_moved(kd_schedule *s, uint32_t index);

/* ---- statistics ---- */
typedef struct kd_system_statistics {
    uint64_t runs;
    uint64_t disabled, not_due,
        refused;      /* frames without a run, and why: kd_schedule_enable, its rate, run_if */
    uint64_t dropped; /* runs of a fixed rate beyond its max_runs */
    /* Of the runs that were measured: */
    double median_ms; /* of the latest 64 */
    double max_ms, total_ms;
    uint64_t rows, tables; /* that matched the queries it began to iterate */
} kd_system_statistics;
/** Measure times and rows from now on, or stop. Errors NO_MEMORY. Cost: some 60 ns a run, 10 ns a query. */
kd_status kd_schedule_measure(kd_schedule *s, bool measured);
/** All zeros for a system that is not there. Threading: between frames. */
kd_system_statistics kd_schedule_statistics(const kd_schedule *s, uint32_t index);

/* ---- finding wrong declarations ---- */
/** Check from now on, or stop, that systems touch what they declare: one runs after the other, with all that
 * it did not declare as written compared before and after. A system that iterates a query over undeclared
 * components, or changes what it declares as read or not at all, ends the frame with KD_USAGE and a message
 * that names it, the component, the query and the rows. kd_find and kd_find_mut of undeclared components are
 * found where assertions are on. Exclusive systems may do anything. Errors NO_MEMORY. Cost: reads the whole
 * world twice a system. */
kd_status kd_schedule_check(kd_schedule *s, bool checked);
/** Shuffle legal orders with this seed, one system at a time; 0: the normal order. A result that depends on
 * the seed means that a declaration is missing. */
void kd_schedule_randomize(kd_schedule *s, uint64_t seed);

/** Write the frame's graph in Graphviz's dot format. */
kd_status kd_schedule_write_dot(const kd_schedule *s, const char *path);

#endif
