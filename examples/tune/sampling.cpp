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
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<float> footprints;

    /// Of the run that is a sample.
    std::size_t run_size() const { return (std::min)(positions.size(), run_length); }
    std::size_t run_start() const { return seed % (positions.size() - run_size() + 1); }
};

/// Lets everything be lit, and keeps all points.
class Recorder final : public Visibility {
public:
    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost&) const override {
        std::ranges::fill(lit, 1.0f);
        if (points.positions.empty())
            return;
        Tile tile{points.seeds.front(),
                  {points.positions.begin(), points.positions.end()},
                  {points.normals.begin(), points.normals.end()},
                  {points.footprints.begin(), points.footprints.end()}};
        const std::lock_guard lock(mutex_);
        tiles_.push_back(std::move(tile));
    }

    void update(const EmbreeScene&, const SceneChange&) override {}

    /// Full runs before shorter ones, and random ones before others: in an order that no thread had a say in.
    std::vector<Tile> take_sorted() {
        std::ranges::sort(tiles_, [](const Tile& a, const Tile& b) {
            return std::tuple(b.run_size(), a.seed, a.positions.front().x, a.positions.front().y) <
                   std::tuple(a.run_size(), b.seed, b.positions.front().x, b.positions.front().y);
        });
        return std::move(tiles_);
    }

private:
    mutable std::mutex mutex_;
    mutable std::vector<Tile> tiles_;
};

/// Adds `size` values from the `first` on.
template <class Value>
void append(const std::vector<Value>& from, std::size_t first, std::size_t size, std::vector<Value>& to) {
    const auto start = from.begin() + static_cast<std::ptrdiff_t>(first);
    to.insert(to.end(), start, start + static_cast<std::ptrdiff_t>(size));
}

}  // namespace

ShadingPoints sample_shading_points(const EmbreeScene& scene, const RenderOptions& options,
                                    std::size_t count) {
    Recorder recorder;
    RenderStatistics statistics;
    render(scene, recorder, options, statistics, {}, &interrupted());
    if (!statistics.finished)
        throw std::runtime_error("interrupted");
    ShadingPoints samples;
    for (const Tile& tile : recorder.take_sorted()) {
        const std::size_t all = tile.positions.size();
        append(tile.positions, 0, all, samples.all_positions);
        append(tile.normals, 0, all, samples.all_normals);
        append(tile.footprints, 0, all, samples.all_footprints);
        if (samples.positions.size() >= count)
            continue;
        append(tile.positions, tile.run_start(), tile.run_size(), samples.positions);
        append(tile.normals, tile.run_start(), tile.run_size(), samples.normals);
        append(tile.footprints, tile.run_start(), tile.run_size(), samples.footprints);
    }
    if (samples.positions.empty())
        throw std::runtime_error("the camera sees no surface of the scene");
    return samples;
}

}  // namespace demo
