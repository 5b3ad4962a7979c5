// Shows page voxels of the dynamic layer.
#define VOXELS 2
#include "shaders/debug_view/voxel_show.glsl"
