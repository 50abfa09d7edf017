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

# Which radius, which quality: measured with the user's own tracer, by public names only.
add_library(lightmesh_tune INTERFACE)
add_library(lightmesh::tune ALIAS lightmesh_tune)
set_target_properties(lightmesh_tune PROPERTIES EXPORT_NAME tune)
target_link_libraries(lightmesh_tune INTERFACE lightmesh)
