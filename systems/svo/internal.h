#ifndef KD_SYSTEMS_SVO_INTERNAL_H
#define KD_SYSTEMS_SVO_INTERNAL_H

#include "components/pose_access.h"
#include "components/render_targets.h"
#include "components/rigid_access.h"
#include "components/svo.h"
#include "components/voxel_scene.h"
#include "runtime/core/log.h"
#include "runtime/ecs/system.h"
#include "runtime/gpu/rank.h"

typedef enum svo_program {
    SVO_LINK_LIST,
    SVO_LINK,
    SVO_CELLS,
    SVO_LINK_STATIC,
    SVO_CELLS_STATIC,
    SVO_MERGE,
    SVO_MERGE_STALE,
    SVO_REDUCE,
    SVO_DIFF,
    SVO_VANISH,
    SVO_COME,
    SVO_SETTLE,
    SVO_EMPTY,
    SVO_TOUCHED,
    SVO_RELEASE_BLOCKS,
    SVO_TAKE_BLOCKS,
    SVO_SETTLE_BLOCKS,
    SVO_SHOW_BLOCKS,
    SVO_SHOW_MOVING,
    SVO_GATHER_BLOCKS,
    SVO_ARGS,
    SVO_FILTER_SPARSE,
    SVO_DENSE_LIST,
    SVO_NODE_LIST,
    SVO_FILTER_DENSE,
    SVO_FILTER_UP,
    SVO_ABOVE_LIST,
    SVO_TELL_LEAVES,
    SVO_TELL_CHANGES,
    SVO_RENUMBER,
    SVO_MOVE,
    SVO_WAKE,
    SVO_FILTER_ABOVE,
    SVO_CENSUS,
    SVO_CENSUS_KEPT,
    SVO_CENSUS_FRESH,
    SVO_TAKEN, /* from here on: builds in which nodes take numbers, compiled when one is chosen */
    SVO_TAKEN_ADD = SVO_TAKEN,
    SVO_TAKEN_MARK,
    SVO_TAKEN_LEVEL,
    SVO_TAKEN_LIST,
    SVO_TAKEN_SETTLE,
    SVO_TAKEN_BLOCKS,
    SVO_TAKEN_PACK,
    SVO_PROGRAM_COUNT
} svo_program;

/* Messages that are written once. */
enum {
    SVO_SAID_SUMS = 1,
    SVO_SAID_DYNAMIC = 2,
    SVO_SAID_NODES = 4,
    SVO_SAID_TAKEN = 8,
    SVO_SAID_MOVING = 16,
    SVO_SAID_GLOW = 32,
    SVO_SAID_CHAINS = 64,
    SVO_SAID_LEAVES = 128,
    SVO_SAID_SHORT = 256,
    SVO_SAID_LEAST = 512,
    SVO_SAID_WORK = 1024
};
#define SVO_NO_MEMORY "octree: no memory to change its nodes; they stay as they are; raise voxels.span"
#define svo_say_once(state, what, ...)                                                                       \
    do {                                                                                                     \
        if (!((state)->said & (uint32_t)(what)))                                                             \
            kd_log(KD_LOG_WARNING, __VA_ARGS__);                                                             \
        (state)->said |= (uint32_t)(what);                                                                   \
    } while (0)

/* Nodes get an eighth more room than they ask for, so that a moving camera seldom asks again. */
enum { SVO_SPARE = 8 };

/* How much of a buffer that grows is wanted, and for how many runs that has been less than half of it. */
typedef struct svo_room {
    uint32_t wanted, quiet;
} svo_room;

/* Shared by the systems of this folder: programs and what is known of the counts. */
typedef struct svo_state {
    kd_gpu_program programs[SVO_PROGRAM_COUNT];
    kd_gpu_rank rank;
    kd_gpu_readback readback; /* counters of the frames before, without a stall */
    uint32_t texel_viewed[4]; /* buffers behind kd_tree's texel views */
    kd_texel_view page_view, next_view, object_view, moving_view, still_view, moved_view;
    kd_rigid_access rigid; /* of static voxels, and what else chains of them read */
    kd_texel_view shape_view, color_view, stale_view, entry_view, glow_view;
    kd_texel_view segment_view;
    uint32_t linked_slots; /* segments of what moves whose voxels are chained */
    bool short_of_slots;   /* these are not all */
    uint32_t linked;       /* stale patches in the first round of chains */
    uint32_t marked;       /* first stale patch of those whose cells are marked in kd_svo.fresh */
    bool dynamic_before;   /* there were dynamic voxels in the frame before */
    uint32_t said;         /* SVO_SAID_*: messages that were written */
    svo_room nodes, sums, fresh, entries, dynamic,
        leaves; /* nodes: leaf parents; leaves: of what stands still */
    uint32_t nodes_wanted[KD_MAX_NODE_LEVELS];
    uint32_t moving_parents; /* leaf parents with dynamic cells when their room was settled */
    uint32_t still_runs;     /* for which nothing has moved */
    uint64_t allowed;        /* bytes of an array, by svo.memory and the driver */
    uint32_t asks;           /* how often it is to be asked yet whether levels may come back */
    uint32_t asked;          /* runs since a level that was given up was asked for */
    double finer[KD_MAX_NODE_LEVELS]
                [KD_MAX_CASCADES]; /* children of a node when its children were given up */
    uint32_t same_runs;            /* for which the tree has stayed as it is */
    uint64_t nodes_asked;          /* of any one level, when they were counted last */
    uint64_t bytes_build;
} svo_state;

/** Make what does not depend on counts: masks, ranks, atlas, uniform. Errors KD_GPU, KD_NO_MEMORY */
kd_status svo_make(kd_gpu *gpu, kd_svo *svo, const kd_voxel_scene *scene);
void svo_destroy(kd_gpu *gpu, kd_svo *svo);

/** Make room for so many nodes of each level; nodes, and what is known of them, stay. Errors KD_GPU,
 * KD_NO_MEMORY */
kd_status svo_reserve_nodes(kd_gpu *gpu, kd_svo *svo, const uint32_t *wanted);

/** Rows of a table of the nodes of levels `first` … end - 1; at least one, since no buffer is empty. */
static inline size_t svo_rows(const uint32_t *room, uint32_t first, uint32_t end)
{
    size_t rows = 0;
    for (uint32_t l = first; l < end; l++)
        rows += room[l];
    return rows ? rows : 1;
}

/** Make room for the sums of so many cells. */
kd_status svo_reserve_sums(kd_gpu *gpu, kd_svo *svo, uint32_t cells);

/** Make room for the cells of so many leaf parents of the dynamic layer, and for their chains' heads, which
 * are empty then; and for the chains of so many page voxels; chains of a crowd that has
 * gone give their room back. */
kd_status svo_reserve_dynamic(kd_gpu *gpu, kd_svo *svo, uint32_t parents);
kd_status svo_reserve_chains(kd_gpu *gpu, kd_svo *svo, uint64_t voxels);
#define SVO_PARENT_CELL_BYTES (8u * 16u + 4u) /* and which of the eight there are */
#define SVO_CHAIN_BYTES       (8u * 4u)       /* of a voxel: it may lie in eight parents */

/** Make room for the masks of the frame before; for so many words of lists of work, and what was listed is
 * lost. Errors KD_GPU, KD_NO_MEMORY */
kd_status svo_reserve_before(kd_gpu *gpu, kd_svo *svo);
kd_status svo_reserve_work(kd_gpu *gpu, kd_svo *svo, uint64_t words);

/** Make room for bits and ranks of the dynamic layer's cells, or give it back. Errors KD_GPU, KD_NO_MEMORY:
 * as it was */
kd_status svo_reserve_moving(kd_gpu *gpu, kd_svo *svo, bool wanted);

/** Make room for what static cells emit, or give it back; none emits anything then. Errors KD_GPU,
 * KD_NO_MEMORY: as it was */
kd_status svo_reserve_emission(kd_gpu *gpu, kd_svo *svo, bool wanted);

/** Make room for the masks of so many words of stale patches, or as many as fit one array, and for their
 * chains; for so many entries of these. */
kd_status svo_reserve_fresh(kd_gpu *gpu, kd_svo *svo, uint64_t words);
kd_status svo_reserve_entries(kd_gpu *gpu, kd_svo *svo, uint32_t entries);

/** Make anew what was given back while nothing changed. Errors KD_GPU: as it was */
kd_status svo_wake(kd_gpu *gpu, const svo_state *state, kd_svo *svo);

/** Give back what has been more than half spare for a while (give_back.c). Before the frame's lists begin. */
void svo_give_back(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);

/** Cut the room of what moves; nobody needs what is in it before the next build. */
void svo_cut_dynamic(kd_gpu *gpu, kd_svo *svo, const svo_room *room);

/** Places of everything that depends on the number of nodes; returns the size of the book in words. */
/** Size of the node table with so much room. */
size_t svo_node_bytes(const kd_svo *svo, const uint32_t *room);

uint32_t svo_place_nodes(const kd_svo *svo, struct kd_svo_places *places, const uint32_t *room);
size_t svo_fixed_book_bytes(const kd_svo *svo);

/** Write the uniform block for where the cascades stand now. */
void svo_write_params(kd_gpu *gpu, const kd_svo *svo, const kd_voxel_scene *scene);

/** Follow a buffer with a texel view. */
void svo_view(kd_gpu *gpu, uint32_t *viewed, kd_gpu_texture *texture, kd_gpu_buffer buffer,
              kd_texture_format format);

/** Hand what the tracer reads to kd_tree. */
void svo_publish(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                 kd_tree *tree);

static inline size_t svo_emission_bytes(const kd_svo *svo, uint32_t leaves)
{
    return svo->glows ? (size_t)leaves * 8 : 4;
}

static inline uint32_t svo_levels(const kd_svo *svo)
{
    return svo->leaf_level - KD_DENSE_LOG2;
}

/** Share of an array of so many bytes that the tables of so many nodes a level take, of the fullest one. */
double svo_table_share(const kd_svo *svo, const double nodes[KD_MAX_NODE_LEVELS], uint64_t bytes);

/** Room for nodes of each level between `least` and `want`, as many as the tables may hold; less where even
 * the least do not fit. */
void svo_fit_tables(const kd_svo *svo, const double *least, const double *want, uint32_t *room);

/** Slots of leaves: these are the largest of the tables, and a block's word has 24 bits for the first of
 * them.
 */
static inline uint32_t svo_most_slots(uint64_t bytes)
{
    return (uint32_t)(bytes / 8 < KD_BLOCK_FIRST ? bytes / 8 : KD_BLOCK_FIRST);
}

/** Voxels of a layer's pages as what may lie in one cell each: things smaller than a cell, a segment each,
 * may lie across the corner of eight. */
static inline uint64_t svo_spread_voxels(const kd_voxel_pages *pages)
{
    return pages->voxel_count + 7ull * pages->segment_count;
}

/** Room for a layer's leaf parents, kept until its members change. Surfaces share a fifth of a parent a voxel
 * in any pose, wires up to two, and what is counted now may lie on the lattice: twice the count covers that.
 */
static inline uint32_t svo_parents_in_any_pose(uint64_t bytes, uint32_t counted, uint64_t voxels)
{
    uint64_t most = bytes / SVO_PARENT_CELL_BYTES;
    if (most > KD_BLOCK_FIRST / 16) /* eight leaves each, in half of the slots that a block's word can name */
        most = KD_BLOCK_FIRST / 16;
    uint64_t want = (voxels > (uint64_t)counted * 2 ? voxels : (uint64_t)counted * 2) + 1024;
    return (uint32_t)(want < most ? want : most) / 4 * 4; /* four of their words stand in a row */
}

/** Write indirect arguments: groups of 64 over `factor` times a counter. */
void svo_args(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, uint32_t counter, uint32_t most,
              uint32_t factor, uint32_t args);

/** Read a counter; waits. */
uint32_t svo_read_counter(kd_gpu *gpu, const kd_svo *svo, uint32_t counter);

/* Ways of making the tree from the voxels of a frame; svo.build picks one. Each leaves the same tables for
 * the light, the filter and the cones; numbers of nodes may differ. The book is as svo_begin_nodes left it.
 */
typedef void svo_build(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);
svo_build svo_build_orderfree, svo_build_atomic, svo_build_levels;

/** Take all nodes off the masks and the tables; all numbers are free. */
void svo_empty_nodes(kd_gpu *gpu, const svo_state *state, const kd_svo *svo);

/* build_taken.c: what the builds share in which nodes take numbers from counters. `fill` makes nodes and adds
 * attributes to the sums of cells. */
void svo_build_taken(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                     svo_build *fill);
void svo_bind_taken(kd_gpu *gpu, const kd_svo *svo, const kd_voxel_scene *scene);
void svo_add_taken(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene);

/* dynamic.c, still.c: cells of each layer; voxels are chained before there are nodes, cells made after */
void svo_say_dynamic(svo_state *state, const kd_svo *svo); /* when cells of what moves find no room */
void svo_build_dynamic(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);
void svo_build_moving_cells(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);
void svo_link_static(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);

/* Stale patches whose cells are marked in kd_svo.fresh at once. svo_next_marks() goes to the next, from {0}
 * on, and marks them if others are marked; false: these were the last. */
typedef struct svo_marks {
    uint32_t first, count;
} svo_marks;
bool svo_next_marks(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                    svo_marks *marks);
void svo_build_static(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);

/* blocks.c: places of leaves */

/** Make room for static leaves, for those of what moves behind them, or for both; leaves stay, `_reserve_`
 * forgets them; `_gather_` moves all blocks together. Errors KD_GPU: as it was */
kd_status svo_reserve_leaves(kd_gpu *gpu, kd_svo *svo, uint64_t leaves);
kd_status svo_fit_leaves(kd_gpu *gpu, kd_svo *svo);
kd_status svo_gather_blocks(kd_gpu *gpu, const svo_state *state, kd_svo *svo, uint32_t room);
/** Blocks for static cells that come anew, and what leads to the leaves of all touched parents. */
void svo_build_blocks(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);

/* nodes.c: levels above the cells */
void svo_begin_nodes(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);
/** false: there was not room, and the tree is to be made again (kd_svo.again). */
bool svo_build_nodes(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene);

/* shortage.c: levels that are given up where there is not room for all. */

/** Begin a run: follow svo.memory (MiB; 0: what the driver binds). */
void svo_allow(kd_gpu *gpu, svo_state *state, kd_svo *svo, int64_t mebibytes);

/** Is it time to ask whether levels may come back, or have to go? */
bool svo_asks_for_room(const svo_state *state);

/** Decide what the cascades give up; masks of this frame are made, nodes not yet. counted: nodes by level.
 * false: it has changed, and everything is to be made again */
bool svo_has_room(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                  const uint32_t *counted);

/* changes.c: with one layer, where leaves came or went; what of the moving ones the next frame is to know */
void svo_tell_changes(kd_gpu *gpu, const svo_state *state, kd_svo *svo);
void svo_keep_moving(kd_gpu *gpu, kd_svo *svo);

/* filter.c: shaders/svo/filter_*.comp; room for its lists is made before */
void svo_reserve_filter(kd_gpu *gpu, svo_state *state, kd_svo *svo);
void svo_filter(kd_gpu *gpu, const svo_state *state, const kd_svo *svo);

#endif
