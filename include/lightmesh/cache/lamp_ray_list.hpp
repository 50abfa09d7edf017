// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/row_table.hpp>

namespace lightmesh {

template <class Tracer, class Rows>
class VisibilityCache;

/// Shares of lamps that a cache lacks at some points, each named once: made by
/// `VisibilityCache::list_lamp_rays`, served by `VisibilityCache::fill` of the same cache.
class LampRayList {
public:
    /// True if nothing is lacking.
    bool is_empty() const { return rows_.entries().empty(); }

    /// Adds what another one lists, say another thread's. Throws std::bad_alloc.
    void add(const LampRayList& other) { rows_.add(other.rows_); }

private:
    template <class Tracer, class Rows>
    friend class VisibilityCache;

    detail::RowTable rows_;
};

}  // namespace lightmesh
