// SPDX-License-Identifier: MIT
#include "tune/sampling.hpp"

#include "render/terminal.hpp"

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <span>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace demo {

namespace {

constexpr std::size_t run_length = 64;

/// The points of one query, which follow each other in the picture, and a random number to choose them by.
struct Tile {
    std::uint32_t seed;
    std::vector<lightmesh::SurfacePoint> points;

    /// Of the run that is a sample.
    std::size_t run_size() const { return (std::min)(points.size(), run_length); }
    std::size_t run_start() const { return seed % (points.size() - run_size() + 1); }
    std::span<const lightmesh::SurfacePoint> run() const {
        return std::span(points).subspan(run_start(), run_size());
    }
};

/// Lets everything be lit, and keeps all points.
class Recorder final : public Visibility {
public:
    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost&) const override {
        std::ranges::fill(lit, 1.0f);
        if (points.points.empty())
            return;
        Tile tile{points.seeds.front(), {points.points.begin(), points.points.end()}};
        const std::lock_guard lock(mutex_);
        tiles_.push_back(std::move(tile));
    }

    void update(const EmbreeScene&, const SceneChange&) override {}

    /// Full runs before shorter ones, and random ones before others: in an order that no thread had a say in.
    std::vector<Tile> take_sorted() {
        const auto place = [](const Tile& tile) {
            return tile.points.front().position;
        };
        std::ranges::sort(tiles_, [&](const Tile& a, const Tile& b) {
            return std::tuple(b.run_size(), a.seed, place(a).x, place(a).y) <
                   std::tuple(a.run_size(), b.seed, place(b).x, place(b).y);
        });
        return std::move(tiles_);
    }

private:
    mutable std::mutex mutex_;
    mutable std::vector<Tile> tiles_;
};

struct Columns {
    std::vector<glm::vec3>& positions;
    std::vector<glm::vec3>& normals;
    std::vector<float>& footprints;

    void append(std::span<const lightmesh::SurfacePoint> points) const {
        for (const lightmesh::SurfacePoint& point : points) {
            positions.push_back(point.position);
            normals.push_back(point.normal);
            footprints.push_back(point.footprint);
        }
    }
};

}  // namespace

ShadingPoints sample_shading_points(const EmbreeScene& scene, const RenderOptions& options,
                                    std::size_t count) {
    Recorder recorder;
    RenderStatistics statistics;
    render(scene, recorder, options, statistics, {}, &interrupted());
    if (!statistics.finished)
        throw std::runtime_error("interrupted");
    ShadingPoints samples;
    const Columns all{samples.all_positions, samples.all_normals, samples.all_footprints};
    const Columns some{samples.positions, samples.normals, samples.footprints};
    for (const Tile& tile : recorder.take_sorted()) {
        all.append(tile.points);
        if (samples.positions.size() < count)
            some.append(tile.run());
    }
    if (samples.positions.empty())
        throw std::runtime_error("the camera sees no surface of the scene");
    return samples;
}

}  // namespace demo
