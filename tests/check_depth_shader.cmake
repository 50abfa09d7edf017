# The SPIR-V in vulkan_depth_renderer.hpp must be what glslc makes of depth.vert.
#   cmake -DGLSLC=... -DADAPTERS=examples/adapters -P check_depth_shader.cmake
execute_process(
    COMMAND ${GLSLC} -O --target-env=vulkan1.1 -mfmt=num -o - ${ADAPTERS}/depth.vert
    OUTPUT_VARIABLE compiled
    RESULT_VARIABLE failed)
if(failed)
    message(FATAL_ERROR "glslc does not compile ${ADAPTERS}/depth.vert")
endif()
file(READ ${ADAPTERS}/vulkan_depth_renderer.hpp header)
string(REGEX MATCH "depth_shader\\[\\] = {[^}]*}" stored "${header}")
string(REGEX MATCHALL "0x[0-9a-f]+" compiled "${compiled}")
string(REGEX MATCHALL "0x[0-9a-f]+" stored "${stored}")
if(NOT compiled OR NOT compiled STREQUAL stored)
    message(FATAL_ERROR "depth_shader in vulkan_depth_renderer.hpp is not depth.vert compiled: it must hold\n${compiled}")
endif()
