#ifndef KD_INCLUDE_OBJECT_GLSL
#define KD_INCLUDE_OBJECT_GLSL

/* The objects of the draw list, resource "scene.objects", as vertex shaders see them at storage binding 0. */

#include "shaders/shared/scene.h"

layout(std430, binding = 0) readonly buffer objects_block { kd_object objects[]; };

vec3 object_position(uint object, vec3 position)
{
    return (objects[object].model_ws * vec4(position, 1.0)).xyz;
}
vec3 object_direction(uint object, vec3 direction) { return mat3(objects[object].model_ws) * direction; }

vec3 object_normal(uint object, vec3 n)
{
    return vec3(dot(objects[object].normal_ws[0].xyz, n), dot(objects[object].normal_ws[1].xyz, n),
                dot(objects[object].normal_ws[2].xyz, n));
}

uint object_flags_of(uint object) { return objects[object].info.y; }

#endif
