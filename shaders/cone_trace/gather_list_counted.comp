// gather_list.comp, counting samples.
#define COUNT_SAMPLES
#include "shaders/cone_trace/gather_list.comp"
