/* Build `orderfree`: cells set bits, ranks of bits are places, attributes add up in fixed point (dynamic.c,
 * still.c); levels of masks give the nodes (nodes.c). The same bytes whatever the order of threads, and what
 * did not change is kept. */
#include "systems/svo/internal.h"

void svo_build_orderfree(kd_gpu *gpu, svo_state *state, kd_svo *svo, const kd_voxel_scene *scene)
{
    if (scene->static_changed)
        svo_link_static(gpu, state, svo, scene);
    svo_build_dynamic(gpu, state, svo, scene);
    if (!svo_build_nodes(gpu, state, svo, scene))
        return;
    svo_say_dynamic(state, svo);
    svo_build_blocks(gpu, state, svo, scene);
    if (scene->static_changed)
        svo_build_static(gpu, state, svo, scene);
    svo_build_moving_cells(gpu, state, svo, scene);
}
