// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "render/embree_scene.hpp"
#include "render/renderer.hpp"
#include "render/visibility.hpp"

#include <vector>

namespace demo {

/// A scene on a device, with the view and the options of pictures: what scene.glsl reads, bindings 0 to 6 of
/// set 0.
class GpuScene {
public:
    GpuScene(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& visibility = {},
             const RenderOptions& options = {});

    const std::vector<ComputeBinding>& bindings() const { return bindings_; }

private:
    std::vector<ComputeBinding> bindings_;
};

}  // namespace demo
