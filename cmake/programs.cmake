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
target_compile_options(lightmesh_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow)
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
