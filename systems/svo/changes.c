/* The change mask, for who asks for it: occupancy of the leaf cells against that of the frame before. */
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

/* What was occupied, then what is by what stands still. */
static void note_still(kd_gpu *gpu, const svo_state *state, const kd_svo *svo, size_t layer)
{
    uint32_t pass[4] = {svo->layer_words, svo_levels(svo) - 1, 0, 0};
    kd_gpu_copy_buffer(gpu, svo->changes, layer, svo->changes, 0, layer);
    kd_gpu_fill_buffer(gpu, svo->changes, layer, layer, 0);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 2, svo->changes);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_STILL_CELLS], (svo->node_capacity + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

void svo_note_changes(kd_gpu *gpu, const svo_state *state, kd_svo *svo, bool changed)
{
    size_t layer = (size_t)svo->layer_words * 4;
    uint32_t pass[4] = {svo->layer_words, svo->has_moving, 0, 0};
    if (!svo->wants_changes)
        return;
    if (!svo->changes.id) {
        svo->changes = kd_gpu_make_buffer(
            gpu, &(kd_gpu_buffer_desc){.size = 2 * layer, .zeroed = true, .name = "svo.changes"});
        changed = true;
    }
    if (!svo->changes.id) {
        kd_log(KD_LOG_WARNING, "octree: no memory for the change mask; nobody is told of changes");
        svo->wants_changes = false;
        return;
    }
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    if (!changed) {
        kd_gpu_fill_buffer(gpu, svo->changes, 0, layer, 0);
        return;
    }
    note_still(gpu, state, svo, layer);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_storage(gpu, 2, svo->changes);
    kd_gpu_bind_storage(gpu, 3, svo->moving);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_CHANGES], (svo->layer_words + 63) / 64);
}
