// Draws cached voxels, posed at their objects.
#define VOXELS 0
#include "shaders/debug_view/voxels.glsl"
