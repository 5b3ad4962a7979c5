// Material maps read outside the rasteriser: the level comes from the caller, since there are no derivatives.
// The including pass binds the maps at KD_UNIT_* and the block at KD_BIND_MATERIAL.

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"

layout(std140, binding = KD_BIND_MATERIAL) uniform material_block { kd_material_params material; };
layout(binding = KD_UNIT_BASE_COLOR) uniform sampler2D base_color_map;
layout(binding = KD_UNIT_EMISSIVE) uniform sampler2D emissive_map;

vec2 map_uv(uint map_index, vec2 uv0, vec2 uv1)
{
    vec3 uv = vec3((material.maps.y >> map_index & 1u) != 0u ? uv1 : uv0, 1.0);
    return vec2(dot(material.uv_transform[2u * map_index].xyz, uv), dot(material.uv_transform[2u * map_index + 1u].xyz, uv));
}
