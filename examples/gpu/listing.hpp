// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/surface_point.hpp>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <cstddef>
#include <span>

namespace demo {

/// All that list_part(some points, list) lists at points, on all threads: a `lightmesh::LongTestList` or
/// another that adds up.
template <class List, class ListPart>
List list_on_all_threads(std::span<const lightmesh::SurfacePoint> points, ListPart&& list_part) {
    constexpr std::size_t at_once = 256;
    return tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, points.size(), at_once), List(),
        [&](const auto& part, List list) {
            list_part(points.subspan(part.begin(), part.size()), list);
            return list;
        },
        [](List list, const List& other) {
            list.add(other);
            return list;
        });
}

}  // namespace demo
