# SPDX-License-Identifier: MIT

# Every header compiles alone, twice in one program, and with more warnings than the rest: one source file for
# each, all linked into the tests.
file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/include/*.hpp)
foreach(header IN LISTS headers)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/headers/${header}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "#include <${header}>\n#include <${header}>\n" @ONLY)
    list(APPEND header_sources ${source})
endforeach()
add_library(lightmesh_headers OBJECT ${header_sources})
target_link_libraries(lightmesh_headers PRIVATE lightmesh::lightmesh lightmesh_strict_warnings)
# They are compiled for what the compiler says of them.
target_compile_options(lightmesh_headers PRIVATE -O0)
