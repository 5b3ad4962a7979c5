#include "shaders/shared/bindings.h"
#include "shaders/shared/emitters.h"

layout(std140, binding = KD_BIND_EMITTERS) uniform emitters_block { kd_emitters_params emitters; };
