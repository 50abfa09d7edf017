// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "render/embree_scene.hpp"
#include "render/renderer.hpp"
#include "render/visibility.hpp"
#include "scene/scene_change.hpp"

#include <cstddef>
#include <memory>
#include <vector>

namespace demo {

/// A scene on a device, with the view and the options of pictures: what scene.glsl reads, bindings 0 to 6 of
/// set 0.
class GpuScene {
public:
    GpuScene(const ComputeDevice& device, const EmbreeScene& scene, const VisibilityOptions& visibility = {},
             const RenderOptions& options = {});
    GpuScene(const GpuScene&) = delete;
    GpuScene& operator=(const GpuScene&) = delete;
    ~GpuScene();

    /// After the scene has changed, not into another one, and `scene` was updated: brings what differs to
    /// the same buffers. A BVH keeps its shape; triangles for ray queries are arranged anew. Returns how many
    /// bytes were written.
    std::size_t update(const EmbreeScene& scene, const SceneChange& change);

    const std::vector<ComputeBinding>& bindings() const { return bindings_; }
    /// The same, with what rays are asked for by and what they find as bindings 0 and 1 of set 1.
    std::vector<ComputeBinding> bindings_with(const ComputeBuffer& asked, const ComputeBuffer& found) const;

private:
    struct Copy;
    std::unique_ptr<Copy> copy_;
    std::vector<ComputeBinding> bindings_;
};

}  // namespace demo
