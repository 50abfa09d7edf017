// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/query/kernels/avx2.hpp>
#include <lightmesh/query/kernels/avx512.hpp>
#include <lightmesh/query/kernels/kernel_types.hpp>
#include <lightmesh/query/kernels/portable.hpp>

namespace lightmesh::detail {

inline constexpr Kernels portable_kernels{.name = "portable",
                                          .find_masks = portable::find_masks,
                                          .find_facing = portable::find_facing,
                                          .add_rows = portable::add_rows,
                                          .add_words = portable::add_words,
                                          .divide = portable::divide};

#if defined(LIGHTMESH_HAS_AVX2_KERNEL)
inline constexpr Kernels avx2_kernels{.name = "AVX2",
                                      .find_masks = avx2::find_masks,
                                      .find_facing = avx2::find_facing,
                                      .add_rows = avx2::add_rows,
                                      .add_words = avx2::add_words,
                                      .divide = avx2::divide};
#endif

#if defined(LIGHTMESH_HAS_AVX512_KERNEL)
inline constexpr Kernels avx512_kernels{.name = "AVX-512",
                                        .find_masks = avx512::find_masks,
                                        .find_facing = avx2::find_facing,
                                        .add_rows = avx512::add_rows,
                                        .add_words = avx512::add_words,
                                        .divide = avx2::divide};

/// As `can_run_avx2`.
inline bool can_run_avx512() {
    return can_run_avx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512bitalg");
}
#endif

/// The fastest kernels for the processor that the program runs on; chosen once.
inline const Kernels& kernels() {
    static const Kernels& fastest = []() -> const Kernels& {
#if defined(LIGHTMESH_HAS_AVX512_KERNEL)
        if (can_run_avx512())
            return avx512_kernels;
#endif
#if defined(LIGHTMESH_HAS_AVX2_KERNEL)
        if (can_run_avx2())
            return avx2_kernels;
#endif
        return portable_kernels;
    }();
    return fastest;
}

}  // namespace lightmesh::detail
