// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/host_rows.hpp"
#include "gpu/host_visibility.hpp"

#include <lightmesh/surface_point.hpp>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// Hard shadows by volumes, which the host looks up for all points of a round.
class VolumeShadows {
public:
    /// Descriptor set where shaders see the host's answers.
    static constexpr std::uint32_t set = 1;

    /// For batches of up to so many pixels.
    VolumeShadows(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& options,
                  std::size_t pixels)
        : host_("shadow-volume", scene, options), rows_(device, pixels) {}

    /// After the scene has changed, not into another one, and `scene` was updated.
    void update(const EmbreeScene& scene, const SceneChange& change) { host_.update(scene, change); }

    /// Finds how lit the points of a round are, which pixels of these numbers have; forgets those of the
    /// round before. Throws `Cancelled`.
    void find(std::span<const lightmesh::SurfacePoint> points, std::span<const std::uint32_t> pixels,
              const std::atomic<bool>* cancel) {
        rows_.clear();
        rows_.add(pixels, host_.light_count(),
                  [&](std::span<float> lit) { host_.find(points, lit, cancel); });
    }

    std::vector<ComputeBinding> bindings() const {
        std::vector<ComputeBinding> made;
        for (const ComputeBuffer& buffer : rows_.buffers())
            made.push_back(
                {.set = set, .binding = static_cast<std::uint32_t>(made.size()), .buffer = buffer});
        return made;
    }

    /// Of the volumes.
    std::size_t bytes() const { return host_.bytes(); }

private:
    HostVisibility host_;
    HostRows rows_;
};

}  // namespace demo
