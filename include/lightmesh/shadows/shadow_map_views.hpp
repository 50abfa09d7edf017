// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/shadows/cube_faces.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

/// Which pictures a light needs, and where in them a point lies.

namespace lightmesh {

/// The choices of a user for a shadow map of its own; a light mesh makes one of these from its own settings.
struct ShadowMapSettings {
    /// Side of each picture in texels, in [1, 16384]. A picture takes 4 * resolution^2 bytes.
    int resolution = 1024;
    /// For lights with a position: what is nearer to the light than this, along the axis of a picture, throws
    /// no shadow. World units, finite, greater than 0. Not set: 2^-20 of the diagonal of the scene's
    /// bounds.
    std::optional<float> z_near{};
    /// What lies less than this behind a surface counts as lit, in sides of a texel, in [0, 16]: see
    /// `ShadowMap`.
    float bias = 0.5f;
    /// The box around everything that throws shadows: for directional lights, which see all of it, and for
    /// the default of z_near. A `DepthRenderer` with a member `bounds` answers in its coord.
    std::optional<Bounds> scene_bounds{};
};

namespace detail {

inline constexpr int largest_shadow_map = 16384;

/// A view along a unit vector; its up direction is z where that makes sense.
inline DepthView view_along(const glm::vec3& eye, const glm::vec3& forward, int resolution) {
    const bool steep = std::abs(forward.z) > 0.9f;
    const glm::vec3 down_hint = steep ? glm::vec3(0.0f, -1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);
    DepthView view;
    view.eye = eye;
    view.resolution = resolution;
    view.forward = forward;
    view.right = glm::normalize(glm::cross(down_hint, forward));
    view.down = glm::cross(forward, view.right);
    return view;
}

/// A point as a picture sees it.
struct TexelCoord {
    int view = -1;        ///< -1: no picture shows the point, nothing is before it
    float column = 0.0f;  ///< 0 at the left edge, `resolution` at the right one
    float row = 0.0f;
    float distance = 0.0f;  ///< as in the picture
    float stretch = 1.0f;   ///< distance over distance along the axis
    /// The side of a texel where it holds d is d * relative_texel + absolute_texel.
    float relative_texel = 0.0f;
    float absolute_texel = 0.0f;
};

/// The pictures of one light: six faces of a cube for a point light; for a spot light of less than 60 degrees
/// to each side one that holds its cone, and after it the six faces, for points outside the cone; one for a
/// directional light.
class ShadowMapViews {
public:
    /// Throws std::invalid_argument that names the light and the value, and for a directional light without
    /// bounds.
    ShadowMapViews(const Light& light, const ShadowMapSettings& settings, const std::string& name) {
        check_light(light, name);
        const int resolution = settings.resolution;
        require(resolution >= 1 && resolution <= largest_shadow_map, name + ": shadow map's resolution",
                resolution, "in [1, 16384]");
        require(settings.bias >= 0.0f && settings.bias <= 16.0f, name + ": shadow map's bias", settings.bias,
                "in [0, 16] texels");
        if (settings.scene_bounds)
            check_bounds(*settings.scene_bounds, name);
        std::visit([&](const auto& kind) { add_views(kind, settings, name); }, light);
        for (DepthView& view : views_)
            view.clip_from_world = clip_matrix(view, glm::dvec3(0.0));
    }

    std::size_t size() const { return views_.size(); }
    const DepthView& operator[](std::size_t view) const { return views_[view]; }
    const std::vector<DepthView>& all() const { return views_; }

    /// For finite points.
    TexelCoord locate(const glm::vec3& point) const {
        if (views_.front().orthographic)
            return locate_parallel(point);
        const glm::vec3 to_point = point - views_.front().eye;
        TexelCoord coord = locate_direction(to_point);
        coord.distance = glm::length(to_point);
        const DepthView& view = views_[static_cast<std::size_t>(coord.view)];
        const float cosine = coord.distance > 0.0f ? glm::dot(view.forward, to_point) / coord.distance : 1.0f;
        coord.stretch = 1.0f / cosine;
        coord.relative_texel = texel_side(view) * cosine;
        return coord;
    }

    /// The texel of another picture that lies in the direction of a texel outside of this one; view -1 where
    /// nothing is.
    TexelCoord locate_outside(int view, int column, int row) const {
        const DepthView& from = views_[static_cast<std::size_t>(view)];
        return from.orthographic ? TexelCoord{} : locate_direction(from.offset(column, row));
    }

    bool operator==(const ShadowMapViews& other) const {
        return std::ranges::equal(views_, other.views_, [](const DepthView& a, const DepthView& b) {
            return a.eye == b.eye && a.forward == b.forward && a.right == b.right && a.down == b.down &&
                   a.z_near == b.z_near && a.z_far == b.z_far && a.resolution == b.resolution &&
                   a.orthographic == b.orthographic;
        });
    }

    double texel_angle() const { return is_parallel() ? 0.0 : greatest_texel(); }
    double texel_side() const { return is_parallel() ? greatest_texel() : 0.0; }

    /// True if some of a box may be in a picture: not if all of its corners lie beyond one of its sides.
    bool may_show(std::size_t i, const Bounds& box) const {
        const DepthView& view = views_[i];
        // Wider by two texels, against roundings.
        const double edge = 1.0 + 4.0 / view.resolution;
        std::array<bool, 4> is_beyond{true, true, true, true};
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 at((corner & 1) != 0 ? box.high.x : box.low.x,
                                (corner & 2) != 0 ? box.high.y : box.low.y,
                                (corner & 4) != 0 ? box.high.z : box.low.z);
            const glm::dvec3 offset = at - glm::dvec3(view.eye);
            const glm::dvec3 right(view.right);
            const glm::dvec3 down(view.down);
            const double limit =
                edge * (view.orthographic ? 1.0 : glm::dot(glm::dvec3(view.forward), offset));
            const double x = glm::dot(right, offset) / glm::dot(right, right);
            const double y = glm::dot(down, offset) / glm::dot(down, down);
            is_beyond[0] &= x > limit;
            is_beyond[1] &= -x > limit;
            is_beyond[2] &= y > limit;
            is_beyond[3] &= -y > limit;
        }
        return std::ranges::none_of(is_beyond, [](bool all) { return all; });
    }

private:
    bool is_parallel() const { return views_.front().orthographic; }
    double greatest_texel() const {
        double greatest = 0.0;
        for (const DepthView& view : views_)
            greatest = (std::max)(greatest, static_cast<double>(texel_side(view)));
        return greatest;
    }

    static constexpr float widest_single_map =
        1.0471976f;  // 60 degrees: beyond it faces of a cube have finer texels

    static void check_bounds(const Bounds& bounds, const std::string& name) {
        require(is_finite(bounds.low), name + ": lower corner of the scene's bounds", bounds.low, "finite");
        require(is_finite(bounds.high), name + ": upper corner of the scene's bounds", bounds.high, "finite");
        const glm::vec3 size = bounds.high - bounds.low;
        require(size.x >= 0.0f && size.y >= 0.0f && size.z >= 0.0f && glm::length(size) > 0.0f,
                name + ": size of the scene's bounds", size, "greater than 0, and in no axis less");
    }

    void add_views(const PointLight& light, const ShadowMapSettings& settings, const std::string& name) {
        add_cube(light.position, settings.resolution, near_plane(settings, name));
    }

    void add_views(const SpotLight& light, const ShadowMapSettings& settings, const std::string& name) {
        const float z_near = near_plane(settings, name);
        if (light.cone < widest_single_map) {
            has_cone_view_ = true;
            const auto texels = static_cast<float>(settings.resolution);
            cone_edge_ = texels / (texels + 2.0f) * 1.00001f;
            const float half_side = std::tan(light.cone) * (texels + 2.0f) / texels;
            DepthView view = view_along(light.position, unit_or_zero(light.axis), settings.resolution);
            view.right *= half_side;
            view.down *= half_side;
            add_perspective(view, z_near);
        }
        add_cube(light.position, settings.resolution, z_near);
    }

    void add_views(const RectLight& light, const ShadowMapSettings& settings, const std::string& name) {
        add_cube(light.position, settings.resolution, near_plane(settings, name));
    }

    void add_views(const DirectionalLight& light, const ShadowMapSettings& settings,
                   const std::string& name) {
        if (!settings.scene_bounds)
            throw std::invalid_argument("lightmesh: " + name +
                                        " is directional, and its shadow map needs the bounds of the scene: "
                                        "give them by the settings, or the "
                                        "DepthRenderer a member `lightmesh::Bounds bounds() const`");
        const Bounds& box = *settings.scene_bounds;
        const glm::vec3 half = 0.5f * (box.high - box.low);
        const float slack = glm::length(half) * 0x1p-8f;
        DepthView view =
            view_along(0.5f * (box.low + box.high), unit_or_zero(light.direction), settings.resolution);
        const auto extent = [&](const glm::vec3& axis) {
            return glm::dot(glm::abs(axis), half) + slack;
        };
        const float depth = extent(view.forward);
        const auto texels = static_cast<float>(settings.resolution);
        view.right *= extent(view.right) * (texels + 2.0f) / texels;
        view.down *= extent(view.down) * (texels + 2.0f) / texels;
        view.eye -= (depth + slack) * view.forward;
        view.z_near = slack;
        view.z_far = slack + 2.0f * depth;
        view.orthographic = true;
        views_.push_back(view);
    }

    static float near_plane(const ShadowMapSettings& settings, const std::string& name) {
        if (!settings.z_near && !settings.scene_bounds)
            throw std::invalid_argument("lightmesh: " + name +
                                        ": shadow map's z_near is not set; it must be, unless the bounds of "
                                        "the scene are given");
        const float z_near =
            settings.z_near
                ? *settings.z_near
                : 0x1p-20f * glm::length(settings.scene_bounds->high - settings.scene_bounds->low);
        require(z_near > 0.0f && z_near <= 0x1p80f, name + ": shadow map's z_near", z_near, "in (0, 2^80]");
        return z_near;
    }

    void add_cube(const glm::vec3& position, int resolution, float z_near) {
        cube_ = static_cast<int>(views_.size());
        for (std::size_t face = 0; face < cube_face_count; ++face)
            add_perspective(view_along(position, cube_face_axis(face), resolution), z_near);
    }

    void add_perspective(DepthView view, float z_near) {
        view.z_near = z_near;
        view.z_far =
            z_near * 0x1p40f;  // reversed float depth: a far plane beyond everything costs no precision
        views_.push_back(view);
    }

    static float texel_side(const DepthView& view) {
        const float half = (std::max)(glm::length(view.right), glm::length(view.down));
        return 2.0f * half / static_cast<float>(view.resolution);
    }

    /// View, column and row for a direction from the light, of any length.
    TexelCoord locate_direction(const glm::vec3& direction) const {
        if (has_cone_view_) {
            const DepthView& view = views_.front();
            const float z = glm::dot(view.forward, direction);
            const float x = glm::dot(view.right, direction) / glm::dot(view.right, view.right);
            const float y = glm::dot(view.down, direction) / glm::dot(view.down, view.down);
            if ((std::max)(std::abs(x), std::abs(y)) <= cone_edge_ * z)
                return at(0, x, y, z);
        }
        const std::size_t face = cube_face_of(direction);
        const int shown_in = cube_ + static_cast<int>(face);
        const DepthView& view = views_[static_cast<std::size_t>(shown_in)];
        return at(shown_in, glm::dot(view.right, direction), glm::dot(view.down, direction),
                  std::abs(direction[static_cast<int>(face / 2)]));
    }

    TexelCoord at(int view, float x, float y, float z) const {
        const auto half = 0.5f * static_cast<float>(views_.front().resolution);
        TexelCoord coord;
        coord.view = view;
        coord.column = z > 0.0f ? half + half * (x / z) : half;
        coord.row = z > 0.0f ? half + half * (y / z) : half;
        return coord;
    }

    TexelCoord locate_parallel(const glm::vec3& point) const {
        const DepthView& view = views_.front();
        const glm::vec3 to_point = point - view.eye;
        const float x = glm::dot(view.right, to_point) / glm::dot(view.right, view.right);
        const float y = glm::dot(view.down, to_point) / glm::dot(view.down, view.down);
        if (!(std::abs(x) <= 1.0f && std::abs(y) <= 1.0f))
            return {};
        TexelCoord coord = at(0, x, y, 1.0f);
        coord.distance = glm::dot(view.forward, to_point);
        coord.absolute_texel = texel_side(view);
        return coord;
    }

    std::vector<DepthView> views_;
    int cube_ = 0;  // the first of its six faces
    bool has_cone_view_ = false;
    float cone_edge_ = 1.0f;
};

}  // namespace detail
}  // namespace lightmesh
