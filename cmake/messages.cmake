# What the program may say, collected from its sources: the list that `kandil help messages` prints.
file(GLOB_RECURSE kd_message_sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_SOURCE_DIR} ${CMAKE_SOURCE_DIR}/runtime/*.c
    ${CMAKE_SOURCE_DIR}/runtime/*.cpp ${CMAKE_SOURCE_DIR}/components/*.c ${CMAKE_SOURCE_DIR}/systems/*.c)
set(kd_message_paths ${kd_message_sources})
list(TRANSFORM kd_message_paths PREPEND ${CMAKE_SOURCE_DIR}/)
set(kd_message_list ${CMAKE_BINARY_DIR}/generated/messages.c)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/generated)
add_executable(collect_messages cmake/messages.c)
target_link_libraries(collect_messages PRIVATE kd_warnings)
add_custom_command(OUTPUT ${kd_message_list}
    COMMAND collect_messages ${CMAKE_SOURCE_DIR} ${kd_message_sources} > ${kd_message_list}
    DEPENDS collect_messages ${kd_message_paths} VERBATIM)
target_sources(kd_app PRIVATE ${kd_message_list})
