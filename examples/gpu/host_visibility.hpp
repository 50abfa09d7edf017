// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/device_fill.hpp"
#include "render/visibility.hpp"

#include <lightmesh/surface_point.hpp>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace demo {

/// part(first, size) of `count` things on all threads. Throws `Cancelled`.
template <class Part>
void in_parts(std::size_t count, const std::atomic<bool>* cancel, Part&& part) {
    constexpr std::size_t at_once = 256;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, at_once), [&](const auto& range) {
        check_cancelled(cancel);
        part(range.begin(), range.size());
    });
}

/// An algorithm whose mesh or cache shaders have a copy of, while all that it knows is found by the host.
class HostVisibility {
public:
    HostVisibility(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& options)
        : visibility_(make_visibility(algorithm, scene, options)), lights_(scene.scene().lights.size()) {}

    /// How lit points are: a row of all lights at each. Throws `Cancelled`.
    void find(std::span<const lightmesh::SurfacePoint> points, std::span<float> lit,
              const std::atomic<bool>* cancel) const {
        in_parts(points.size(), cancel, [&](std::size_t first, std::size_t size) {
            ask(points.subspan(first, size), lit.subspan(first * lights_, size * lights_));
        });
    }

    /// Finds what shaders lack at points. Throws `Cancelled`.
    void fill(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) const {
        in_parts(points.size(), cancel, [&](std::size_t first, std::size_t size) {
            std::vector<float> lit(size * lights_);
            ask(points.subspan(first, size), lit);
        });
    }

    void update(const EmbreeScene& scene, const SceneChange& change) {
        lights_ = scene.scene().lights.size();
        visibility_->update(scene, change);
        visibility_->compact();
    }

    /// As `Visibility::begin_frame`.
    void begin_frame() {
        visibility_->begin_frame();
        visibility_->compact();
    }
    void merge(std::span<const std::byte> known) { visibility_->merge(known); }

    std::size_t light_count() const { return lights_; }
    std::size_t bytes() const { return visibility_->bytes(); }
    std::vector<std::byte> snapshot() const { return visibility_->snapshot(); }
    lightmesh::MeshStatistics mesh() const { return visibility_->mesh().value(); }
    lightmesh::CacheStatistics cache() const { return visibility_->cache().value(); }
    DeviceFill spent() const { return {}; }

private:
    void ask(std::span<const lightmesh::SurfacePoint> points, std::span<float> lit) const {
        const std::vector<std::uint32_t> seeds(points.size());
        VisibilityCost cost;
        visibility_->find({points, seeds}, lit, cost);
    }

    std::unique_ptr<Visibility> visibility_;
    std::size_t lights_;
};

}  // namespace demo
