/* Cells of the static layer: those of stale bricks come anew, and go beside their leaves, where they stay
 * while those do.
 *
 * The voxels that may lie in stale bricks are listed (voxel_transform). Before the nodes are made they are
 * chained to the leaf parents whose cells they cover and mark these cells; when there are nodes and blocks
 * for them, one invocation a parent adds up its chain. Nothing depends on the order of threads: attributes
 * are added up in integers. Where there is not room for all entries of chains, or for all marks, at once it
 * is done in rounds, each for a range of stale patches. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

enum { PATCH_PARENTS = 32, ENTRY_BYTES = 16 };

typedef struct stale_round {
    uint32_t first, count; /* stale patches */
    bool in_turn;          /* entries are taken in turn: those of the voxels listed do not fit */
} stale_round;

static void bind_pass(kd_gpu *gpu, const kd_voxel_scene *scene, const uint32_t *pass, size_t size)
{
    kd_gpu_bind_uniform(gpu, 0, pass, size);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
}

/* What is listed, to the parents of a round; cells of the patches in `marks` are marked. */
static void link_round(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                       stale_round r, svo_marks marks)
{
    uint32_t pass[8] = {r.first, r.count, svo->entry_room, r.in_turn, marks.first, marks.count};
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    if (r.count)
        kd_gpu_fill_buffer(gpu, svo->fresh_heads, 0, (size_t)r.count * PATCH_PARENTS * 4, KD_EMPTY);
    if (marks.count)
        kd_gpu_fill_buffer(gpu, svo->fresh, 0, (size_t)marks.count * 32, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    if (!scene->pages[KD_LAYER_STATIC].segment_count)
        return;
    bind_pass(gpu, scene, pass, sizeof pass);
    kd_rigid_access_bind(gpu, &state->rigid, scene);
    kd_texel_view_bind(gpu, &state->shape_view, KD_RIGID_VIEWS, scene->cache_shape, KD_RG32UI);
    kd_texel_view_bind(gpu, &state->color_view, KD_RIGID_VIEWS + 1, scene->cache_color, KD_R32UI);
    kd_texel_view_bind(gpu, &state->stale_view, KD_RIGID_VIEWS + 2, scene->stale, KD_R32UI);
    kd_gpu_bind_storage(gpu, 0, scene->stale);
    kd_gpu_bind_storage(gpu, 1, svo->fresh);
    kd_gpu_bind_storage(gpu, 2, svo->fresh_heads);
    kd_gpu_bind_storage(gpu, 3, svo->entries);
    kd_gpu_bind_storage(gpu, 4, svo->entry_glows);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_LINK_STATIC], scene->stale, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE | KD_BARRIER_BUFFER_UPDATE);
}

/* Groups listed, and entries that the chains of a round ask for; waits. */
typedef struct asked {
    uint32_t groups, entries;
} asked;

static asked read_asked(kd_gpu *gpu, const kd_voxel_scene *scene)
{
    asked a = {0, 0};
    _Static_assert(KD_STALE_ENTRIES == KD_STALE_COUNT + 1, "read together");
    if (scene->pages[KD_LAYER_STATIC].segment_count)
        kd_gpu_read_buffer(gpu, scene->stale, KD_STALE_COUNT * 4, &a, sizeof a);
    return a;
}

/* No entry is taken but those that the listed voxels have as their own. */
static void take_none(kd_gpu *gpu, const kd_voxel_scene *scene, uint32_t own)
{
    kd_gpu_fill_buffer(gpu, scene->stale, KD_STALE_ENTRIES * 4, 4, own);
}

/* Chain a round, with more room when it asks for it, or as a smaller round where there is none. */
static void link_all(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene, stale_round *r,
                     svo_marks marks)
{
    uint64_t most = svo->most_bytes / ENTRY_BYTES;
    for (;;) {
        link_round(gpu, state, svo, scene, *r, marks);
        asked a = read_asked(gpu, scene);
        uint32_t had = svo->entry_room, want = a.entries < most ? a.entries : (uint32_t)most;
        state->entries.wanted = want > state->entries.wanted ? want : state->entries.wanted;
        if (a.entries <= had)
            return;
        svo_reserve_entries(gpu, svo, want);
        if (svo->entry_room < a.entries) {
            if (r->in_turn && r->count == 1)
                break;
            r->count = r->in_turn ? (r->count + 1) / 2 : r->count;
            r->in_turn = true;
        }
        take_none(gpu, scene, r->in_turn ? 0 : a.groups * KD_GROUP_VOXELS);
    }
    svo_say_once(state, SVO_SAID_SUMS, "octree: no memory for the cells of static voxels; some are left out");
}

/* Patches whose chains may begin in one buffer. */
static uint32_t most_patches(const kd_svo *svo)
{
    return (uint32_t)(svo->most_bytes / (PATCH_PARENTS * 4));
}

/* Patches from the `first` on for whose marks there is room. */
static svo_marks marks_from(const kd_svo *svo, const kd_voxel_scene *scene, uint32_t first)
{
    uint32_t left = scene->stale_patch_count - first, room = svo->fresh_words / 8;
    return (svo_marks){first, left < room ? left : room};
}

bool svo_next_marks(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene, svo_marks *marks)
{
    uint32_t first = marks->first + marks->count;
    if (first >= scene->stale_patch_count)
        return false;
    *marks = marks_from(svo, scene, first);
    if (state->marked != first)
        link_round(gpu, state, svo, scene, (stale_round){0, 0, true}, *marks);
    state->marked = first;
    return true;
}

void svo_link_static(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t patches = scene->stale_patch_count, most = most_patches(svo);
    stale_round r = {0, patches < most ? patches : most, false};
    svo_reserve_entries(gpu, svo, svo->entry_room); /* objects of entries, if something glows now */
    link_all(gpu, state, svo, scene, &r, marks_from(svo, scene, 0));
    state->linked = r.count;
    state->marked = 0;
    state->bytes_build += (uint64_t)patches * (32 + PATCH_PARENTS * 4) + (uint64_t)state->entries.wanted * 64;
}

static void make_cells(kd_gpu *gpu, svo_state *state, const kd_svo *svo, const kd_voxel_scene *scene,
                       stale_round r)
{
    uint32_t pass[4] = {r.first, r.count, 0, svo_levels(svo) - 1};
    bind_pass(gpu, scene, pass, sizeof pass);
    kd_texel_view_bind(gpu, &state->entry_view, 0, svo->entries, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &state->glow_view, 1, svo->entry_glows, KD_R32UI);
    kd_texel_view_bind(gpu, &state->object_view, 2, scene->object_params, KD_RGBA32F);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->fresh_heads);
    kd_gpu_bind_storage(gpu, 2, svo->work);
    kd_gpu_bind_storage(gpu, 3, svo->static_albedo);
    kd_gpu_bind_storage(gpu, 4, svo->static_emission);
    kd_gpu_bind_storage(gpu, 5, scene->stale);
    kd_gpu_bind_storage(gpu, 6, svo->leaves);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch_indirect(gpu, state->programs[SVO_CELLS_STATIC], svo->counters, KD_ARGS_TOUCHED * 4);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* After the nodes: cells go beside leaves, which must have their places. The first round is chained already.
 */
void svo_build_static(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t patches = scene->stale_patch_count;
    stale_round r = {0, state->linked, true};
    if (!scene->pages[KD_LAYER_STATIC].segment_count)
        return;
    for (;;) {
        make_cells(gpu, state, svo, scene, r);
        r.first += r.count;
        if (r.first >= patches || !r.count)
            return;
        r.count = patches - r.first < r.count ? patches - r.first : r.count;
        take_none(gpu, scene, 0);
        link_all(gpu, state, svo, scene, &r, (svo_marks){0, 0});
    }
}
