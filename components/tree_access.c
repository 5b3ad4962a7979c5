#include "components/tree_access.h"

#include <stdio.h>

#include "shaders/shared/bindings.h"
#include "shaders/shared/voxel.h"

uint32_t kd_tree_sparse_levels(const kd_tree *tree)
{
    uint32_t levels = 0;
    while (tree->dense_resolution << levels < tree->resolution)
        levels++;
    return levels;
}

bool kd_tree_fit_variant(kd_gpu *gpu, const kd_tree *tree, const char *path, const char *variant,
                         kd_tree_program *program)
{
    uint32_t levels = kd_tree_sparse_levels(tree);
    if (program->sparse_levels == levels && program->strict == tree->strict && program->variant == variant)
        return program->program.id != 0;
    char define[32];
    snprintf(define, sizeof define, "KD_SPARSE_LEVELS %u", levels);
    const char *defines[4] = {define}; /* NULL ends them */
    uint32_t count = 1;
    if (tree->strict)
        defines[count++] = "KD_LEAK_STRICT 1";
    if (variant)
        defines[count] = variant;
    kd_gpu_destroy_program(gpu, program->program);
    program->program = kd_gpu_make_program(gpu, &(kd_gpu_program_desc){.compute = path, .defines = defines});
    program->sparse_levels = levels;
    program->strict = tree->strict;
    program->variant = variant;
    return program->program.id != 0;
}

bool kd_tree_fit_program(kd_gpu *gpu, const kd_tree *tree, const char *path, kd_tree_program *program)
{
    return kd_tree_fit_variant(gpu, tree, path, NULL, program);
}

void kd_tree_bind(kd_gpu *gpu, const kd_tree *tree)
{
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_TREE, tree->uniform, 0, sizeof(struct kd_tree_params));
    kd_gpu_bind_texture(gpu, KD_UNIT_TREE_RADIANCE, tree->radiance);
    kd_gpu_bind_texture(gpu, KD_UNIT_TREE_DEPTH, tree->depth);
    kd_gpu_bind_texture(gpu, KD_UNIT_TREE_INDEX, tree->index);
    kd_gpu_bind_texture(gpu, KD_UNIT_TREE_NODES, tree->nodes);
    kd_gpu_bind_texture(gpu, KD_UNIT_TREE_LEAVES, tree->leaves);
    kd_gpu_bind_texture(gpu, KD_UNIT_TREE_DATA, tree->data);
}

float kd_tree_cone_length(const kd_tree *tree, const kd_settings *settings)
{
    if (settings->cones_max_distance > 0)
        return settings->cones_max_distance;
    return tree->span_m[tree->cascade_count - 1] * (float)tree->resolution * 1.7320508f;
}
