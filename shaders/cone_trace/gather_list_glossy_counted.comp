// gather_list_glossy.comp, counting samples.
#define COUNT_SAMPLES
#include "shaders/cone_trace/gather_list_glossy.comp"
