// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/segment.hpp>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lightmesh {

/// The caller's own tracer of segments, for `VisibilityCache::fill`:
///
///     void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit);
///
/// As `BatchIntersector`: sets hit[i] to 1 if segments[i] is blocked, else to 0. Both spans have the same
/// size, from 1 to `most_listed_segments`; those from one record follow each other. The answers should be
/// those of the cache's `Intersector`. What it throws leaves `VisibilityCache::fill`, and nothing is stored
/// of what the call was about.
template <class Trace>
concept SegmentTracer = std::invocable<Trace&, std::span<const Segment>, std::span<std::uint8_t>>;

/// The most segments of a call of a `SegmentTracer`: 24 MiB of them.
inline constexpr std::size_t most_listed_segments = std::size_t{1} << 20;

}  // namespace lightmesh
