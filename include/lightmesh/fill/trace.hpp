// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh::detail {

/// Most segments that the library hands to an `Intersector` at once, if that does not say otherwise.
inline constexpr std::size_t most_segments = 64;

/// Most segments that a tracer takes at once (see `BatchIntersector`).
template <Intersector Tracer>
constexpr std::size_t largest_batch() {
    if constexpr (requires { Tracer::max_batch; }) {
        static_assert(Tracer::max_batch >= 1, "lightmesh: max_batch of an Intersector must be at least 1");
        return (std::min)(std::size_t{Tracer::max_batch}, std::size_t{1024});
    } else {
        return most_segments;
    }
}

/// Sets hit[i] to 1 if segments[i] is blocked, else to 0; many at once if the adapter can.
template <Intersector Tracer>
void trace(const Tracer& tracer, std::span<const Segment> segments, std::span<std::uint8_t> hit) {
    if constexpr (BatchIntersector<Tracer>) {
        for (std::size_t first = 0; first < segments.size(); first += largest_batch<Tracer>()) {
            const std::size_t size = (std::min)(segments.size() - first, largest_batch<Tracer>());
            tracer.occluded(segments.subspan(first, size), hit.subspan(first, size));
        }
    } else {
        for (std::size_t i = 0; i < segments.size(); ++i)
            hit[i] = tracer.occluded(segments[i]) ? 1 : 0;
    }
}

}  // namespace lightmesh::detail
