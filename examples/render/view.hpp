// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.hpp"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <cmath>

namespace demo {

/// Rays through the pixels of a picture.
class View {
public:
    View(const Camera& camera, int width, int height) : width_(width), height_(height), eye_(camera.eye) {
        forward_ = glm::normalize(camera.target - camera.eye);
        const glm::vec3 right = glm::normalize(glm::cross(forward_, camera.up));
        is_orthographic_ = camera.orthographic_height > 0.0f;
        const glm::vec3 up = glm::cross(right, forward_);
        const glm::vec4& edges = camera.edges;
        if (edges != glm::vec4(0.0f)) {
            middle_ = 0.5f * ((edges[0] + edges[1]) * right + (edges[2] + edges[3]) * up);
            right_ = 0.5f * (edges[1] - edges[0]) * right;
            up_ = 0.5f * (edges[3] - edges[2]) * up;
            pixel_ = (edges[3] - edges[2]) / static_cast<float>(height);
            return;
        }
        const float half = is_orthographic_ ? 0.5f * camera.orthographic_height
                                            : std::tan(0.5f * camera.vertical_field_of_view);
        pixel_ = 2.0f * half / static_cast<float>(height);
        right_ = right * (half * static_cast<float>(width) / static_cast<float>(height));
        up_ = up * half;
    }

    // (column, row) in pixels, row 0 on top.

    glm::vec3 origin(float column, float row) const {
        return is_orthographic_ ? eye_ + aside(column, row) : eye_;
    }
    glm::vec3 direction(float column, float row) const {
        return is_orthographic_ ? forward_ : glm::normalize(forward_ + aside(column, row));
    }

    /// The distance along a ray of that direction for each unit along the view.
    float stretch(const glm::vec3& direction) const { return 1.0f / glm::dot(direction, forward_); }

    /// The width of a pixel at the eye, world units, and by how much it widens with each unit of distance.
    float pixel_width() const { return is_orthographic_ ? pixel_ : 0.0f; }
    float pixel_angle() const { return is_orthographic_ ? 0.0f : pixel_; }

    /// For shaders: the eye, the view's direction, and beside that the middle, the right half and the upper
    /// half of the picture.
    struct Axes {
        glm::vec3 eye, forward, middle, right, up;
        bool is_orthographic;
    };
    Axes axes() const { return {eye_, forward_, middle_, right_, up_, is_orthographic_}; }

private:
    glm::vec3 aside(float column, float row) const {
        const float x = 2.0f * column / static_cast<float>(width_) - 1.0f;
        const float y = 1.0f - 2.0f * row / static_cast<float>(height_);
        return middle_ + x * right_ + y * up_;
    }

    bool is_orthographic_;
    float pixel_;
    int width_;
    int height_;
    glm::vec3 eye_;
    glm::vec3 forward_;
    glm::vec3 middle_{0.0f};
    glm::vec3 right_;
    glm::vec3 up_;
};

}  // namespace demo
