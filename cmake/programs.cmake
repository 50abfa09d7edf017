# SPDX-License-Identifier: MIT

# How this project's own programs are compiled; nothing of it reaches users of the library.
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# Libraries are compiled beside each other, whichever is linked to which.
set(CMAKE_OPTIMIZE_DEPENDENCIES ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Debug, Release, RelWithDebInfo or MinSizeRel" FORCE)
endif()

add_library(lightmesh_warnings INTERFACE)
target_compile_options(lightmesh_warnings INTERFACE -Wall -Wextra -Wpedantic)
# Where many files are compiled as one, names of one may shadow those of another, which clang++ tells as well.
if(NOT CMAKE_UNITY_BUILD OR CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(lightmesh_warnings INTERFACE -Wshadow)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False reports inside std::string: https://gcc.gnu.org/bugzilla/show_bug.cgi?id=105651
    target_compile_options(lightmesh_warnings INTERFACE -Wno-restrict)
endif()

# For files that are there to compile the library's headers.
add_library(lightmesh_strict_warnings INTERFACE)
target_compile_options(lightmesh_strict_warnings INTERFACE -Wconversion -Wsign-conversion)
target_link_libraries(lightmesh_strict_warnings INTERFACE lightmesh_warnings)

if(LIGHTMESH_NATIVE)
    add_compile_options(-march=native)
endif()
if(LIGHTMESH_SANITIZE)
    add_compile_options(-fsanitize=${LIGHTMESH_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    add_link_options(-fsanitize=${LIGHTMESH_SANITIZE})
endif()

# While only tests wait for programs, g++ reads the library once for those that are compiled in the same way as the first of
# them. clang++ reads it in each: it tells what a file does not include.
function(lightmesh_read_library_once first)
    if(NOT LIGHTMESH_TEST_OPTIONS OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        return()
    endif()
    target_precompile_headers(${first} PRIVATE <lightmesh/lightmesh.hpp>)
    foreach(program IN LISTS ARGN)
        target_precompile_headers(${program} REUSE_FROM ${first})
    endforeach()
endfunction()
