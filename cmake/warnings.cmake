# Warnings are errors on gcc and clang; the shims in C++ wrap headers that are not ours and get the plain set.
add_library(kd_warnings INTERFACE)
target_compile_options(kd_warnings INTERFACE
    $<$<COMPILE_LANGUAGE:C>:-Wall;-Wextra;-Wpedantic;-Wconversion;-Wshadow;-Werror>
    $<$<COMPILE_LANGUAGE:CXX>:-Wall;-Wextra;-Werror>)
# The same numbers on every machine: no fused operations that one compiler makes and another does not.
target_compile_options(kd_warnings INTERFACE -ffp-contract=off)

if(KANDIL_SANITIZE)
    add_compile_options(-fsanitize=${KANDIL_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all -g)
    add_link_options(-fsanitize=${KANDIL_SANITIZE})
    add_library(kd_sanitizer_options OBJECT ${CMAKE_SOURCE_DIR}/cmake/sanitizer_options.c)
    link_libraries($<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:$<TARGET_OBJECTS:kd_sanitizer_options>>)
endif()
