# SPDX-License-Identifier: MIT

# GLM's macros that change types or conventions: a program for each, since they cannot be mixed in one.
foreach(
    macro IN
    ITEMS GLM_FORCE_PURE
          GLM_FORCE_DEPTH_ZERO_TO_ONE
          GLM_FORCE_LEFT_HANDED
          GLM_FORCE_SIZE_T_LENGTH
          GLM_FORCE_EXPLICIT_CTOR
          GLM_FORCE_CTOR_INIT
          GLM_FORCE_XYZW_ONLY
          GLM_FORCE_SWIZZLE
          GLM_FORCE_INTRINSICS
          GLM_FORCE_DEFAULT_ALIGNED_GENTYPES
          GLM_FORCE_PRECISION_LOWP_FLOAT
          GLM_FORCE_UNRESTRICTED_GENTYPE)
    string(REPLACE GLM_FORCE_ "" name ${macro})
    string(TOLOWER ${name} name)
    lightmesh_add_test_program(lightmesh-test-glm-${name} "${macro}:" glm_macros_test.cpp)
    target_compile_definitions(lightmesh-test-glm-${name} PRIVATE ${macro})
    # For the time it takes to compile them.
    target_compile_options(lightmesh-test-glm-${name} PRIVATE -O0)
endforeach()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # False reports inside std::optional, of members that GLM_FORCE_CTOR_INIT itself sets.
    target_compile_options(lightmesh-test-glm-ctor_init PRIVATE -Wno-maybe-uninitialized)
endif()
