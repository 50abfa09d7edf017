// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/bounds.hpp>
#include <lightmesh/cache/lamp_pattern.hpp>
#include <lightmesh/fill/ray_ends.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/support/rounded.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <variant>

namespace lightmesh::detail {

/// A light with its size, as rays see it.
class Lamp {
public:
    explicit Lamp(const Light& light) : shape_(shape_of(light)) {
        std::visit(
            [this](const auto& kind) {
                using Kind = std::remove_cvref_t<decltype(kind)>;
                if constexpr (std::is_same_v<Kind, DirectionalLight>) {
                    size_ = std::tan(static_cast<double>(kind.angular_radius));
                } else if constexpr (std::is_same_v<Kind, RectLight>) {
                    is_rectangle_ = true;
                    half_u_ = glm::dvec3(kind.half_u);
                    half_v_ = glm::dvec3(kind.half_v);
                } else {
                    size_ = static_cast<double>(kind.radius);
                }
            },
            light);
    }

    const LightShape& shape() const { return shape_; }
    bool is_rectangle() const { return is_rectangle_; }
    /// The half sides of a rectangle, else 0.
    const glm::dvec3& half_u() const { return half_u_; }
    const glm::dvec3& half_v() const { return half_v_; }
    /// The radius, of a directional light at a distance; of a rectangle 0.
    double radius(double distance) const { return shape_.is_directional ? size_ * distance : size_; }
    /// True if one ray says all.
    bool is_point() const { return !is_rectangle_ && size_ == 0.0; }
    /// The height above its centre to which a lamp that is no rectangle reaches; of a directional light at
    /// distance 1.
    double top() const {
        return shape_.is_directional ? size_ / std::sqrt(1.0 + rounded(size_ * size_)) : size_;
    }
    /// The distance from its centre at which rays end, for its size.
    double rest() const { return 1.15 * size_; }

    /// True if all of the lamp lies below the plane through a point.
    bool is_below(const glm::vec3& point, const glm::vec3& unit_normal) const {
        const glm::dvec3 n(unit_normal);
        if (shape_.is_directional)
            return rounded_dot(n, glm::dvec3(shape_.at)) < -top();
        const double height = rounded_dot(n, glm::dvec3(shape_.at) - glm::dvec3(point));
        if (is_rectangle_)
            return height < -std::abs(rounded_dot(n, half_u_)) - std::abs(rounded_dot(n, half_v_));
        return height < -top();
    }

    /// True if the plane through a point leaves some of the lamp below.
    bool is_cut(const glm::vec3& point, const glm::vec3& unit_normal) const {
        const glm::dvec3 n(unit_normal);
        const glm::dvec3 at(shape_.at);
        return rounded_dot(n, shape_.is_directional ? at : at - glm::dvec3(point)) < extent_along(n);
    }

    /// The distance to which the lamp reaches at most from its centre along any direction; of a directional
    /// light at distance 1.
    double extent() const { return is_rectangle_ ? glm::length(half_u_) + glm::length(half_v_) : size_; }
    /// The half sides of a box around all to which rays from a box go; of a directional light at distance 1.
    glm::dvec3 extent_from(const Bounds& box) const {
        if (is_rectangle_)
            return glm::abs(half_u_) + glm::abs(half_v_);
        const glm::dvec3 at(shape_.at);
        const glm::dvec3 to_low = shape_.is_directional ? at : at - glm::dvec3(box.low);
        const glm::dvec3 to_high = shape_.is_directional ? at : at - glm::dvec3(box.high);
        const glm::dvec3 most = (glm::max)(to_low * to_low, to_high * to_high);
        glm::dvec3 half(size_);
        // A disc that faces them reaches least far along the way there.
        for (int axis = 0; axis < 3; ++axis) {
            const double least = to_low[axis] * to_high[axis] <= 0.0
                                     ? 0.0
                                     : (std::min)(to_low[axis] * to_low[axis], to_high[axis] * to_high[axis]);
            const double across = most[(axis + 1) % 3] + most[(axis + 2) % 3];
            if (const double whole = least + across; whole > 0.0)
                half[axis] = size_ * std::sqrt(across / whole);
        }
        return half;
    }

    /// The direction, of length 1, from a point to the part of the lamp that is lowest over the plane through
    /// the point; and how long it is.
    struct LowestPart {
        glm::dvec3 direction;
        double length;
    };
    LowestPart lowest_part(const glm::vec3& point, const glm::vec3& unit_normal, double reach) const {
        const glm::dvec3 n(unit_normal);
        glm::dvec3 direction =
            shape_.is_directional ? glm::dvec3(shape_.at) : glm::dvec3(shape_.at) - glm::dvec3(point);
        direction -= extent_along(n) * n;
        const double length = glm::length(direction);
        return {length > 0.0 ? direction / length : n,
                shape_.is_directional ? reach : (std::min)(length, reach)};
    }

    /// The lamp as seen from one point: where rays go. Shaders find the same (see lamp.glsl): each product
    /// is rounded by itself.
    class View {
    public:
        /// `turn`: 32 bits that choose a rotation, or a shift, of the pattern. They should not depend on the
        /// lamp: while it moves, what its rays miss then stays nearly the same. `step`: of the lattice, for
        /// the ends of rays; `reach`: their greatest length.
        View(const Lamp& lamp, const glm::vec3& origin, std::uint32_t turn, double step, double reach)
            : origin_(origin), turn_bits_(turn), is_rectangle_(lamp.is_rectangle_) {
            const LightShape& shape = lamp.shape_;
            const bool is_directional = shape.is_directional;
            middle_ =
                is_directional ? glm::dvec3(shape.at) * reach : glm::dvec3(shape.at) - glm::dvec3(origin);
            const double distance = std::sqrt(rounded_dot(middle_, middle_));
            const double inverse = distance > 0.0 ? 1.0 / distance : 0.0;
            if (!is_directional) {
                // Lamps do not shadow themselves: rays end short of the sphere, of the point, of the pane.
                const auto end = static_cast<double>(end_offset(shape.at, static_cast<float>(step)));
                const double rest = (std::max)(end, lamp.rest());
                const double least = lamp.is_point() || lamp.is_rectangle_ ? 0.5 : 0.3;
                share_ = distance > 0.0 ? (std::max)(least, 1.0 - rounded(rest * inverse)) : 0.0;
                if (share_ * distance > reach)
                    share_ = reach * inverse;
            }
            if (is_rectangle_) {
                u_ = lamp.half_u_;
                v_ = lamp.half_v_;
            } else if (!lamp.is_point()) {
                radius_ = lamp.radius(reach);
                turn_ = radius_ * turn_of(turn_bits_);
                span_disc(distance > 0.0 ? middle_ * inverse : glm::dvec3(0.0, 0.0, 1.0));
            }
        }

        /// The i-th ray of up to `most_pattern_points`.
        Segment ray(std::size_t i) const {
            const glm::dvec2 at = is_rectangle_ ? square_point(static_cast<std::uint32_t>(i), turn_bits_)
                                                : disc_point(i, turn_);
            return to(middle_ + rounded(at.x * u_) + rounded(at.y * v_));
        }
        /// The i-th of eight rays to the lamp's rim: where some of it is hidden by something large, they
        /// disagree.
        Segment rim_ray(std::size_t i) const {
            const glm::dvec2 at = is_rectangle_ ? square_rim(i) : disc_rim(i, turn_);
            return to(middle_ + rounded(at.x * u_) + rounded(at.y * v_));
        }
        Segment middle_ray() const { return to(middle_); }

    private:
        Segment to(const glm::dvec3& offset) const {
            return {origin_, glm::vec3(glm::dvec3(origin_) + rounded(share_ * offset))};
        }

        /// Across a direction. Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017).
        void span_disc(const glm::dvec3& n) {
            const double sign = n.z < 0.0 ? -1.0 : 1.0;
            const double a = -1.0 / (sign + n.z);
            const double b = n.x * n.y * a;
            u_ = glm::dvec3(1.0 + rounded(sign * n.x * n.x * a), sign * b, -sign * n.x);
            v_ = glm::dvec3(b, sign + rounded(n.y * n.y * a), -n.y);
        }

        glm::vec3 origin_;
        std::uint32_t turn_bits_;
        bool is_rectangle_;
        double share_ = 1.0;
        /// Of a disc, and the turn of its pattern, times that.
        double radius_ = 0.0;
        glm::dvec2 turn_{0.0};
        /// The way to the lamp's centre; half sides of a rectangle, or directions of a disc that faces the
        /// origin.
        glm::dvec3 middle_{0.0}, u_{0.0}, v_{0.0};
    };

private:
    double extent_along(const glm::dvec3& unit_normal) const {
        return is_rectangle_
                   ? std::abs(rounded_dot(unit_normal, half_u_)) + std::abs(rounded_dot(unit_normal, half_v_))
                   : size_;
    }

    LightShape shape_;
    bool is_rectangle_ = false;
    double size_ = 0.0;  ///< radius; of a directional light the tangent of its angle
    glm::dvec3 half_u_{0.0}, half_v_{0.0};
};

}  // namespace lightmesh::detail
