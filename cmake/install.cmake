# SPDX-License-Identifier: MIT

include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_DATADIR}/cmake/lightmesh)

install(DIRECTORY include/lightmesh DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp"
        PATTERN "*.glsl")
install(TARGETS lightmesh lightmesh_tune EXPORT lightmeshTargets)
install(EXPORT lightmeshTargets NAMESPACE lightmesh:: DESTINATION ${package_folder})

configure_package_config_file(cmake/lightmeshConfig.cmake.in lightmeshConfig.cmake INSTALL_DESTINATION ${package_folder})
# Version 0: each minor version may break its users.
write_basic_package_version_file(lightmeshConfigVersion.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/lightmeshConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/lightmeshConfigVersion.cmake DESTINATION ${package_folder})
