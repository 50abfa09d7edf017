// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/light_mesh.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/tune/subject.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// The number of light points that a set of surface points touches, found without a ray of the user's.

namespace lightmesh::tune::detail {

/// A tracer for which nothing is in the way.
struct OpenSpace {
    bool occluded(const Segment&) const { return false; }
    void occluded(std::span<const Segment>, std::span<std::uint8_t> hit) const {
        std::ranges::fill(hit, std::uint8_t{0});
    }
};

/// The growth of light points with surface points: n points touch max * n / (n + half) of them. Points far
/// from each other have light points of their own (n much smaller than half); the more there are, the more
/// they share.
class Growth {
public:
    /// From the light points that `points` surface points touch, and an even half of them.
    Growth(std::size_t points, std::size_t touched_by_half, std::size_t touched) {
        const double ratio =
            touched_by_half == 0 ? 2.0 : static_cast<double>(touched) / static_cast<double>(touched_by_half);
        const auto n = static_cast<double>(points);
        is_linear_ = ratio >= 1.999;
        half_ = is_linear_ ? 0.0 : n * (std::max)(ratio - 1.0, 0.0) / (2.0 - ratio);
    }

    /// By which factor light points grow from `few` surface points to `many`.
    double factor(std::size_t few, std::size_t many) const {
        const auto a = static_cast<double>(few);
        const auto b = static_cast<double>(many);
        if (is_linear_)
            return b / a;
        return b / (b + half_) * (a + half_) / a;
    }

private:
    bool is_linear_;
    double half_;
};

/// The contents of a mesh without short test and without occluders.
struct DryRun {
    std::size_t light_points = 0;
    std::size_t bytes = 0;
    std::size_t light_points_of_half = 0;  ///< of every second block
};

/// Queries all points, every second block of them first.
inline DryRun dry_run(std::span<const Light> lights, std::span<const glm::vec3> points,
                      std::span<const glm::vec3> normals, const Settings& settings) {
    Settings open = settings;
    open.short_test = ShortTest::none;
    const LightMesh mesh{OpenSpace{}, lights, open};
    std::vector<float> values(block_size * lights.size());
    const std::size_t count = points.size();
    const auto query_from = [&](std::size_t first_block) {
        for (std::size_t i = first_block * block_size; i < count; i += 2 * block_size) {
            const std::size_t size = (std::min)(block_size, count - i);
            mesh.visibility(points.subspan(i, size), normals.subspan(i, size),
                            std::span(values).first(size * lights.size()));
        }
    };
    query_from(0);
    const std::size_t half = mesh.statistics().light_points;
    query_from(1);
    const MeshStatistics all = mesh.statistics();
    return {all.light_points, all.bytes, half};
}

/// By which factor light points grow from the samples to a frame: counted where the samples have all points
/// of one, else as max * n / (n + half).
inline double frame_growth(std::span<const Light> lights, const Samples& samples, const Settings& settings) {
    const DryRun few = dry_run(lights, samples.points, samples.normals, settings);
    if (samples.frame_points.empty())
        return Growth(samples.points.size(), few.light_points_of_half, few.light_points)
            .factor(samples.points.size(), samples.points_per_frame);
    const DryRun all = dry_run(lights, samples.frame_points, samples.frame_normals, settings);
    return few.light_points == 0
               ? 1.0
               : static_cast<double>(all.light_points) / static_cast<double>(few.light_points);
}

}  // namespace lightmesh::tune::detail
