// gather.comp, counting samples.
#define COUNT_SAMPLES
#include "shaders/cone_trace/gather.comp"
