/* Where nodes, leaves or the cells of what moves would not fit (svo.memory, or what the driver binds),
 * cascades give levels up: first the outermost its finest, then the next inward, and so on, then the next
 * level of all. What lies in one cell of the level above is then added up in one cell
 * (shaders/include/tree_params.glsl): cascades keep their reach, and there are no holes.
 *
 * Who gives up what is decided from the masks, before anything is written, so it depends on the scene alone.
 * A level that has gone is missed by its parents, which are counted exactly; how many it had is known by what
 * they were when it went. When it changes, voxels are marked and the tree is made once more in the same frame
 * (phases voxel_again and svo_again). */
#include "runtime/core/log.h"
#include "runtime/core/settings.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

/* Levels come back when they are thought to leave an eighth of the room free. That is asked when something
 * changes, and after so many frames a few times more, since room that is spare is given back late. */
enum { MARGIN = 8, ASK_AGAIN = 64, ASKS = 3 };
#define LIKELY 5.0 /* children of a node, where nothing is known */

/* What the masks ask for, by cascade: nodes `k` levels above the leaf parents, and static cells. */
typedef struct demand {
    double nodes[KD_MAX_NODE_LEVELS][KD_MAX_CASCADES], moving[KD_MAX_NODE_LEVELS][KD_MAX_CASCADES];
    double cells[KD_MAX_CASCADES], voxels; /* voxels: of what moves */
} demand;

/* ---- counting ---- */

static void count_masks(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, kd_gpu_buffer masks,
                        uint32_t first, uint32_t counter)
{
    uint32_t words = kd_svo_parent_words(svo), pass[4] = {words, first, words / svo->cascades, counter};
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, masks);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_CENSUS], (words / 16 + 63) / 64);
}

static void bind_cells(kd_gpu *gpu, const kd_svo *svo, const kd_voxel_scene *scene, const uint32_t pass[4])
{
    kd_gpu_bind_uniform(gpu, 0, pass, 16);
    kd_gpu_bind_uniform(gpu, 1, &scene->stale_places, sizeof scene->stale_places);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 1, svo->fresh);
    kd_gpu_bind_storage(gpu, 5, scene->stale);
    kd_gpu_bind_storage(gpu, 7, svo->book);
}

static void count_cells(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    uint32_t kept[4] = {svo_levels(svo) - 1, scene->static_changed, 0, 0};
    svo_marks marks = {0, 0};
    bind_cells(gpu, svo, scene, kept);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_CENSUS_KEPT], (svo->node_capacity + 63) / 64);
    while (scene->static_changed && svo_next_marks(gpu, state, svo, scene, &marks)) {
        uint32_t fresh[4] = {marks.count, kd_svo_parent_words(svo) / svo->cascades, marks.first, 0};
        bind_cells(gpu, svo, scene, fresh);
        kd_gpu_dispatch_linear(gpu, state->programs[SVO_CENSUS_FRESH], (marks.count + 63) / 64);
    }
}

static void count(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene, demand *d)
{
    uint32_t counts[KD_COUNT_WORDS - KD_COUNT_CENSUS], top = svo_levels(svo) - 1;
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_fill_buffer(gpu, svo->counters, KD_COUNT_CENSUS * 4, sizeof counts, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    count_masks(gpu, state, svo, svo->level_masks, svo->mask_first[top], KD_COUNT_CENSUS);
    if (svo->has_moving)
        count_masks(gpu, state, svo, svo->moving, 0, KD_COUNT_CENSUS_MOVING);
    count_cells(gpu, state, svo, scene);
    kd_gpu_barrier(gpu, KD_BARRIER_BUFFER_UPDATE | KD_BARRIER_STORAGE);
    kd_gpu_read_buffer(gpu, svo->counters, KD_COUNT_CENSUS * 4, counts, sizeof counts);
    d->voxels = (double)scene->pages[KD_LAYER_DYNAMIC].voxel_count;
    for (uint32_t c = 0; c < svo->cascades; c++) {
        d->cells[c] = counts[KD_COUNT_CENSUS_CELLS - KD_COUNT_CENSUS + c];
        for (uint32_t k = 0; k <= top; k++) {
            d->nodes[k][c] = counts[4 * k + c];
            d->moving[k][c] = counts[KD_COUNT_CENSUS_MOVING - KD_COUNT_CENSUS + 4 * k + c];
        }
    }
}

/* ---- what fits ---- */

/* Leaf parents of a cascade are as many as nodes so far above them when it has given up `levels`. */
static uint32_t above(uint32_t levels)
{
    return levels > 0 ? levels - 1 : 0;
}

typedef enum lack { NOTHING, LEAVES, PARENTS } lack;

/* What there is not room for, of all but one `spare`th of what `most` bytes an array hold. spare 0: of all */
static lack lacks(const kd_svo *svo, const demand *d, uint32_t given_up, uint64_t most, uint32_t spare)
{
    double share = spare ? 1 - 1.0 / spare : 1, leaves = 0, moving = 0, nodes[KD_MAX_NODE_LEVELS] = {0};
    uint32_t levels = svo_levels(svo);
    for (uint32_t k = 0; k < levels; k++)
        for (uint32_t c = 0; c < svo->cascades; c++) {
            uint32_t at = above(kd_svo_given_up(given_up, c));
            at = at > k ? at : k;
            nodes[levels - 1 - k] += d->nodes[at][c] + d->moving[at][c] / 4; /* another pose may need more */
        }
    if (svo_table_share(svo, nodes, most) > share)
        return PARENTS;
    for (uint32_t c = 0; c < svo->cascades; c++) {
        uint32_t gone = kd_svo_given_up(given_up, c);
        double parents = d->nodes[above(gone)][c], cells = d->cells[c];
        leaves += kd_svo_wide_blocks(svo) ? 8 * parents : gone > 0 && parents < cells ? parents : cells;
        moving += d->moving[above(gone)][c];
    }
    uint32_t room = moving > 0 ? svo_parents_in_any_pose(most, (uint32_t)moving, (uint64_t)d->voxels) : 0;
    if (moving > share * room)
        return PARENTS;
    return leaves + 8.0 * room > share * svo_most_slots(most) ? LEAVES : NOTHING;
}

/* ---- levels that have gone ---- */

/* One level more: of the cascades that gave up least the outermost. Leaf parents become fewer with the second
 * level. Returns the same when there is no more. */
static uint32_t one_more(const kd_svo *svo, uint32_t given_up, lack what)
{
    uint32_t least = 0, levels = svo_levels(svo);
    for (uint32_t c = 1; c < svo->cascades; c++)
        if (kd_svo_given_up(given_up, c) <= kd_svo_given_up(given_up, least))
            least = c;
    uint32_t gone = kd_svo_given_up(given_up, least), step = gone == 0 && what == PARENTS ? 2 : 1;
    if (levels == 1 || gone == levels) /* leaves right below dense cells stay */
        return given_up;
    return given_up + (step << (4 * least));
}

/* The innermost cascade of those that gave up most. */
static uint32_t first_back(const kd_svo *svo, uint32_t given_up)
{
    uint32_t most = 0;
    for (uint32_t c = 1; c < svo->cascades; c++)
        if (kd_svo_given_up(given_up, c) > kd_svo_given_up(given_up, most))
            most = c;
    return most;
}

/* Keep how many times finer cells are more, of levels that are there. */
static void learn(svo_state *state, const kd_svo *svo, const demand *d)
{
    uint32_t levels = svo_levels(svo) < KD_MAX_NODE_LEVELS ? svo_levels(svo) : KD_MAX_NODE_LEVELS;
    for (uint32_t c = 0; c < svo->cascades; c++)
        for (uint32_t n = kd_svo_given_up(svo->given_up, c); n < levels; n++) {
            double fine = n > 0 ? d->nodes[n - 1][c] : d->cells[c], coarse = d->nodes[n][c];
            state->finer[n][c] = coarse > 0 ? fine / coarse : 0;
        }
}

/* The demand if cascade c had back the last of `gone` levels. */
static void guess(const svo_state *state, uint32_t c, uint32_t gone, demand *d)
{
    double more = state->finer[gone - 1][c] > 0 ? state->finer[gone - 1][c] : LIKELY;
    if (gone > 1) {
        d->nodes[gone - 2][c] = more * d->nodes[gone - 1][c];
        d->moving[gone - 2][c] = more * d->moving[gone - 1][c];
        d->cells[c] = d->nodes[gone - 2][c];
    } else {
        d->cells[c] = more * d->nodes[0][c];
    }
}

static uint32_t levels_back(const svo_state *state, const kd_svo *svo, const demand *now, uint64_t most)
{
    uint32_t given_up = svo->given_up;
    demand d = *now;
    while (given_up > 0) {
        uint32_t c = first_back(svo, given_up), less = given_up - (1u << (4 * c));
        guess(state, c, kd_svo_given_up(given_up, c), &d);
        if (lacks(svo, &d, less, most, MARGIN))
            break;
        given_up = less;
    }
    return given_up;
}

/* More memory than was allowed is taken only where the coarsest tree needs it. */
static uint32_t levels_to_give(const kd_svo *svo, const demand *d, uint64_t driver, uint64_t *most)
{
    for (;; *most = *most * 2 < driver ? *most * 2 : driver) {
        uint32_t given_up = svo->given_up, more = given_up;
        lack what = lacks(svo, d, given_up, *most, 0);
        for (; what && (more = one_more(svo, given_up, what)) != given_up; given_up = more)
            what = lacks(svo, d, more, *most, 0);
        if (!what || *most >= driver)
            return given_up;
    }
}

/* ---- telling ---- */

static void say(svo_state *state, const kd_svo *svo, const demand *d, uint64_t allowed, uint64_t driver)
{
    uint64_t enough = allowed;
    while (enough < driver && lacks(svo, d, 0, enough, 0))
        enough += 1 << 20;
    char raise[48] = "voxels.span";
    if (allowed < driver && !lacks(svo, d, 0, enough, 0))
        snprintf(raise, sizeof raise, "svo.memory to %u or voxels.span", (uint32_t)(enough >> 20));
    uint32_t times = 1u << kd_svo_given_up(svo->given_up, first_back(svo, svo->given_up));
    if (svo->given_up)
        svo_say_once(state, SVO_SAID_SHORT,
                     "octree: %u MiB an array are not enough; voxels are up to %u times as large, "
                     "those of the outermost cascade first; raise %s",
                     (uint32_t)(allowed >> 20), times, raise);
    if (svo->most_bytes > allowed)
        svo_say_once(state, SVO_SAID_LEAST, "octree: %u MiB an array are taken: svo.memory=%u is too little",
                     (uint32_t)(svo->most_bytes >> 20), (uint32_t)(allowed >> 20));
}

/* ---- deciding ---- */

void svo_allow(kd_gpu *gpu, svo_state *state, kd_svo *svo, int64_t mebibytes)
{
    uint64_t driver = (uint64_t)kd_gpu_get_info(gpu)->max_ssbo_bytes, set = (uint64_t)mebibytes << 20;
    uint64_t allowed = set && set < driver ? set : driver;
    state->asked += svo->given_up > 0 && state->asks > 0;
    if (allowed == state->allowed)
        return;
    state->asked = state->allowed ? ASK_AGAIN : 0;
    state->allowed = svo->most_bytes = allowed;
}

bool svo_asks_for_room(const svo_state *state)
{
    return state->asked >= ASK_AGAIN;
}

/* Everything as if it were made for the first time. */
static bool start_again(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    if (svo_reserve_fresh(gpu, svo, svo->layer_words) != KD_OK)
        return false;
    state->fresh.wanted = svo->fresh_words;
    state->dynamic.wanted = svo->dynamic_room = 0;
    svo_cut_dynamic(gpu, svo, &state->dynamic);
    svo->again = true;
    svo_write_params(gpu, svo, scene);
    return true;
}

bool svo_has_room(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene,
                  const uint32_t *counted)
{
    uint64_t driver = (uint64_t)kd_gpu_get_info(gpu)->max_ssbo_bytes, most = state->allowed;
    uint32_t before = svo->given_up;
    demand d = {0};
    double nodes = 0, all[KD_MAX_NODE_LEVELS] = {0};
    bool members = scene->static_changed || scene->pages[KD_LAYER_DYNAMIC].changed;
    state->asks = members ? ASKS : state->asks > 0 ? state->asks - 1 : 0;
    state->asked = 0;
    for (uint32_t l = 0; l < svo_levels(svo); l++) {
        all[l] = counted[l];
        nodes = counted[l] > nodes ? counted[l] : nodes;
    }
    bool moves = scene->pages[KD_LAYER_DYNAMIC].segment_count > 0;
    if (!before && svo_table_share(svo, all, most) * (moves ? 2 : 1) <= 1 &&
        8 * nodes * (moves ? 3 : 1) + 8192 <= svo_most_slots(most) && (!moves || nodes <= (double)most / 256))
        return true;
    count(gpu, state, svo, scene, &d);
    learn(state, svo, &d);
    svo->given_up = levels_to_give(svo, &d, driver, &most);
    if (svo->given_up == before && svo->given_up > 0 && !svo->again)
        svo->given_up = levels_back(state, svo, &d, state->allowed);
    bool changed = svo->given_up != before || most > svo->most_bytes;
    svo->most_bytes = most;
    if (svo->given_up >= before)
        say(state, svo, &d, state->allowed, driver);
    if (!changed)
        return true;
    if (svo->again) { /* not twice in a frame */
        state->asked = ASK_AGAIN;
        svo->given_up = before;
        return true;
    }
    if (start_again(gpu, state, svo, scene))
        return false;
    svo->given_up = before;
    return true;
}
