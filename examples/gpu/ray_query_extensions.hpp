// SPDX-License-Identifier: MIT
#pragma once

#include "../adapters/vulkan_depth_renderer.hpp"

#include <optional>

namespace demo {

/// Decides about a device as `ComputeOptions::ray_queries` says. Throws std::runtime_error that names it
/// where it has none that are wanted.
bool opens_with_ray_queries(const vk::raii::PhysicalDevice& device, const std::optional<bool>& are_wanted);

/// All that ray queries need, of a Vulkan 1.1 device.
vulkan::Extensions ray_query_extensions();

}  // namespace demo
