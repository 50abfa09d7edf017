# SPDX-License-Identifier: MIT

# A project that adds lightmesh as a folder gets its headers, and neither tests nor installed files nor flags.
#   cmake -DBUILD=build folder of examples/consumer -P check_subproject.cmake
execute_process(COMMAND ${CMAKE_CTEST_COMMAND} --test-dir ${BUILD} -N OUTPUT_VARIABLE tests)
if(NOT tests MATCHES "Total Tests: 0")
    message(FATAL_ERROR "The consumer has tests of its own:\n${tests}")
endif()
execute_process(COMMAND ${CMAKE_COMMAND} --install ${BUILD} --prefix ${BUILD}/installed COMMAND_ERROR_IS_FATAL ANY)
file(GLOB_RECURSE installed ${BUILD}/installed/*)
if(installed)
    message(FATAL_ERROR "The consumer installs ${installed}")
endif()
