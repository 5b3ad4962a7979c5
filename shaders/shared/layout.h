/* Lets one header serve C and GLSL: vector names, and a size check where the language has one. Structs use only members
 * whose std430 and C layouts agree: 16-byte rows of vec4/uvec4/ivec4, mat4, or four scalars in a row.
 * Included first by every shared header, and layout_end.h last: in C the short names exist only between the two, since
 * cglm has a mat4 and a vec4 of its own. So no guard round the whole. */
#ifdef KD_GLSL
#define KD_LAYOUT_CHECK(type, size)
#define KD_UINT uint
#define KD_STRUCT
#define KD_INT int
#else
#ifndef KD_SHADERS_LAYOUT_TYPES
#define KD_SHADERS_LAYOUT_TYPES
#include <assert.h>
#include <stdint.h>
typedef struct kd_gl_vec4 { float x, y, z, w; } kd_gl_vec4;
typedef struct kd_gl_uvec4 { uint32_t x, y, z, w; } kd_gl_uvec4;
typedef struct kd_gl_ivec4 { int32_t x, y, z, w; } kd_gl_ivec4;
typedef struct kd_gl_mat4 { float m[16]; } kd_gl_mat4;
#define KD_UINT uint32_t
#define KD_STRUCT struct
#define KD_INT int32_t
#define KD_LAYOUT_CHECK(type, size) static_assert(sizeof(struct type) == (size), #type " must be " #size " bytes");
#endif
#define vec4 kd_gl_vec4
#define uvec4 kd_gl_uvec4
#define ivec4 kd_gl_ivec4
#define mat4 kd_gl_mat4
#endif
