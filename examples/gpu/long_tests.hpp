// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"
#include "gpu/listed_words.hpp"

#include <lightmesh/fill/long_test_list.hpp>

#include <atomic>
#include <cstdint>
#include <span>

namespace demo {

/// Long tests of light meshes by the shaders' traversal of a scene: a `LongTestTracer`, of the mesh that is
/// bound.
class LongTests {
public:
    LongTests(const ComputeDevice& device, const GpuScene& scene);

    /// As `ListedWords::bind`.
    void bind(std::span<const ComputeBinding> mesh) const { words_.bind(mesh); }
    static constexpr std::uint32_t set = 1;

    /// Throws as `ListedWords::find`.
    void operator()(std::span<const lightmesh::LongTestWord> words, std::span<std::uint64_t> seen,
                    const std::atomic<bool>* cancel);

    const DeviceFill& spent() const { return words_.spent(); }

private:
    ListedWords<lightmesh::LongTestWord, std::uint64_t> words_;
};

}  // namespace demo
