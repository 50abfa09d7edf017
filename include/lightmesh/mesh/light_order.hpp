// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/light_shape.hpp>
#include <lightmesh/support/vectors.hpp>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// The place that a light shines from, and its range; nothing for a light without a range, which shines
/// everywhere.
struct LightBall {
    glm::vec3 centre{0.0f};
    float range = std::numeric_limits<float>::infinity();
    bool is_bounded() const { return std::isfinite(range); }
};

inline LightBall ball_of(const LightShape& shape) {
    return shape.is_directional ? LightBall{} : LightBall{shape.at, shape.range};
}

/// A box around all that some lights can reach, by their ranges.
struct ReachBox {
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};

    void include(const LightBall& ball) {
        // Wider by some roundings, so that no point is left out that is in range.
        const float range = 1.00001f * ball.range + 1e-6f * largest_component(ball.centre);
        low = (glm::min)(low, ball.centre - range);
        high = (glm::max)(high, ball.centre + range);
    }

    bool holds(const glm::vec3& point) const {
        return (point.x >= low.x) & (point.y >= low.y) & (point.z >= low.z) & (point.x <= high.x) &
               (point.y <= high.y) & (point.z <= high.z);
    }
};

/// The order in which a mesh keeps its lights. Those with a range stand behind all others and along a Morton
/// curve, so that lights next to each other in memory are so in space: what few of them reach is told from
/// the box around them all.
class LightOrder {
public:
    /// The lights must be finite.
    explicit LightOrder(std::span<const LightShape> lights) {
        const auto is_bounded = [](const LightShape& light) {
            return ball_of(light).is_bounded();
        };
        if (!std::ranges::any_of(lights, is_bounded))
            return;
        glm::vec3 low((std::numeric_limits<float>::max)());
        glm::vec3 high(std::numeric_limits<float>::lowest());
        for (const LightShape& light : lights) {
            if (is_bounded(light)) {
                low = (glm::min)(low, ball_of(light).centre);
                high = (glm::max)(high, ball_of(light).centre);
            }
        }
        std::vector<std::uint32_t> codes;
        for (const LightShape& light : lights)
            codes.push_back(is_bounded(light) ? 1 + morton_code(ball_of(light).centre, low, high) : 0);
        light_at_.resize(lights.size());
        for (std::size_t light = 0; light < lights.size(); ++light)
            light_at_[light] = light;
        std::ranges::stable_sort(light_at_, {}, [&](std::size_t light) { return codes[light]; });
        slot_of_.resize(lights.size());
        for (std::size_t slot = 0; slot < lights.size(); ++slot)
            slot_of_[light_at_[slot]] = slot;
    }

    bool operator==(const LightOrder&) const = default;

    /// True if the order is the user's own.
    bool is_given() const { return light_at_.empty(); }
    std::size_t light_at(std::size_t slot) const { return is_given() ? slot : light_at_[slot]; }
    std::size_t slot_of(std::size_t light) const { return is_given() ? light : slot_of_[light]; }
    std::size_t bytes() const { return (light_at_.capacity() + slot_of_.capacity()) * sizeof(std::size_t); }

private:
    /// 10 bits an axis, x first, of the place in the box.
    static std::uint32_t morton_code(const glm::vec3& point, const glm::vec3& low, const glm::vec3& high) {
        std::uint32_t code = 0;
        for (int axis = 0; axis < 3; ++axis) {
            // In double: the sides of a box of floats may be greater than any float.
            const double side = static_cast<double>(high[axis]) - static_cast<double>(low[axis]);
            const double from_low = static_cast<double>(point[axis]) - static_cast<double>(low[axis]);
            const auto step = static_cast<std::uint32_t>(side > 0.0 ? from_low / side * 1023.0 : 0.0);
            for (int bit = 0; bit < 10; ++bit)
                code |= (step >> bit & 1u) << (3 * bit + axis);
        }
        return code;
    }

    std::vector<std::size_t> light_at_;
    std::vector<std::size_t> slot_of_;
};

}  // namespace lightmesh::detail
