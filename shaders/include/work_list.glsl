// A list of work for an indirect dispatch of groups of 64, runtime/gpu/work_list.h. Entries come in any order: each is worked
// on alone.

#ifndef KD_WORK_ACCESS
#define KD_WORK_ACCESS readonly
#endif

layout(std430, binding = 0) KD_WORK_ACCESS buffer work_block {
    uint work_args[3];
    uint work_count;
    uint work_items[];
};
