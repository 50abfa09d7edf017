// SPDX-License-Identifier: MIT
#pragma once

/// Code for processors with AVX2 inside of programs that are compiled for any x86-64.

#if defined(__GNUC__) && defined(__x86_64__)

#define LIGHTMESH_HAS_AVX2_KERNEL 1
#define LIGHTMESH_AVX2 __attribute__((target("avx2,bmi,bmi2,popcnt")))

namespace lightmesh::detail {

/// True if the processor that the program runs on has what functions marked LIGHTMESH_AVX2 need.
inline bool can_run_avx2() {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
}

}  // namespace lightmesh::detail

#endif
