// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/listed_words.hpp"

#include <lightmesh/fill/link_list.hpp>

#include <atomic>
#include <cstdint>
#include <span>

namespace demo {

/// Links of light meshes by the shaders' traversal of a scene: a `LinkTracer`, of the mesh that is
/// bound.
class LinkTests {
public:
    LinkTests(const ComputeDevice& device, const GpuScene& scene);

    /// As `ListedWords::bind`.
    void bind(std::span<const ComputeBinding> mesh) const { words_.bind(mesh); }
    static constexpr std::uint32_t set = 1;

    /// Throws as `ListedWords::find`.
    void operator()(std::span<const lightmesh::LinkWord> words, std::span<lightmesh::OpenLinks> open,
                    const std::atomic<bool>* cancel);

    const DeviceFill& spent() const { return words_.spent(); }

private:
    ListedWords<lightmesh::LinkWord, lightmesh::OpenLinks> words_;
};

}  // namespace demo
