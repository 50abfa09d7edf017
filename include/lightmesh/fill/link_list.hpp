// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/unit_table.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace lightmesh {

template <class Tracer, class Source>
class LightMesh;

/// Links between light points that a mesh lacks at some points, each named once: made by
/// `LightMesh::list_links`, served by `LightMesh::fill_links` of the same mesh.
class LinkList {
public:
    /// Whether nothing is lacking.
    bool is_empty() const {
        return std::ranges::all_of(levels_,
                                   [](const detail::UnitTable& level) { return level.entries().empty(); });
    }

    /// Adds what another one lists, say another thread's. Throws std::bad_alloc.
    void add(const LinkList& other) {
        if (levels_.size() < other.levels_.size())
            levels_.resize(other.levels_.size());
        for (std::size_t k = 0; k < other.levels_.size(); ++k)
            levels_[k].add(other.levels_[k]);
    }

private:
    template <class Tracer, class Source>
    friend class LightMesh;

    std::vector<detail::UnitTable> levels_;  ///< all of tile 0, with one bit a cell
};

}  // namespace lightmesh
