// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// Most segments that the library hands to an `Intersector` at once.
inline constexpr std::size_t most_segments = 64;

/// Sets hit[i] to 1 if segments[i] is blocked, else 0; at once if the adapter can.
template <Intersector Tracer>
void trace(const Tracer& tracer, std::span<const Segment> segments, std::span<std::uint8_t> hit) {
    if (segments.empty())
        return;
    if constexpr (BatchIntersector<Tracer>) {
        tracer.occluded(segments, hit);
    } else {
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = tracer.occluded(segments[i]) ? 1 : 0;
    }
}

}  // namespace lightmesh::detail
