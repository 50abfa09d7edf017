# SPDX-License-Identifier: MIT

# GLM's macros that change types or conventions: those that hide nothing of each other share a program, for the time it
# takes to compile them.
set(strict PURE EXPLICIT_CTOR SIZE_T_LENGTH XYZW_ONLY DEPTH_ZERO_TO_ONE)
set(aligned INTRINSICS DEFAULT_ALIGNED_GENTYPES CTOR_INIT LEFT_HANDED)
set(wide SWIZZLE PRECISION_LOWP_FLOAT UNRESTRICTED_GENTYPE)
foreach(group IN ITEMS strict aligned wide)
    lightmesh_add_test_program(lightmesh-test-glm-${group} "GLM's macros, ${group}:" glm_macros_test.cpp)
    list(TRANSFORM ${group} PREPEND GLM_FORCE_)
    target_compile_definitions(lightmesh-test-glm-${group} PRIVATE ${${group}})
    target_compile_options(lightmesh-test-glm-${group} PRIVATE -O0)
endforeach()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False reports inside std::optional, of members that GLM_FORCE_CTOR_INIT itself sets.
    target_compile_options(lightmesh-test-glm-aligned PRIVATE -Wno-maybe-uninitialized)
endif()
