# libkandil, static and shared, from the objects of every module, and what `cmake --install` puts where.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(kd_modules kd_core kd_jobs kd_ecs kd_gpu kd_asset kd_profile kd_components kd_script kd_systems kd_reference
    kd_compare kd_bench kd_ui kd_app)
set(kd_objects $<TARGET_OBJECTS:kd_shaders>)
set(kd_third_parties "")
foreach(module ${kd_modules})
    list(APPEND kd_objects $<TARGET_OBJECTS:${module}>)
    get_target_property(links ${module} INTERFACE_LINK_LIBRARIES)
    foreach(link ${links})
        if(NOT link MATCHES "kd_")
            list(APPEND kd_third_parties ${link})
        endif()
    endforeach()
endforeach()
list(REMOVE_DUPLICATES kd_third_parties)
list(REMOVE_ITEM kd_third_parties $<LINK_ONLY:kd_warnings>)

# Only what starts with kd_ is to be seen from outside; headers that are not installed declare the rest.
set(kd_exports ${CMAKE_SOURCE_DIR}/cmake/exports.map)
add_library(kandil_shared SHARED ${kd_objects})
add_library(kandil_static STATIC ${kd_objects})
set_target_properties(kandil_shared PROPERTIES EXPORT_NAME kandil VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR} LINK_DEPENDS ${kd_exports})
target_link_options(kandil_shared PRIVATE -Wl,--version-script=${kd_exports} -Wl,--no-undefined)
target_link_libraries(kandil_shared PRIVATE ${kd_third_parties})
kd_count_allocations(kandil_shared)
set(kd_static_links imgui stb lua5.4 spng webp draco meshoptimizer xxhash zstd embree3 osdCPU tinyexr stdc++ ${CMAKE_DL_LIBS} pthread m)
target_link_libraries(kandil_static INTERFACE ${kd_static_links})
foreach(library kandil_shared kandil_static)
    set_target_properties(${library} PROPERTIES OUTPUT_NAME kandil LINKER_LANGUAGE CXX)
    target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kandil>)
endforeach()

# The manual page and the completion are what the program prints.
set(kd_manual ${CMAKE_BINARY_DIR}/generated/kandil.1)
set(kd_completion ${CMAKE_BINARY_DIR}/generated/kandil.bash)
set(kd_zsh_completion ${CMAKE_BINARY_DIR}/generated/kandil.zsh)
add_custom_command(OUTPUT ${kd_manual} COMMAND kandil help man > ${kd_manual} DEPENDS kandil VERBATIM)
add_custom_command(OUTPUT ${kd_completion} COMMAND kandil help bash > ${kd_completion} DEPENDS kandil VERBATIM)
add_custom_command(OUTPUT ${kd_zsh_completion} COMMAND kandil help zsh > ${kd_zsh_completion} DEPENDS kandil VERBATIM)
add_custom_target(manual ALL DEPENDS ${kd_manual} ${kd_completion} ${kd_zsh_completion})

# Headers that kandil.h includes, found by following them.
function(kd_public_headers file out)
    set(found ${${out}})
    if(file IN_LIST found)
        return()
    endif()
    list(APPEND found ${file})
    file(STRINGS ${CMAKE_SOURCE_DIR}/${file} lines REGEX "^[ ]*#include \"")
    foreach(line ${lines})
        string(REGEX REPLACE "^[ ]*#include \"([^\"]*)\".*" "\\1" next ${line})
        kd_public_headers(${next} found)
    endforeach()
    set(${out} ${found} PARENT_SCOPE)
endfunction()
set(kd_headers "")
kd_public_headers(kandil.h kd_headers)
foreach(header ${kd_headers})
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kandil/${folder})
endforeach()

install(TARGETS kandil RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS kandil_shared kandil_static EXPORT kandil
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(FILES ${kd_manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${kd_completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME kandil)
install(FILES ${kd_zsh_completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _kandil)

install(EXPORT kandil NAMESPACE kandil:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kandil)
configure_package_config_file(cmake/kandil-config.cmake.in ${CMAKE_BINARY_DIR}/generated/kandil-config.cmake
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kandil)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/kandil-config-version.cmake
    COMPATIBILITY SameMinorVersion)
list(TRANSFORM kd_static_links PREPEND -l OUTPUT_VARIABLE kd_static_flags)
list(JOIN kd_static_flags " " KD_STATIC_LIBS)
# where the file lies, so that the tree can be moved
file(RELATIVE_PATH KD_PREFIX_FROM_PC ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/kandil.pc.in ${CMAKE_BINARY_DIR}/generated/kandil.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/generated/kandil-config.cmake
    ${CMAKE_BINARY_DIR}/generated/kandil-config-version.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kandil)
install(FILES ${CMAKE_BINARY_DIR}/generated/kandil.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# Pages of the public headers, by Doxygen; what it finds wrong in them is an error.
find_program(DOXYGEN doxygen)
if(DOXYGEN)
    set(kd_pages ${kd_headers})
    list(TRANSFORM kd_pages PREPEND ${CMAKE_SOURCE_DIR}/)
    list(JOIN kd_pages " " KD_DOXYGEN_INPUT)
    string(APPEND KD_DOXYGEN_INPUT " ${CMAKE_SOURCE_DIR}/docs/library.md ${CMAKE_SOURCE_DIR}/docs/ecs.md ${CMAKE_SOURCE_DIR}/docs/jobs.md")
    configure_file(docs/Doxyfile.in ${CMAKE_BINARY_DIR}/generated/Doxyfile @ONLY)
    add_custom_target(reference_pages COMMAND ${DOXYGEN} ${CMAKE_BINARY_DIR}/generated/Doxyfile VERBATIM)
endif()
