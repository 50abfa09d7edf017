# SPDX-License-Identifier: MIT

# lightmesh_find(DEBIAN_PACKAGE NAME [arguments of find_package]): a package that is missing is an error that
# says what to install.
macro(lightmesh_find debian_package name)
    find_package(${name} ${ARGN} QUIET)
    if(NOT ${name}_FOUND)
        lightmesh_missing(${debian_package} ${name})
    endif()
endmacro()

function(lightmesh_missing debian_package name)
    message(
        FATAL_ERROR
            "lightmesh: ${name} was not found. On Debian: apt-get install ${debian_package} "
            "(cmake/setup-debian.sh installs all that the examples, tests and benchmarks need). The library alone "
            "needs GLM only: -DLIGHTMESH_BUILD_EXAMPLES=OFF -DLIGHTMESH_BUILD_TESTS=OFF -DLIGHTMESH_BUILD_BENCHMARKS=OFF")
endfunction()
