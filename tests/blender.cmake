# SPDX-License-Identifier: MIT

# The core hides all but its own functions: Blender may have another Embree or TBB.
add_test(NAME "blender: symbols" COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DCORE=$<TARGET_FILE:lightmesh_blender_core> -P
                                         ${CMAKE_CURRENT_SOURCE_DIR}/check_symbols.cmake)

# A test that says why it is none.
function(add_skipped_test name why)
    message(STATUS "lightmesh: ${why}")
    add_test(NAME ${name} COMMAND ${CMAKE_COMMAND} -E echo ${why})
    set_tests_properties(${name} PROPERTIES SKIP_REGULAR_EXPRESSION "there is no")
endfunction()

# The add-on inside Blender, where there is one: each script in a Blender of its own, with a profile of its own.
find_program(LIGHTMESH_BLENDER blender)
if(NOT LIGHTMESH_BLENDER)
    add_skipped_test("blender: add-on" "there is no blender, so its add-on is not tested; Debian: blender python3-numpy")
    return()
endif()
find_program(LIGHTMESH_XVFB_RUN xvfb-run)
set(blender_environment BLENDER_USER_SCRIPTS=${PROJECT_BINARY_DIR}/examples/blender/scripts
                        BLENDER_USER_CONFIG=${PROJECT_BINARY_DIR}/tests/blender PYTHONDONTWRITEBYTECODE=1)
set(blender ${LIGHTMESH_BLENDER} --factory-startup --addons light_mesh --python-exit-code 1 --python)
list(INSERT blender 1 --background)
foreach(script bake behaviour shadows units)
    add_test(NAME "blender: ${script}" COMMAND ${blender} ${CMAKE_CURRENT_SOURCE_DIR}/blender/${script}.py)
    set_tests_properties("blender: ${script}" PROPERTIES ENVIRONMENT "${blender_environment}" PASS_REGULAR_EXPRESSION
                                                                                              "\nOK\n" TIMEOUT 300)
endforeach()
add_test(NAME "blender: install" COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/blender/install.sh ${LIGHTMESH_BLENDER}
                                         ${PROJECT_BINARY_DIR}/examples/blender/light_mesh.zip)
set_tests_properties("blender: install" PROPERTIES TIMEOUT 120)
if(LIGHTMESH_XVFB_RUN)
    list(REMOVE_AT blender 1)
    add_test(NAME "blender: interface"
             COMMAND ${LIGHTMESH_XVFB_RUN} -a -s "-screen 0 640x600x24 +extension GLX" ${blender}
                     ${CMAKE_CURRENT_SOURCE_DIR}/blender/interface.py)
    set_tests_properties("blender: interface" PROPERTIES ENVIRONMENT "${blender_environment};LIBGL_ALWAYS_SOFTWARE=1"
                                                         TIMEOUT 300)
else()
    add_skipped_test("blender: interface"
                     "there is no xvfb-run, so the add-on's interface is not tested; Debian: xvfb xauth libxtst6")
endif()
