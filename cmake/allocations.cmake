# Lead what a target's own code takes from the heap through runtime/core/allocations.c, which counts it.
function(kd_count_allocations target)
    foreach(function malloc calloc realloc aligned_alloc strdup strndup)
        target_link_options(${target} PRIVATE -Wl,--wrap=${function})
    endforeach()
endfunction()
