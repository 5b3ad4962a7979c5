# Every file below shaders/ goes into the program as a C array, so that an installed kandil needs no folder beside it.
file(GLOB_RECURSE kd_shader_files CONFIGURE_DEPENDS RELATIVE ${CMAKE_SOURCE_DIR}
    ${CMAKE_SOURCE_DIR}/shaders/*.comp ${CMAKE_SOURCE_DIR}/shaders/*.vert ${CMAKE_SOURCE_DIR}/shaders/*.frag
    ${CMAKE_SOURCE_DIR}/shaders/*.geom ${CMAKE_SOURCE_DIR}/shaders/*.glsl ${CMAKE_SOURCE_DIR}/shaders/*.h)
set(kd_shader_paths ${kd_shader_files})
list(TRANSFORM kd_shader_paths PREPEND ${CMAKE_SOURCE_DIR}/)
set(kd_shader_source ${CMAKE_BINARY_DIR}/generated/embedded_shaders.c)
add_custom_command(OUTPUT ${kd_shader_source}
    COMMAND ${CMAKE_COMMAND} -DROOT=${CMAKE_SOURCE_DIR} -DOUT=${kd_shader_source} "-DFILES=${kd_shader_files}"
            -P ${CMAKE_SOURCE_DIR}/cmake/embed.cmake
    DEPENDS ${kd_shader_paths} ${CMAKE_SOURCE_DIR}/cmake/embed.cmake VERBATIM)
add_library(kd_shaders STATIC ${kd_shader_source})
target_include_directories(kd_shaders PRIVATE ${CMAKE_SOURCE_DIR})
target_link_libraries(kd_gpu PUBLIC kd_shaders)
