/* The change mask, for who asks for it: occupancy of the leaf cells against that of the frame before. */
#include "systems/svo/internal.h"

void svo_note_changes(kd_gpu *gpu, svo_state *state, kd_svo *svo, bool changed)
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
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_TEXTURE | KD_BARRIER_BUFFER_UPDATE);
    if (!changed) {
        kd_gpu_fill_buffer(gpu, svo->changes, 0, layer, 0);
        return;
    }
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_texel_view_bind(gpu, &state->moving_view, 0, svo->has_moving ? svo->moving : svo->masks, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &state->still_view, 1, svo->masks, KD_RGBA32UI);
    kd_texel_view_bind(gpu, &state->changes_view, 2, svo->changes, KD_RGBA32UI);
    kd_gpu_bind_storage(gpu, 2, svo->changes);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_CHANGES], (svo->layer_words / 4 + 63) / 64);
}
