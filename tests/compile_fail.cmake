# SPDX-License-Identifier: MIT

# Programs that must not compile, with the sentence that they must give.
set(compiler ${CMAKE_CXX_COMPILER} -std=c++20 -fsyntax-only -I${PROJECT_SOURCE_DIR}/include)
get_target_property(glm_includes glm::glm INTERFACE_INCLUDE_DIRECTORIES)
if(glm_includes)
    list(TRANSFORM glm_includes PREPEND -I)
    list(APPEND compiler ${glm_includes})
endif()
file(GLOB programs CONFIGURE_DEPENDS compile_fail/*.cpp)
foreach(program IN LISTS programs)
    get_filename_component(name ${program} NAME_WE)
    add_test(NAME "must not compile: ${name}" COMMAND ${CMAKE_COMMAND} -DSOURCE=${program} "-DCOMMAND=${compiler}" -P
                                                      ${CMAKE_CURRENT_SOURCE_DIR}/check_compile_fail.cmake)
endforeach()
