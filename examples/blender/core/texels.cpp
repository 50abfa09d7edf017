// SPDX-License-Identifier: MIT
#include "blender/core/texels.hpp"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace demo {

namespace {

constexpr std::int64_t steps = 256;  // to a texel
constexpr double farthest = 0x1p20;  // texels

/// A place in steps: sums of products of these are exact.
struct Place {
    std::int64_t x, y;
};

/// Twice the area of a triangle, above 0 for those that go round against the clock.
std::int64_t area(const Place& a, const Place& b, const Place& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double area(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// A triangle in texels, against the clock.
class Flat {
public:
    /// `corners` may go round either way.
    explicit Flat(const std::array<glm::dvec2, 3>& corners) : corners_(corners) {
        for (std::size_t k = 0; k < 3; ++k)
            rounded_[k] = {std::llround(corners[k].x * steps), std::llround(corners[k].y * steps)};
        if (area(rounded_[0], rounded_[1], rounded_[2]) < 0)
            std::swap(rounded_[1], rounded_[2]);
    }

    /// True if a texel's middle lies inside. One on the edge of two triangles that lie side by side is in one
    /// of them: that to the right of the edge, or above it.
    bool has_middle(int column, int row) const {
        const Place middle{column * steps + steps / 2, row * steps + steps / 2};
        for (std::size_t k = 0; k < 3; ++k) {
            const Place& from = rounded_[k];
            const Place& to = rounded_[(k + 1) % 3];
            const std::int64_t side = area(from, to, middle);
            const bool owns_edge = to.y < from.y || (to.y == from.y && to.x > from.x);
            if (side < 0 || (side == 0 && !owns_edge))
                return false;
        }
        return area(rounded_[0], rounded_[1], rounded_[2]) > 0;
    }

    /// The columns that the triangle touches in a row; the second less than the first: none.
    std::array<double, 2> columns(int row) const {
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        const auto take = [&](double x) {
            low = (std::min)(low, x);
            high = (std::max)(high, x);
        };
        const double bottom = row;
        const double top = bottom + 1.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec2& a = corners_[k];
            const glm::dvec2& b = corners_[(k + 1) % 3];
            if (a.y >= bottom && a.y <= top)
                take(a.x);
            for (const double y : {bottom, top})
                if ((a.y < y) != (b.y < y))
                    take(glm::mix(a.x, b.x, (y - a.y) / (b.y - a.y)));
        }
        return low <= high ? std::array{std::floor(low), std::floor(high)} : std::array{0.0, -1.0};
    }

    /// The weights of the second and third corner where the triangle is nearest to a place.
    glm::dvec2 nearest(const glm::dvec2& place) const {
        const auto& [a, b, c] = corners_;
        const double all = area(a, b, c);
        const glm::dvec2 inside(area(a, place, c) / all, area(a, b, place) / all);
        if (inside.x >= 0.0 && inside.y >= 0.0 && inside.x + inside.y <= 1.0)
            return inside;
        glm::dvec2 best(0.0);
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec2 edge = corners_[(k + 1) % 3] - corners_[k];
            const double length = glm::dot(edge, edge);
            const double along =
                length > 0.0 ? glm::clamp(glm::dot(place - corners_[k], edge) / length, 0.0, 1.0) : 0.0;
            const double distance = glm::distance(place, corners_[k] + along * edge);
            if (distance < least) {
                least = distance;
                std::array<double, 3> weights{};
                weights[k] = 1.0 - along;
                weights[(k + 1) % 3] = along;
                best = {weights[1], weights[2]};
            }
        }
        return best;
    }

    /// The same by a quarter of a texel farther inside: exactly at an edge other surfaces often touch, and
    /// hide all lights.
    glm::dvec2 inside(const glm::dvec2& weights) const {
        constexpr glm::dvec2 centre(1.0 / 3.0);
        const double length = glm::distance(at(weights), at(centre));
        return glm::mix(weights, centre, length > 0.25 ? 0.25 / length : 1.0);
    }

    glm::dvec2 at(const glm::dvec2& weights) const {
        return (1.0 - weights.x - weights.y) * corners_[0] + weights.x * corners_[1] +
               weights.y * corners_[2];
    }

    const std::array<glm::dvec2, 3>& corners() const { return corners_; }

private:
    std::array<glm::dvec2, 3> corners_;
    std::array<Place, 3> rounded_;
};

/// Looks at the texels that triangles touch, one triangle after the other.
class Coverer {
public:
    explicit Coverer(const CoveredTexels& texels)
        : texels_(texels), distances_(texels.triangles.size(), std::numeric_limits<float>::infinity()) {
        std::ranges::fill(texels.triangles, -1);
        std::ranges::fill(texels.others, -1);
        std::ranges::fill(texels.weights, 0.0f);
    }

    void cover(std::int32_t number, const Flat& flat) {
        const auto& [a, b, c] = flat.corners();
        const glm::dvec2 low = glm::floor(glm::min(glm::min(a, b), c));
        const glm::dvec2 high = glm::floor(glm::max(glm::max(a, b), c));
        const int first = static_cast<int>((std::max)(low.y, 0.0));
        const int last = static_cast<int>((std::min)(high.y, texels_.height - 1.0));
        for (int row = first; row <= last; ++row) {
            const auto [left, right] = flat.columns(row);
            const double end = (std::min)(right, texels_.width - 1.0);
            for (int column = static_cast<int>((std::max)(left, 0.0)); column <= end; ++column)
                cover(number, flat, column, row);
        }
    }

private:
    void cover(std::int32_t number, const Flat& flat, int column, int row) {
        const auto texel = static_cast<std::size_t>(row) * static_cast<std::size_t>(texels_.width) +
                           static_cast<std::size_t>(column);
        const bool has_middle = flat.has_middle(column, row);
        float& distance = distances_[texel];
        if (distance == has_it) {
            if (has_middle)
                texels_.others[texel] = number;
            return;
        }
        const glm::dvec2 middle(column + 0.5, row + 0.5);
        glm::dvec2 weights = flat.nearest(middle);
        const float away = has_middle ? has_it : static_cast<float>(glm::distance(flat.at(weights), middle));
        if (!(away < distance))
            return;
        distance = away;
        if (!has_middle)
            weights = flat.inside(weights);
        texels_.triangles[texel] = number;
        texels_.weights[2 * texel] = static_cast<float>(weights.x);
        texels_.weights[2 * texel + 1] = static_cast<float>(weights.y);
    }

    static constexpr float has_it = -1.0f;  // less than the distance of any that only touches

    CoveredTexels texels_;
    std::vector<float> distances_;  ///< of each texel's middle from its triangle
};

}  // namespace

void cover_texels(std::span<const float> uvs, const CoveredTexels& texels) {
    Coverer coverer(texels);
    const glm::dvec2 size(texels.width, texels.height);
    for (std::size_t t = 0; t < uvs.size() / 6; ++t) {
        std::array<glm::dvec2, 3> corners;
        bool is_near = true;
        for (std::size_t k = 0; k < 3; ++k) {
            corners[k] = size * glm::dvec2(uvs[6 * t + 2 * k], uvs[6 * t + 2 * k + 1]);
            is_near = is_near && std::abs(corners[k].x) <= farthest && std::abs(corners[k].y) <= farthest;
        }
        if (is_near && area(corners[0], corners[1], corners[2]) != 0.0)
            coverer.cover(static_cast<std::int32_t>(t), Flat(corners));
    }
}

void fill_margin(int width, int height, int channels, std::span<float> values, std::span<std::uint8_t> filled,
                 int margin) {
    const auto depth = static_cast<std::size_t>(channels);
    const auto texel_at = [width](int column, int row) {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(column);
    };
    const auto each_neighbour = [&](std::size_t texel, const auto& function) {
        const int column = static_cast<int>(texel % static_cast<std::size_t>(width));
        const int row = static_cast<int>(texel / static_cast<std::size_t>(width));
        for (int up = -1; up <= 1; ++up)
            for (int right = -1; right <= 1; ++right) {
                const int x = column + right;
                const int y = row + up;
                if ((up != 0 || right != 0) && x >= 0 && x < width && y >= 0 && y < height)
                    function(texel_at(x, y), up == 0 || right == 0 ? 2.0f : 1.0f);
            }
    };
    std::vector<std::size_t> edge;  // filled texels that may have neighbours that are not
    for (std::size_t texel = 0; texel < filled.size(); ++texel)
        if (filled[texel] != 0)
            edge.push_back(texel);
    for (int step = 0; step < margin && !edge.empty(); ++step) {
        constexpr std::uint8_t next = 2;  // is filled by this step
        std::vector<std::size_t> reached;
        for (const std::size_t texel : edge)
            each_neighbour(texel, [&](std::size_t other, float) {
                if (filled[other] == 0) {
                    filled[other] = next;
                    reached.push_back(other);
                }
            });
        for (const std::size_t texel : reached) {
            const std::span<float> mean = values.subspan(texel * depth, depth);
            std::ranges::fill(mean, 0.0f);
            float weights = 0.0f;
            each_neighbour(texel, [&](std::size_t other, float weight) {
                if (filled[other] != 1)
                    return;
                weights += weight;
                for (std::size_t channel = 0; channel < depth; ++channel)
                    mean[channel] += weight * values[other * depth + channel];
            });
            for (float& value : mean)
                value /= weights;
        }
        for (const std::size_t texel : reached)
            filled[texel] = 1;
        edge = std::move(reached);
    }
}

}  // namespace demo
