// SPDX-License-Identifier: MIT
#pragma once

#include "adapters/embree_depth_renderer.hpp"
#include "adapters/vulkan_depth_renderer.hpp"
#include "render/visibility.hpp"

#include <lightmesh/lights.hpp>

#include <cstdint>
#include <iterator>
#include <vector>

namespace demo {

inline std::vector<std::uint32_t> indices_of(const Scene& scene) {
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * scene.triangles.size());
    for (const Triangle& triangle : scene.triangles)
        indices.insert(indices.end(), std::begin(triangle.vertex), std::end(triangle.vertex));
    return indices;
}

/// Calls use(renderer) with a `lightmesh::DepthRenderer` of the kind that the options ask for, and returns
/// what it returns.
template <class Use>
auto with_depth_renderer(const EmbreeScene& scene, const VisibilityOptions& options, Use&& use) {
    if (options.depth == DepthSource::embree)
        return use(EmbreeDepthRenderer(scene.handle()));
    VulkanDepthOptions vulkan;
    vulkan.device = options.device;
    return use(VulkanDepthRenderer(scene.scene().positions, indices_of(scene.scene()), vulkan));
}

}  // namespace demo
