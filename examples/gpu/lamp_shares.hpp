// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/gpu_scene.hpp"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>

namespace demo {

/// Shares of lamps by shaders through a scene: a `lightmesh::ShareFinder`, for any number of
/// threads. They take turns.
class LampShares {
public:
    LampShares(const ComputeDevice& device, const GpuScene& scene);

    /// Throws `Cancelled` between two dispatches if that is set, and what `compute.hpp` throws.
    void operator()(std::span<const std::byte> work, std::span<std::uint32_t> found,
                    const std::atomic<bool>* cancel);

    DeviceFill spent() const;

private:
    ComputeDevice device_;
    ComputeBuffer work_;
    ComputeBuffer found_;
    ComputeKernel kernel_;
    mutable std::mutex busy_;
    DeviceFill spent_;
};

}  // namespace demo
