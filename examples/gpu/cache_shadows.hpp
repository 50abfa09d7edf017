// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_shadows.hpp"
#include "gpu/gpu_scene.hpp"
#include "render/embree_scene.hpp"
#include "render/visibility.hpp"

#include <cstddef>
#include <memory>
#include <string>

namespace demo {

/// A visibility cache on a device, whose rays to lamps shaders trace; what records say by a light mesh the
/// host finds. `algorithm`: cache or blur-cache. For batches of up to so many pixels. What the options know
/// the cache begins with.
std::unique_ptr<DeviceShadows> make_cache_shadows(const ComputeDevice& device, const std::string& algorithm,
                                                  const EmbreeScene& scene, const GpuScene& copy,
                                                  const VisibilityOptions& options, std::size_t pixels);

}  // namespace demo
