# SPDX-License-Identifier: MIT

# Every public name is documented, and Doxygen understands all of it.
find_program(LIGHTMESH_DOXYGEN doxygen)
if(NOT LIGHTMESH_DOXYGEN)
    lightmesh_missing(doxygen doxygen)
endif()
set(LIGHTMESH_INCLUDE_DIR ${PROJECT_SOURCE_DIR}/include)
set(LIGHTMESH_DOXYGEN_OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/doxygen)
configure_file(Doxyfile.in Doxyfile @ONLY)
add_test(NAME "Doxygen has nothing to warn of" COMMAND ${LIGHTMESH_DOXYGEN} ${CMAKE_CURRENT_BINARY_DIR}/Doxyfile)
