# SPDX-License-Identifier: MIT

# examples/consumer/ built as its users would: from the sources, and from an installed package.
function(lightmesh_add_consumer_test name)
    add_test(
        NAME "consumer: ${name}"
        COMMAND
            ${CMAKE_CTEST_COMMAND} --build-and-test ${PROJECT_SOURCE_DIR}/examples/consumer
            ${CMAKE_CURRENT_BINARY_DIR}/consumer-${name} --build-generator ${CMAKE_GENERATOR} --build-options
            -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER} -DCMAKE_BUILD_TYPE=None ${ARGN} --test-command consumer)
    set_tests_properties(
        "consumer: ${name}" PROPERTIES PASS_REGULAR_EXPRESSION
                                       "0.0 m from the middle of the shadow: 0.00 lit.*1.6 m[^\n]*: 0.5.*3.0 m[^\n]*: 1.00")
endfunction()

lightmesh_add_consumer_test(sources -DLIGHTMESH_SOURCE_DIR=${PROJECT_SOURCE_DIR})
add_test(NAME "consumer: sources bring nothing along"
         COMMAND ${CMAKE_COMMAND} -DCMAKE_CTEST_COMMAND=${CMAKE_CTEST_COMMAND} -DBUILD=${CMAKE_CURRENT_BINARY_DIR}/consumer-sources -P
                 ${CMAKE_CURRENT_SOURCE_DIR}/check_subproject.cmake)
set_tests_properties("consumer: sources" PROPERTIES FIXTURES_SETUP consumer_of_sources)
set_tests_properties("consumer: sources bring nothing along" PROPERTIES FIXTURES_REQUIRED consumer_of_sources)

if(LIGHTMESH_INSTALL)
    set(prefix ${CMAKE_CURRENT_BINARY_DIR}/installed)
    add_test(NAME "consumer: install" COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${prefix})
    lightmesh_add_consumer_test(package -DCMAKE_PREFIX_PATH=${prefix})
    set_tests_properties("consumer: install" PROPERTIES FIXTURES_SETUP installed_package)
    set_tests_properties("consumer: package" PROPERTIES FIXTURES_REQUIRED installed_package)
endif()
