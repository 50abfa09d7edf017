// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/support/check.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// The third, optional part of the contract between a light mesh and its user's program: the triangles
/// themselves, for shadow volumes.

namespace lightmesh {

/// The user's triangles.
///
///     std::size_t triangle_count() const;
///     std::array<glm::vec3, 3> triangle(std::size_t i) const;
///
/// `triangle` is called with i < triangle_count(), and returns the corners in world units, in any order. Each
/// triangle is asked for once, on one thread, and copied: the source need not outlive the call that
/// takes it. A triangle of no area throws no shadow.
template <class T>
concept Occluders = requires(const T& source, std::size_t i) {
    { source.triangle_count() } -> std::convertible_to<std::size_t>;
    { source.triangle(i) } -> std::convertible_to<std::array<glm::vec3, 3>>;
};

namespace detail {

template <class T>
concept CountCallable = requires(T& source) {
    source.triangle_count();
};
template <class T>
concept CountFitting = requires(const T& source) {
    { source.triangle_count() } -> std::convertible_to<std::size_t>;
};
template <class T>
concept TriangleCallable = requires(T& source, std::size_t i) {
    source.triangle(i);
};
template <class T>
concept TriangleConst = requires(const T& source, std::size_t i) {
    source.triangle(i);
};
template <class T>
concept TriangleFitting = requires(T& source, std::size_t i) {
    { source.triangle(i) } -> std::convertible_to<std::array<glm::vec3, 3>>;
};

}  // namespace detail

/// Says in one sentence what is wrong with an adapter:
/// `static_assert(lightmesh::check_occluders<MyTriangles>());`. Whatever takes `Occluders` calls it for its
/// own. Does not compile, or returns true.
template <class T>
consteval bool check_occluders() {
    static_assert(
        std::is_class_v<T>,
        "lightmesh: the Occluders must be a class with the members `std::size_t triangle_count() const` and "
        "`std::array<glm::vec3, 3> triangle(std::size_t) const`");
    if constexpr (std::is_class_v<T>) {
        static_assert(detail::CountCallable<T>,
                      "lightmesh: the Occluders lack the member `std::size_t triangle_count() const`");
        static_assert(!detail::CountCallable<T> || detail::CountFitting<T>,
                      "lightmesh: the Occluders' triangle_count must be const and return std::size_t");
        static_assert(detail::TriangleCallable<T>, "lightmesh: the Occluders lack the member "
                                                   "`std::array<glm::vec3, 3> triangle(std::size_t) const`");
        static_assert(!detail::TriangleCallable<T> || detail::TriangleConst<T>,
                      "lightmesh: the Occluders' triangle must be const");
        static_assert(!detail::TriangleCallable<T> || detail::TriangleFitting<T>,
                      "lightmesh: the Occluders' triangle must return std::array<glm::vec3, 3>");
    }
    return true;
}

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
