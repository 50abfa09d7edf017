# SPDX-License-Identifier: MIT

include(GNUInstallDirs)

# What users link: C++20, the include path and GLM, nothing else.
if(NOT TARGET glm::glm)
    lightmesh_find(libglm-dev glm CONFIG)
endif()
add_library(lightmesh INTERFACE)
add_library(lightmesh::lightmesh ALIAS lightmesh)
target_compile_features(lightmesh INTERFACE cxx_std_20)
target_include_directories(
    lightmesh INTERFACE $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
                        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(lightmesh INTERFACE glm::glm)
