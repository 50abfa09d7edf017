// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"

#include <lightmesh/fill/long_test_list.hpp>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace demo {

/// Long tests of light meshes by the shaders' traversal of a scene: a `LongTestTracer`, of the mesh that is
/// bound.
class LongTests {
public:
    LongTests(const ComputeDevice& device, const GpuScene& scene);

    /// Which mesh words are of from now on: as `UploadedMesh::bindings` gives it for `set`.
    void bind(std::span<const ComputeBinding> mesh) const;
    static constexpr std::uint32_t set = 1;

    /// Throws `Cancelled` between two dispatches if that is set, and what `compute.hpp` throws.
    void operator()(std::span<const lightmesh::LongTestWord> words, std::span<std::uint64_t> seen,
                    const std::atomic<bool>* cancel);

    const DeviceFill& spent() const { return spent_; }

private:
    ComputeDevice device_;
    std::size_t at_once_;  ///< words
    ComputeBuffer words_;
    ComputeBuffer seen_;
    ComputeKernel kernel_;
    DeviceFill spent_;
};

}  // namespace demo
