// Draws page voxels of the dynamic layer.
#define VOXELS 2
#include "shaders/debug_view/voxels.glsl"
