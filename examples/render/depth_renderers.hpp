// SPDX-License-Identifier: MIT
#pragma once

#include "adapters/embree_depth_renderer.hpp"
#include "adapters/vulkan_depth_renderer.hpp"
#include "render/visibility.hpp"
#include "scene/blockers.hpp"

#include <lightmesh/lights.hpp>
#include <lightmesh/shadows/shadow_map.hpp>

#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

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

/// Makes shadow maps of the scene's lights, by their numbers, of the triangles that the renderer has.
template <class Renderer>
auto maps_by(Renderer renderer, const EmbreeScene& scene, const VisibilityOptions& options) {
    lightmesh::ShadowMapSettings settings;
    settings.resolution = options.settings.shadow_map_size;
    return [&lights = scene.scene().lights, settings,
            shared = std::make_shared<lightmesh::SharedDepthRenderer<Renderer>>(std::move(renderer))](
               std::size_t light) {
        return std::make_unique<const lightmesh::ShadowMap<Renderer>>(shared, lights[light].shape, settings,
                                                                      "light " + std::to_string(light));
    };
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
