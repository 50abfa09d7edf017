// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/blend.hpp>
#include <lightmesh/cache/cell_values.hpp>
#include <lightmesh/cache/kernels/avx2.hpp>
#include <lightmesh/cache/kernels/portable.hpp>
#include <lightmesh/cache/lamp_columns.hpp>
#include <lightmesh/support/processor.hpp>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// The work of a cache's queries for many lights at once. All kernels give the same bits: integers, and
/// floats whose products are exact, so that it does not matter whether a compiler fuses them with sums.
struct CacheKernels {
    const char* name;
    /// The lights of a tile whose centres face a point and have it in their range.
    std::uint64_t (*find_reaching)(const LampColumns& lamps, std::size_t size, const glm::vec3& point,
                                   const glm::vec3& normal);
    /// Begins with all of the weight left for some lights, and none for others.
    void (*start)(Blend& blend, std::uint64_t lights);
    /// Gives what is left of some lights' weights to the values of a cell's first record.
    void (*give_to_first)(Blend& blend, const CellValues& values, std::uint64_t lights);
    /// Adds a level: S = lerp(S of this level, S of the next, beta) with beta = smoothstep of the
    /// greatest weighted difference between one record and their blend, more of it in the dark, or more than
    /// that: see `spread_lows` and `BlendLevel`. Returns the lights that the next level has to say something
    /// about.
    std::uint64_t (*blend_level)(Blend& blend, std::uint64_t lights, const BlendLevel& level);
    /// The values that are found, from 0 to 1.
    void (*write_blend)(const Blend& blend, std::span<float> lit);
    /// The values of a cell's first record alone, from 0 to 1; 0 for other lights.
    void (*write_first)(const CellValues& values, std::uint64_t lights, std::span<float> lit);
};

inline constexpr CacheKernels portable_cache_kernels{.name = "portable",
                                                     .find_reaching = portable_cache::find_reaching,
                                                     .start = portable_cache::start,
                                                     .give_to_first = portable_cache::give_to_first,
                                                     .blend_level = portable_cache::blend_level,
                                                     .write_blend = portable_cache::write_blend,
                                                     .write_first = portable_cache::write_first};

#if defined(LIGHTMESH_HAS_AVX2_KERNEL)
inline constexpr CacheKernels avx2_cache_kernels{.name = "AVX2",
                                                 .find_reaching = avx2_cache::find_reaching,
                                                 .start = avx2_cache::start,
                                                 .give_to_first = avx2_cache::give_to_first,
                                                 .blend_level = avx2_cache::blend_level,
                                                 .write_blend = avx2_cache::write_blend,
                                                 .write_first = avx2_cache::write_first};
#endif

/// The fastest kernels for the processor that the program runs on; chosen once.
inline const CacheKernels& cache_kernels() {
    static const CacheKernels& fastest = []() -> const CacheKernels& {
#if defined(LIGHTMESH_HAS_AVX2_KERNEL)
        if (can_run_avx2())
            return avx2_cache_kernels;
#endif
        return portable_cache_kernels;
    }();
    return fastest;
}

}  // namespace lightmesh::detail
