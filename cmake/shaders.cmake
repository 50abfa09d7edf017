# SPDX-License-Identifier: MIT

# lightmesh_add_shader(TARGET SOURCE [NAME name] [DEFINES NAME=VALUE ...] [INCLUDES folder ...]): compiles a shader to
# SPIR-V with the target, which finds its words, comma by comma, as
#     constexpr std::uint32_t words[] = {
#     #include "spirv/name.inc"
#     };
# The name is that of the source, such as query.comp, if none is given. include/ and the source's folder are where
# #include looks; what is included is watched. Drivers optimise what they get: -O would only inline all calls before, and
# lavapipe would compile for half a minute what takes it one second. Needs LIGHTMESH_GLSLC.
function(lightmesh_add_shader target source)
    cmake_parse_arguments(PARSE_ARGV 2 shader "" "NAME" "DEFINES;INCLUDES")
    get_filename_component(source ${source} ABSOLUTE)
    if(NOT shader_NAME)
        get_filename_component(shader_NAME ${source} NAME)
    endif()
    list(TRANSFORM shader_DEFINES PREPEND -D)
    list(TRANSFORM shader_INCLUDES PREPEND -I)
    set(words ${CMAKE_CURRENT_BINARY_DIR}/spirv/${shader_NAME}.inc)
    file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/spirv)
    add_custom_command(
        OUTPUT ${words}
        COMMAND ${LIGHTMESH_GLSLC} --target-env=vulkan1.1 -Werror -mfmt=num -I${PROJECT_SOURCE_DIR}/include
                ${shader_INCLUDES} ${shader_DEFINES} -MD -MF ${words}.d -MT ${words} -o ${words} ${source}
        DEPENDS ${source}
        DEPFILE ${words}.d
        COMMENT "Compiling shader ${shader_NAME}"
        VERBATIM)
    target_sources(${target} PRIVATE ${words})
    target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
endfunction()

# lightmesh_add_ray_shader(TARGET SOURCE [NAME name] [DEFINES NAME=VALUE ...]): compiles a shader that includes rays.glsl
# twice, as above: for devices with ray queries with RAY_QUERIES defined. The target finds both as
#     #include "spirv/name.hpp"     // demo::spirv::name, a demo::RayShader
# The name, a C++ identifier, is that of the source without .comp if none is given.
function(lightmesh_add_ray_shader target source)
    cmake_parse_arguments(PARSE_ARGV 2 shader "" "NAME" "DEFINES")
    if(NOT shader_NAME)
        get_filename_component(shader_NAME ${source} NAME_WE)
    endif()
    lightmesh_add_shader(${target} ${source} NAME ${shader_NAME}_by_bvh DEFINES ${shader_DEFINES})
    lightmesh_add_shader(${target} ${source} NAME ${shader_NAME}_by_ray_queries DEFINES ${shader_DEFINES} RAY_QUERIES)
    configure_file(${PROJECT_SOURCE_DIR}/cmake/ray_shader.hpp.in
                   ${CMAKE_CURRENT_BINARY_DIR}/spirv/${shader_NAME}.hpp @ONLY)
endfunction()
