// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_shadows.hpp"
#include "gpu/gpu_scene.hpp"
#include "render/embree_scene.hpp"
#include "render/visibility.hpp"

#include <memory>
#include <string>

namespace demo {

/// A light mesh on a device. Shaders trace its links and long tests; where these are not by rays, the host
/// finds them, and the links. `algorithm`: one with a mesh; the short test is that of the options. What they
/// know the mesh begins with.
std::unique_ptr<DeviceShadows> make_mesh_shadows(const ComputeDevice& device, const std::string& algorithm,
                                                 const EmbreeScene& scene, const GpuScene& copy,
                                                 const VisibilityOptions& options);

}  // namespace demo
