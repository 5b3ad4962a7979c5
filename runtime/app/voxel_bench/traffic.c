#include "runtime/app/voxel_bench/traffic.h"

#include "runtime/core/clock.h"

/* Larger than the caches of the machines that this is made for. */
#define COPY_BYTES ((size_t)96 << 20)
enum { COPIES = 5, COPY_GROUP_BYTES = 128 * 16 };

/* Bytes of a voxel and of a cell in the lists of shaders/shared/voxel.h. */
enum {
    SHAPE = 8, /* a cached voxel's cell and normal */
    COLOR = 4,
    BINDING = KD_BINDING_WORDS * 4,
    PAGE = (int)KD_PAGE_WORDS * 4, /* a page voxel */
    CHAINS = 3 * 4,                /* of a voxel: it lies in three leaf parents, more or less */
    CELL = 16,                     /* attributes */
    LEAF = 8,                      /* radiance and depth */
    NODE = 8,                      /* the same of a sparse node */
    CHILDREN = 32,                 /* numbers of a node's children */
    DENSE_CELL = 48                /* six directions */
};

/* ---- copying ---- */

typedef struct copying {
    kd_gpu *gpu;
    kd_gpu_buffer from, to;
    kd_gpu_program program;
} copying;

static uint64_t copy_once(const copying *c, bool by_pass)
{
    kd_gpu_finish(c->gpu);
    uint64_t began = kd_clock_ns();
    if (by_pass) {
        kd_gpu_bind_storage(c->gpu, 0, c->from);
        kd_gpu_bind_storage(c->gpu, 1, c->to);
        kd_gpu_dispatch_linear(c->gpu, c->program, (uint32_t)(COPY_BYTES / COPY_GROUP_BYTES));
        kd_gpu_barrier(c->gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    } else
        kd_gpu_copy_buffer(c->gpu, c->from, 0, c->to, 0, COPY_BYTES);
    kd_gpu_finish(c->gpu);
    return kd_clock_ns() - began;
}

static uint64_t best_copy(const copying *c)
{
    uint64_t best = UINT64_MAX;
    for (int i = 0; i < 2 * COPIES; i++) {
        uint64_t ns = copy_once(c, i % 2 == 0);
        best = ns < best ? ns : best;
    }
    return best;
}

double traffic_copy_rate(kd_gpu *gpu)
{
    copying c = {
        .gpu = gpu,
        .from = kd_gpu_make_buffer(gpu,
                                   &(kd_gpu_buffer_desc){.size = COPY_BYTES, .zeroed = true, .name = "copy"}),
        .to = kd_gpu_make_buffer(gpu,
                                 &(kd_gpu_buffer_desc){.size = COPY_BYTES, .zeroed = true, .name = "copy"}),
        .program = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = "shaders/bench/copy.comp"})};
    double rate = 0;
    if (c.from.id && c.to.id && c.program.id)
        rate = 2.0 * (double)COPY_BYTES / ((double)best_copy(&c) * 1e-9);
    kd_gpu_destroy_program(gpu, c.program);
    kd_gpu_destroy_buffer(gpu, c.from);
    kd_gpu_destroy_buffer(gpu, c.to);
    return rate;
}

/* ---- what a stage must move ---- */

/* Every segment's record, which the CPU writes and the passes read. */
static uint64_t io_bytes(const rig_figures *f)
{
    return f->voxels / KD_SEGMENT_VOXELS * sizeof(struct kd_voxel_segment);
}

/* Shapes, colours and bindings in, page voxels and the mask of leaf parents out. */
static uint64_t transform_bytes(const rig_figures *f)
{
    return f->dynamic_voxels * (SHAPE + COLOR + PAGE) + f->deforming_voxels * BINDING + f->layer_bytes / 8;
}

/* Page voxels in, for chains and for cells; chains out and in; masks of both layers' leaf parents in; cells,
 * masks of all levels (a seventh of the leaves') and children out. */
static uint64_t build_bytes(const rig_figures *f)
{
    uint64_t bytes = f->dynamic_voxels * (2 * PAGE + 2 * CHAINS) + f->cells * CELL + f->layer_bytes / 4 +
                     f->layer_bytes / 7;
    for (uint32_t l = 0; l < f->levels; l++)
        bytes += f->nodes[l] * CHILDREN;
    return bytes;
}

/* Leaves and nodes in once, each level's nodes out. */
static uint64_t filter_bytes(const rig_figures *f)
{
    uint64_t bytes = f->levels ? f->nodes[f->levels - 1] * 8 * LEAF + f->nodes[0] * DENSE_CELL : 0;
    for (uint32_t l = 1; l < f->levels; l++)
        bytes += f->nodes[l] * (2 * NODE) + f->nodes[l - 1] * CHILDREN;
    return bytes;
}

uint64_t traffic_of(const rig_figures *f, rig_stage stage)
{
    switch (stage) {
    case RIG_IO: return io_bytes(f);
    case RIG_TRANSFORM: return transform_bytes(f);
    case RIG_BUILD: return build_bytes(f);
    case RIG_FILTER: return filter_bytes(f);
    case RIG_STAGE_COUNT: break;
    }
    return 0;
}
