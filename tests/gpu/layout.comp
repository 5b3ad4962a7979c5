/* Copies every member of the shared structs out, word by word, in the order that layout.c lists them. */

#include "shaders/shared/bindings.h"
#include "shaders/shared/scene.h"
#include "shaders/shared/resolve.h"

layout(local_size_x = 1) in;
layout(std140, binding = KD_BIND_PASS) uniform pass_block { kd_resolve_params resolve; };
layout(std140, binding = KD_BIND_VIEW) uniform view_block { kd_view_params view; };
layout(std140, binding = KD_BIND_LIGHTS) uniform lights_block { kd_lights_params lights; };
layout(std140, binding = KD_BIND_MATERIAL) uniform material_block { kd_material_params material; };
layout(std430, binding = 0) readonly buffer objects_block { kd_object objects[]; };
layout(std430, binding = 1) writeonly buffer out_block { uint words[]; };

uint next = 0u;

void put(uvec4 v)
{
    for (int i = 0; i < 4; i++)
        words[next++] = v[i];
}
void put(vec4 v) { put(floatBitsToUint(v)); }
void put(mat4 m)
{
    for (int i = 0; i < 4; i++)
        put(m[i]);
}

void put_object(uint i)
{
    put(objects[i].model_ws);
    for (int row = 0; row < 3; row++)
        put(objects[i].normal_ws[row]);
    put(objects[i].info);
}

void put_light(uint i)
{
    put(lights.light[i].position_ws);
    put(lights.light[i].direction_ws);
    put(lights.light[i].color);
    put(lights.light[i].shadow);
}

void main()
{
    put_object(0u);
    put_object(2u);
    put(material.base_color);
    put(material.emissive);
    put(material.surface);
    put(material.maps);
    for (int i = 0; i < 10; i++)
        put(material.uv_transform[i]);
    put(view.view);
    put(view.projection);
    put(view.view_projection);
    put(view.inverse_view_projection);
    put(view.position_ws);
    put(view.forward_ws);
    put(view.size);
    put(view.lens);
    put(lights.count);
    put_light(0u);
    put_light(1u);
    put_light(uint(KD_MAX_LIGHTS - 1));
    for (int i = 0; i < KD_MAX_SHADOW_CASCADES * KD_MAX_DIRECTIONAL_SHADOWS + KD_MAX_SPOT_SHADOWS; i++)
        put(lights.shadow_matrix[i]);
    put(lights.kinds);
    for (int i = 0; i < KD_MAX_SHADOW_CASCADES * KD_MAX_DIRECTIONAL_SHADOWS; i++)
        put(lights.cascade_texel_ws[i]);
    put(resolve.mode);
}
