// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/row_table.hpp>
#include <lightmesh/segment.hpp>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

/// Rays to lamps for tracers that take very many at once, such as one on a GPU: what a cache lacks is listed,
/// traced by the caller and stored.

namespace lightmesh {

template <class Tracer, class Rows>
class VisibilityCache;

/// The caller's own tracer of segments:
///
///     void trace(std::span<const Segment> segments, std::span<std::uint8_t> hit);
///
/// As `BatchIntersector`: sets hit[i] to 1 if segments[i] is blocked, else to 0. Both spans have the same
/// size, from 1 to `most_listed_segments`; those that start at one record follow each other. The answers
/// should be those of the cache's `Intersector`. What it throws leaves `VisibilityCache::fill`, and nothing
/// is stored of the records of the call.
template <class Trace>
concept SegmentTracer = std::invocable<Trace&, std::span<const Segment>, std::span<std::uint8_t>>;

/// The most segments of a call of a `SegmentTracer`: 24 MiB of them.
inline constexpr std::size_t most_listed_segments = std::size_t{1} << 20;

/// Shares of lamps that a cache lacks at some points, each named once: made by
/// `VisibilityCache::list_lamp_rays`, served by `VisibilityCache::fill` of the same cache.
class LampRayList {
public:
    /// Whether nothing is lacking.
    bool is_empty() const { return rows_.entries().empty(); }

    /// Adds what another one lists, say another thread's. Throws std::bad_alloc.
    void add(const LampRayList& other) { rows_.add(other.rows_); }

private:
    template <class Tracer, class Rows>
    friend class VisibilityCache;

    detail::RowTable rows_;
};

}  // namespace lightmesh
