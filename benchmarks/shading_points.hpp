// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"

#include <glm/vec3.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace bench {

/// Surface points with the geometric unit normals on their shaded sides.
struct Points {
    std::span<const glm::vec3> positions;
    std::span<const glm::vec3> normals;

    std::size_t size() const { return positions.size(); }
};

/// What a renderer shades first: where the rays through the middles of a picture's pixels meet the scene.
/// Tile by tile of 16x16 pixels, as renderers do, and in a tile along a Z curve, so that neighbours in the
/// list are neighbours in the picture: packets of rays gain most by that. Pixels of the sky are left out.
class ShadingPoints {
public:
    static constexpr int tile_side = 16;
    static constexpr std::size_t most_in_tile = tile_side * tile_side;

    /// The scene's own view. Both sides must be multiples of `tile_side`.
    ShadingPoints(const demo::EmbreeScene& scene, int width, int height);

    std::size_t size() const { return positions_.size(); }
    std::size_t tile_count() const { return first_.size() - 1; }
    Points tile(std::size_t i) const {
        return {std::span(positions_).subspan(first_[i], first_[i + 1] - first_[i]),
                std::span(normals_).subspan(first_[i], first_[i + 1] - first_[i])};
    }

    /// Whole tiles, evenly spread over the picture, with about `points` points: what is slow is timed on
    /// fewer.
    ShadingPoints part(std::size_t points) const;
    /// About `tiles` tiles, of which each keeps every 16th point: to check results.
    ShadingPoints sample(std::size_t tiles) const;

private:
    ShadingPoints() = default;
    void add_tile(const Points& points, std::size_t step);
    ShadingPoints evenly(std::size_t tiles, std::size_t step) const;

    std::vector<glm::vec3> positions_;
    std::vector<glm::vec3> normals_;
    std::vector<std::size_t> first_{0};
};

}  // namespace bench
