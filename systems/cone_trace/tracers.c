#include "systems/cone_trace/tracers.h"

bool tracers_fit(kd_gpu *gpu, gather_tracers *tracers, const kd_tree *tree, const kd_settings *settings,
                 bool lists, bool counts)
{
    static const char *const paths[TRACE_COUNT][2] = {
        {"shaders/cone_trace/gather.comp", "shaders/cone_trace/gather_counted.comp"},
        {"shaders/cone_trace/gather_list.comp", "shaders/cone_trace/gather_list_counted.comp"},
        {"shaders/cone_trace/gather_list_glossy.comp", "shaders/cone_trace/gather_list_glossy_counted.comp"}};
    static const char *const variants[] = {[KD_CONES_TRILINEAR] = NULL,
                                           [KD_CONES_QUADRILINEAR] = "KD_CONES_QUADRILINEAR",
                                           [KD_CONES_PAPER] = "KD_CONES_PAPER"};
    const bool needed[TRACE_COUNT] = {!lists, lists, lists && settings->specular_cones};
    const char *variant = variants[settings->cones_interpolation];
    bool fit = tree->radiance.id != 0;
    for (int i = 0; i < TRACE_COUNT && fit; i++)
        if (needed[i])
            fit = kd_tree_fit_variant(gpu, tree, paths[i][counts], variant, &tracers->programs[i][counts]);
    return fit;
}

void tracers_destroy(kd_gpu *gpu, gather_tracers *tracers)
{
    for (int i = 0; i < TRACE_COUNT; i++)
        for (int counts = 0; counts < 2; counts++)
            kd_gpu_destroy_program(gpu, tracers->programs[i][counts].program);
}
