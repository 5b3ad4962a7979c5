// gather_list.comp, for the pixels whose reflections are traced.
#define KD_GLOSSY
#include "shaders/cone_trace/gather_list.comp"
