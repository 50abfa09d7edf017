// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace lightmesh {

/// A checked copy of the user's triangles, for the shadow volumes of any number of lights.
class OccluderTriangles {
public:
    /// Three corners in world units.
    using Triangle = std::array<glm::vec3, 3>;

    /// Throws std::invalid_argument that names the triangle for a corner that is not finite,
    /// std::length_error for more than 2^32 - 1 triangles.
    template <class Source>
    explicit OccluderTriangles(const Source& source) {
        static_assert(check_occluders<Source>());
        const std::size_t count = source.triangle_count();
        if (count > 0xffffffffu)
            throw std::length_error("lightmesh: there are " + std::to_string(count) +
                                    " occluders; shadow volumes take up to 4294967295");
        triangles_.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            triangles_.push_back(source.triangle(i));
            for (const glm::vec3& corner : triangles_.back())
                detail::require(detail::is_finite(corner), "a corner of occluder " + std::to_string(i),
                                corner, "finite");
        }
    }

    /// Number of triangles.
    std::size_t size() const { return triangles_.size(); }
    /// Triangle i, i < size().
    const Triangle& operator[](std::size_t i) const { return triangles_[i]; }
    /// Memory taken.
    std::size_t bytes() const { return sizeof *this + triangles_.capacity() * sizeof(Triangle); }

private:
    std::vector<Triangle> triangles_;
};

}  // namespace lightmesh
