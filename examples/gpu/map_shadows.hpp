// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "render/embree_scene.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace demo {

/// Hard shadows by shaders' look-ups in a shadow map for each light. A picture is rendered, and copied to the
/// device, when a look-up first needs it.
class MapShadows {
public:
    /// Descriptor set where shaders see the answers, as `HostRows`.
    static constexpr std::uint32_t set = 1;

    /// `pixels`: at most so many in a batch, of which shaders see the scene, paths and points by `bindings`.
    MapShadows(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& options,
               std::size_t pixels, const std::vector<ComputeBinding>& bindings);
    MapShadows(const MapShadows&) = delete;
    MapShadows& operator=(const MapShadows&) = delete;
    ~MapShadows();

    /// After the scene has changed, not into another one, and `scene` was updated. Throws as `find`, and then
    /// has the maps of before.
    void update(const EmbreeScene& scene, const SceneChange& change);

    /// Finds what the points of a batch see; `batch` are its push constants. Returns the seconds that the
    /// device took. Throws `Cancelled`, and what the depth renderer and `compute.hpp` throw.
    double find(std::span<const std::byte> batch, std::uint32_t groups, const std::atomic<bool>* cancel);

    std::vector<ComputeBinding> bindings() const;

    /// Of the maps.
    std::size_t bytes() const;

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace demo
