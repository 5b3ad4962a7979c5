// For kd_gpu_dispatch_linear: the number of the invocation over all rows of groups. It may exceed the count.
uint linear_index()
{
    return gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x;
}
