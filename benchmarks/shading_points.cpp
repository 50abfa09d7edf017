// SPDX-License-Identifier: MIT
#include "shading_points.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace bench {

namespace {

/// Every second bit of `code`: the column of a place on the Z curve; the row is that of code >> 1.
int every_second_bit(std::size_t code) {
    int result = 0;
    for (int bit = 0; bit < 16; ++bit)
        result |= static_cast<int>(code >> (2 * bit) & 1u) << bit;
    return result;
}

/// Rays through the middles of pixels.
class View {
public:
    View(const demo::Camera& camera, int width, int height)
        : eye_(camera.eye), forward_(glm::normalize(camera.target - camera.eye)) {
        const float half_height = std::tan(0.5f * camera.vertical_field_of_view);
        const glm::vec3 right = glm::normalize(glm::cross(forward_, camera.up));
        pixel_ = 2.0f * half_height / static_cast<float>(height);
        right_ = pixel_ * right;
        down_ = -pixel_ * glm::cross(right, forward_);
        middle_x_ = 0.5f * static_cast<float>(width - 1);
        middle_y_ = 0.5f * static_cast<float>(height - 1);
    }

    const glm::vec3& eye() const { return eye_; }
    glm::vec3 through(int column, int row) const {
        return glm::normalize(forward_ + (static_cast<float>(column) - middle_x_) * right_ +
                              (static_cast<float>(row) - middle_y_) * down_);
    }

private:
    glm::vec3 eye_, forward_, right_, down_;
    float pixel_, middle_x_, middle_y_;
};

}  // namespace

ShadingPoints::ShadingPoints(const demo::EmbreeScene& scene, int width, int height) {
    const View view(scene.scene().camera, width, height);
    for (int top = 0; top < height; top += tile_side) {
        for (int left = 0; left < width; left += tile_side) {
            for (std::size_t i = 0; i < most_in_tile; ++i) {
                const int column = left + every_second_bit(i);
                const int row = top + every_second_bit(i >> 1);
                if (const auto hit = scene.trace(view.eye(), view.through(column, row))) {
                    positions_.push_back(hit->position);
                    normals_.push_back(hit->geometric_normal);
                }
            }
            if (positions_.size() > first_.back())
                first_.push_back(positions_.size());
        }
    }
}

void ShadingPoints::add_tile(const Points& points, std::size_t step) {
    for (std::size_t i = 0; i < points.size(); i += step) {
        positions_.push_back(points.positions[i]);
        normals_.push_back(points.normals[i]);
    }
    first_.push_back(positions_.size());
}

ShadingPoints ShadingPoints::part(std::size_t points) const {
    const std::size_t wanted = (points * tile_count() + size() - 1) / size();
    return evenly(wanted, 1);
}

ShadingPoints ShadingPoints::sample(std::size_t tiles) const {
    return evenly(tiles, 16);
}

ShadingPoints ShadingPoints::evenly(std::size_t tiles, std::size_t step) const {
    tiles = std::clamp(tiles, std::size_t{1}, tile_count());
    // Steps of the golden ratio do not fall in step with the rows of the picture.
    constexpr double golden = 0.6180339887498949;
    std::vector<std::size_t> chosen;
    std::vector<bool> is_chosen(tile_count(), false);
    for (std::size_t k = 0; chosen.size() < tiles; ++k) {
        const double share = static_cast<double>(k) * golden;
        const auto i =
            static_cast<std::size_t>((share - std::floor(share)) * static_cast<double>(tile_count()));
        if (!is_chosen[i])
            chosen.push_back(i);
        is_chosen[i] = true;
    }
    std::ranges::sort(chosen);
    ShadingPoints result;
    for (const std::size_t i : chosen)
        result.add_tile(tile(i), step);
    return result;
}

}  // namespace bench
