#ifndef KD_COMPONENTS_TREE_ACCESS_H
#define KD_COMPONENTS_TREE_ACCESS_H

#include "components/render_targets.h"
#include "runtime/core/settings.h"

/* A program that samples the octree (shaders/include/tree.glsl): compiled for a number of sparse levels, so
 * that its descents have a fixed length. */
typedef struct kd_tree_program {
    kd_gpu_program program;
    uint32_t sparse_levels; /* 0: not compiled yet */
    bool strict;            /* KD_LEAK_STRICT: no light through thin walls */
    const char *variant;    /* NULL, or the define that it was compiled with */
} kd_tree_program;

/** Count the sparse levels, KD_SPARSE_LEVELS of shaders that sample the tree. */
uint32_t kd_tree_sparse_levels(const kd_tree *tree);

/** Compile `path` for the tree as it is now, unless that is done. Returns false when the program failed.
 * Threading: GPU lane */
bool kd_tree_fit_program(kd_gpu *gpu, const kd_tree *tree, const char *path, kd_tree_program *program);

/** The same with another define besides, a literal or NULL. Threading: GPU lane */
bool kd_tree_fit_variant(kd_gpu *gpu, const kd_tree *tree, const char *path, const char *variant,
                         kd_tree_program *program);

/** Bind the tree's uniform block and textures to KD_BIND_TREE and KD_UNIT_TREE_*. Threading: GPU lane */
void kd_tree_bind(kd_gpu *gpu, const kd_tree *tree);

/** Largest distance [m] that cones go: `cones.max_distance`, or the diagonal of the outermost cascade. */
float kd_tree_cone_length(const kd_tree *tree, const kd_settings *settings);

#endif
