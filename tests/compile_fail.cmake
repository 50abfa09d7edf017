# SPDX-License-Identifier: MIT

# Programs that must not compile, with the sentence that they must give. What they include is compiled once for all of
# them, and none of them runs before it is.
set(compiler ${CMAKE_CXX_COMPILER} -std=c++20 -I${PROJECT_SOURCE_DIR}/include)
get_target_property(glm_includes glm::glm INTERFACE_INCLUDE_DIRECTORIES)
if(glm_includes)
    list(TRANSFORM glm_includes PREPEND -I)
    list(APPEND compiler ${glm_includes})
endif()
set(library ${CMAKE_CURRENT_BINARY_DIR}/compile_fail/library.hpp)
file(CONFIGURE OUTPUT ${library} CONTENT "#include <${CMAKE_CURRENT_SOURCE_DIR}/compile_fail/wrong.hpp>\n")
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(precompiled -o ${library}.gch)
else()
    set(precompiled -o ${library}.pch -fpch-instantiate-templates)
endif()
add_test(NAME "the library compiles before what must not" COMMAND ${compiler} -x c++-header ${library} ${precompiled})
set_tests_properties("the library compiles before what must not" PROPERTIES FIXTURES_SETUP precompiled_library)

file(GLOB programs CONFIGURE_DEPENDS compile_fail/*.cpp)
foreach(program IN LISTS programs)
    get_filename_component(name ${program} NAME_WE)
    add_test(NAME "must not compile: ${name}"
             COMMAND ${CMAKE_COMMAND} -DSOURCE=${program} "-DCOMMAND=${compiler};-fsyntax-only;-include;${library}" -P
                     ${CMAKE_CURRENT_SOURCE_DIR}/check_compile_fail.cmake)
    set_tests_properties("must not compile: ${name}" PROPERTIES FIXTURES_REQUIRED precompiled_library)
endforeach()
