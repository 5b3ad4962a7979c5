// Filling a list of work. What finds no room in it, or in one dispatch, is left out.

#define KD_WORK_ACCESS
#include "shaders/include/work_list.glsl"

void work_add(uint item)
{
    uint i = atomicAdd(work_count, 1u);
    if (i >= min(uint(work_items.length()), 65535u * 64u))
        return;
    if (i % 64u == 0u)
        atomicAdd(work_args[0], 1u);
    work_items[i] = item;
}
