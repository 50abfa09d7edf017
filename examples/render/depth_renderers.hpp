// SPDX-License-Identifier: MIT
#pragma once

#include "adapters/embree_depth_renderer.hpp"
#include "adapters/vulkan_depth_renderer.hpp"
#include "render/visibility.hpp"
#include "scene/blockers.hpp"

#include <lightmesh/lights.hpp>

namespace demo {

/// Calls use(renderer) with a `lightmesh::DepthRenderer` of the kind that the options ask for, and returns
/// what it returns.
template <class Use>
auto with_depth_renderer(const EmbreeScene& scene, const VisibilityOptions& options, Use&& use) {
    if (options.depth == DepthSource::embree)
        return use(EmbreeDepthRenderer(scene.blockers()));
    VulkanDepthOptions vulkan;
    vulkan.device = options.device;
    if (has_translucent(scene.scene())) {
        const Blockers blockers = all_blockers(scene.scene());
        return use(VulkanDepthRenderer(blockers.positions, blockers.indices, vulkan));
    }
    return use(VulkanDepthRenderer(scene.scene().positions, indices_of(scene.scene()), vulkan));
}

}  // namespace demo
