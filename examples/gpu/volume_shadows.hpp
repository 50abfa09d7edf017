// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_shadows.hpp"
#include "gpu/host_rows.hpp"
#include "gpu/host_visibility.hpp"

#include <atomic>
#include <cstddef>
#include <span>
#include <vector>

namespace demo {

/// Hard shadows by volumes, which the host looks up for all points of a round.
class VolumeShadows final : public DeviceShadows {
public:
    /// For batches of up to so many pixels.
    VolumeShadows(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& options,
                  std::size_t pixels)
        : host_("shadow-volume", scene, options), rows_(device, pixels) {}

    std::vector<ComputeBinding> bindings() const override { return rows_.bindings(set, 0); }

    void shade(Round& round, const std::atomic<bool>* cancel) override {
        const Round::Points asked = round.points();
        rows_.clear();
        rows_.add(asked.pixels, host_.light_count(),
                  [&](std::span<float> lit) { host_.find(asked.points, lit, cancel); });
        for (const ComputeBinding& binding : bindings())
            round.kernel().bind(binding);
        round.shade();
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override { host_.update(scene, change); }

    std::size_t bytes() const override { return host_.bytes(); }

private:
    HostVisibility host_;
    HostRows rows_;
};

}  // namespace demo
