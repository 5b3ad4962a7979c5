// Shows page voxels of the static layer.
#define VOXELS 1
#include "shaders/debug_view/voxel_show.glsl"
