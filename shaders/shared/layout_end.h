/* See layout.h. No guard: it is meant to be read each time. */
#ifndef KD_GLSL
#undef vec4
#undef uvec4
#undef ivec4
#undef mat4
#endif
