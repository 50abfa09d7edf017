// SPDX-License-Identifier: MIT
#include "tune/sampling.hpp"

#include "render/terminal.hpp"

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace demo {

namespace {

constexpr std::size_t run_length = 64;

/// Points that follow each other in the picture, and a random number to choose them by.
struct PointRun {
    std::uint32_t seed;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
};

/// Lets everything be lit, and keeps all points, and a run of each tile's.
class Recorder final : public Visibility {
public:
    void find(const SurfacePoints& points, std::span<float> lit, VisibilityCost&) const override {
        std::ranges::fill(lit, 1.0f);
        const std::size_t count = points.positions.size();
        if (count == 0)
            return;
        const std::uint32_t seed = points.seeds.front();
        const std::size_t length = (std::min)(count, run_length);
        const std::size_t first = seed % (count - length + 1);
        const auto copy = [&](std::span<const glm::vec3> all) {
            const auto part = all.subspan(first, length);
            return std::vector<glm::vec3>(part.begin(), part.end());
        };
        PointRun run{seed, copy(points.positions), copy(points.normals)};
        const std::lock_guard lock(mutex_);
        positions_.insert(positions_.end(), points.positions.begin(), points.positions.end());
        normals_.insert(normals_.end(), points.normals.begin(), points.normals.end());
        runs_.push_back(std::move(run));
    }

    std::vector<glm::vec3> take_positions() { return std::move(positions_); }
    std::vector<glm::vec3> take_normals() { return std::move(normals_); }

    /// Full runs before shorter ones, and random ones before others: in an order that no thread had a say in.
    std::vector<PointRun> take_sorted() {
        std::ranges::sort(runs_, [](const PointRun& a, const PointRun& b) {
            return std::tuple(b.positions.size(), a.seed, a.positions.front().x, a.positions.front().y) <
                   std::tuple(a.positions.size(), b.seed, b.positions.front().x, b.positions.front().y);
        });
        return std::move(runs_);
    }

private:
    mutable std::mutex mutex_;
    mutable std::vector<glm::vec3> positions_;
    mutable std::vector<glm::vec3> normals_;
    mutable std::vector<PointRun> runs_;
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
    samples.all_positions = recorder.take_positions();
    samples.all_normals = recorder.take_normals();
    for (const PointRun& run : recorder.take_sorted()) {
        if (samples.positions.size() >= count)
            break;
        samples.positions.insert(samples.positions.end(), run.positions.begin(), run.positions.end());
        samples.normals.insert(samples.normals.end(), run.normals.begin(), run.normals.end());
    }
    if (samples.positions.empty())
        throw std::runtime_error("the camera sees no surface of the scene");
    return samples;
}

}  // namespace demo
