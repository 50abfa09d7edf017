# SPDX-License-Identifier: MIT

# lightmesh_find(DEBIAN_PACKAGE NAME [arguments of find_package]): a package that is missing is an error that
# says what to install.
macro(lightmesh_find debian_package name)
    # Debian's packages look for parts that nobody here uses, and say so.
    set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
    find_package(${name} ${ARGN} QUIET)
    unset(CMAKE_MESSAGE_LOG_LEVEL)
    if(NOT ${name}_FOUND)
        lightmesh_missing(${debian_package} ${name})
    endif()
endmacro()

function(lightmesh_missing debian_package name)
    message(
        FATAL_ERROR
            "lightmesh: ${name} was not found. On Debian: apt-get install ${debian_package} "
            "(cmake/setup-debian.sh installs all that the examples, tests and benchmarks need). The library alone "
            "needs GLM only: -DLIGHTMESH_BUILD_EXAMPLES=OFF -DLIGHTMESH_BUILD_TESTS=OFF "
            "-DLIGHTMESH_BUILD_BENCHMARKS=OFF")
endfunction()
