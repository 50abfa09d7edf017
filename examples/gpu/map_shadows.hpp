// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/device_shadows.hpp"
#include "render/embree_scene.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

namespace demo {

/// Hard shadows by shaders' look-ups in a shadow map for each light. A picture is rendered, and copied to the
/// device, when a look-up first needs it.
class MapShadows final : public DeviceShadows {
public:
    /// `pixels`: at most so many in a batch, of which shaders see the scene, paths and points by `bindings`.
    MapShadows(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& options,
               std::size_t pixels, const std::vector<ComputeBinding>& bindings);
    ~MapShadows() override;

    /// What shaders see by host_rows.glsl.
    std::vector<ComputeBinding> bindings() const override;
    /// Throws also what the depth renderer throws.
    void shade(Round& round, const std::atomic<bool>* cancel) override;
    /// Throws as `shade`, and then has the maps of before.
    void update(const EmbreeScene& scene, const SceneChange& change) override;
    /// Of the maps.
    std::size_t bytes() const override;
    DeviceFill spent() const override;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
