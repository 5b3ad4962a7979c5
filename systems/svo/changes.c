/* Dense cells in which leaves came or went. Where two layers are kept the passes that give and take leaves
 * tell it (release_blocks, vanish and show_moving in shaders/svo/); with one layer, of which nothing is left
 * from the frame before, a sum over each dense cell's leaves is. */
#include "runtime/core/log.h"
#include "shaders/shared/bindings.h"
#include "systems/svo/internal.h"

void svo_tell_changes(kd_gpu *gpu, const svo_state *state, kd_svo *svo)
{
    uint32_t pass[4] = {svo_levels(svo) - 1, kd_svo_moving_room(svo), 0, 0};
    size_t words = (size_t)svo->cascades * KD_DENSE_WORDS, size = 2 * words * 32 * 4;
    if (!svo->told.id)
        svo->told =
            kd_gpu_make_buffer(gpu, &(kd_gpu_buffer_desc){.size = size, .zeroed = true, .name = "svo.told"});
    if (!svo->told.id) {
        kd_log(KD_LOG_WARNING, "octree: no memory to find what changed; nobody is told of it");
        svo->wants_changes = false;
        return;
    }
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
    kd_gpu_bind_uniform(gpu, 0, pass, sizeof pass);
    kd_gpu_bind_uniform(gpu, KD_BIND_SVO, &svo->places, sizeof svo->places);
    kd_gpu_bind_storage(gpu, 0, svo->counters);
    kd_gpu_bind_storage(gpu, 2, svo->moving);
    kd_gpu_bind_storage(gpu, 5, svo->dynamic_cells);
    kd_gpu_bind_storage(gpu, 6, svo->told);
    kd_gpu_bind_storage(gpu, 7, svo->book);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_TELL_LEAVES], (svo->node_capacity + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
    kd_gpu_dispatch_linear(gpu, state->programs[SVO_TELL_CHANGES], (uint32_t)(words + 63) / 64);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE);
}

/* Where there is no memory for them all parents in which something moves count as changed. */
void svo_keep_moving(kd_gpu *gpu, kd_svo *svo)
{
    uint32_t room = kd_svo_moving_room(svo);
    size_t bytes = (size_t)room * 4;
    svo->moved_room = 0;
    if (!bytes || kd_gpu_ensure_buffer(gpu, &svo->moved_cells, bytes, 0, "svo.moving") != KD_OK)
        return;
    svo->moved_room = room;
    kd_gpu_copy_buffer(gpu, svo->dynamic_cells, kd_svo_moving_words(svo), svo->moved_cells, 0, bytes);
    kd_gpu_barrier(gpu, KD_BARRIER_STORAGE | KD_BARRIER_BUFFER_UPDATE);
}
