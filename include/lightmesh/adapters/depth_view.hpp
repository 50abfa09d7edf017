// SPDX-License-Identifier: MIT
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <limits>

namespace lightmesh {

/// The ray by which a ray tracer finds the distance of one texel: the first surface on origin + t *
/// direction, t >= 0. The direction has length 1, so that t is the distance that is asked for.
struct DepthRay {
    glm::vec3 origin;     ///< world units
    glm::vec3 direction;  ///< of length 1
};

/// One square picture that a `DepthRenderer` is asked for: what a light sees.
///
/// A rasteriser takes `clip_from_world` and turns its depths into distances by `distance`; a ray tracer takes
/// `ray`. World units throughout.
///
/// Clip space is that of Vulkan: x to the right, y down (row 0 of the picture is at y = -w, on top), and
/// depth reversed: 1 at z_near, 0 at z_far, so that a 32 bit float depth buffer keeps its precision at any
/// distance (cleared to 0, compared by "greater"). Everything in the scene counts, whichever side of it is
/// seen: no culling.
struct DepthView {
    /// The light, or for an orthographic view the centre of the plane that distances are measured from.
    glm::vec3 eye{0.0f};
    /// clip = clip_from_world * vec4(world, 1), column vectors. Built by hand: it does not depend on GLM's
    /// macros.
    glm::mat4 clip_from_world{1.0f};
    /// Rows, and texels in each row: 1..16384.
    int resolution = 1;
    /// The least distance at which something throws a shadow. World units along `forward`; finite, greater
    /// than 0.
    float z_near = 1.0f;
    /// The greatest distance at which something throws a shadow. World units along `forward`; finite, greater
    /// than `z_near`.
    float z_far = 2.0f;

    /// Parallel rays (a directional light) instead of rays through the eye.
    bool orthographic = false;
    /// From the centre of the picture to its right edge: at distance 1 along `forward`, or anywhere in an
    /// orthographic view. World units; perpendicular to `down` and `forward`.
    glm::vec3 right{1.0f, 0.0f, 0.0f};
    /// The same to its lower edge.
    glm::vec3 down{0.0f, 1.0f, 0.0f};
    /// Into the picture, of length 1; right, down and forward are right-handed.
    glm::vec3 forward{0.0f, 0.0f, 1.0f};

    /// The point at distance 1 along `forward`, relative to the eye, that lies in the centre of a texel.
    /// Column and row may lie outside of the picture.
    glm::vec3 offset(int column, int row) const {
        const float scale = 2.0f / static_cast<float>(resolution);
        const float x = (static_cast<float>(column) + 0.5f) * scale - 1.0f;
        const float y = (static_cast<float>(row) + 0.5f) * scale - 1.0f;
        return forward + x * right + y * down;
    }

    /// The ray through the centre of a texel. It starts at the eye, or on the plane of the eye; what lies
    /// nearer than z_near does not count.
    DepthRay ray(int column, int row) const {
        const glm::vec3 texel = offset(column, row);
        if (orthographic)
            return {eye + (texel - forward), forward};
        return {eye, glm::normalize(texel)};
    }

    /// clip_from_world for positions relative to the eye: clip = clip_from_eye() * vec4(world - eye, 1). The
    /// more precise way for a light far from the origin.
    glm::mat4 clip_from_eye() const;

    /// The distance that belongs to a value of the depth buffer: +infinity for 0, which is nothing.
    float distance(int column, int row, float depth) const {
        if (!(depth > 0.0f))
            return std::numeric_limits<float>::infinity();
        if (orthographic)
            return z_far - depth * (z_far - z_near);
        const float ratio = z_near / z_far;
        const float z = z_near / (ratio + depth * (1.0f - ratio));
        return z * glm::length(offset(column, row));
    }
};

namespace detail {

/// The matrix that belongs to the other members of a view, for positions relative to `origin`.
inline glm::mat4 clip_matrix(const DepthView& view, const glm::dvec3& origin) {
    const glm::dvec3 eye = glm::dvec3(view.eye) - origin;
    const glm::dvec3 right =
        glm::dvec3(view.right) / glm::dot(glm::dvec3(view.right), glm::dvec3(view.right));
    const glm::dvec3 down = glm::dvec3(view.down) / glm::dot(glm::dvec3(view.down), glm::dvec3(view.down));
    const glm::dvec3 forward(view.forward);
    const double z_near = static_cast<double>(view.z_near);
    const double z_far = static_cast<double>(view.z_far);
    const double scale = 1.0 / (z_far - z_near);
    const glm::dvec3 depth = -forward * (view.orthographic ? scale : z_near * scale);
    const double depth_at_eye = view.orthographic ? z_far * scale : z_near * z_far * scale;

    const auto row = [&](const glm::dvec3& axis, double at_eye) {
        return glm::dvec4(axis, at_eye - glm::dot(axis, eye));
    };
    const glm::dvec4 w = view.orthographic ? glm::dvec4(0.0, 0.0, 0.0, 1.0) : row(forward, 0.0);
    const glm::dvec4 rows[4] = {row(right, 0.0), row(down, 0.0), row(depth, depth_at_eye), w};
    glm::mat4 matrix(0.0f);
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c)
            matrix[c][r] = static_cast<float>(rows[r][c]);
    return matrix;
}

}  // namespace detail

inline glm::mat4 DepthView::clip_from_eye() const {
    return detail::clip_matrix(*this, glm::dvec3(eye));
}

}  // namespace lightmesh
