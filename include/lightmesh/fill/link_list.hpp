// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/unit_table.hpp>

namespace lightmesh {

template <class Tracer, class Source>
class LightMesh;

/// Links between light points that a mesh lacks at some points, each named once: made by
/// `LightMesh::list_links`, served by `LightMesh::fill_links` of the same mesh.
class LinkList {
public:
    /// True if nothing is lacking.
    bool is_empty() const { return units_.is_empty(); }

    /// Adds what another one lists, say another thread's. Throws std::bad_alloc.
    void add(const LinkList& other) { units_.add(other.units_); }

private:
    template <class Tracer, class Source>
    friend class LightMesh;

    detail::UnitsByLevel units_;  ///< all of tile 0, with one bit a cell
};

}  // namespace lightmesh
