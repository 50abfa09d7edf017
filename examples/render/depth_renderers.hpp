// SPDX-License-Identifier: MIT
#pragma once

#include "adapters/embree_depth_renderer.hpp"
#include "adapters/vulkan_depth_renderer.hpp"
#include "render/visibility.hpp"
#include "scene/blockers.hpp"

#include <lightmesh/lights.hpp>

#include <type_traits>

namespace demo {

/// Of the scene as it is now.
template <class Renderer>
Renderer make_depth_renderer(const EmbreeScene& scene, const VisibilityOptions& options) {
    if constexpr (std::is_same_v<Renderer, EmbreeDepthRenderer>) {
        return EmbreeDepthRenderer(scene.blockers());
    } else {
        VulkanDepthOptions vulkan;
        vulkan.device = options.device;
        if (has_translucent(scene.scene())) {
            const Blockers blockers = all_blockers(scene.scene());
            return VulkanDepthRenderer(blockers.positions, blockers.indices, vulkan);
        }
        return VulkanDepthRenderer(scene.scene().positions, indices_of(scene.scene()), vulkan);
    }
}

/// Calls use(renderer) with a `lightmesh::DepthRenderer` of the kind that the options ask for, and returns
/// what it returns.
template <class Use>
auto with_depth_renderer(const EmbreeScene& scene, const VisibilityOptions& options, Use&& use) {
    if (options.depth == DepthSource::embree)
        return use(make_depth_renderer<EmbreeDepthRenderer>(scene, options));
    return use(make_depth_renderer<VulkanDepthRenderer>(scene, options));
}

}  // namespace demo
