// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

namespace demo {

/// The cost of filling by shaders so far.
struct DeviceFill {
    std::uint64_t rays = 0;
    std::size_t dispatches = 0;
    double seconds_device = 0.0;  ///< in shaders

    DeviceFill& operator+=(const DeviceFill& other) {
        rays += other.rays;
        dispatches += other.dispatches;
        seconds_device += other.seconds_device;
        return *this;
    }
};

/// Thrown where work is cancelled.
struct Cancelled : std::runtime_error {
    Cancelled() : std::runtime_error("cancelled") {}
};

/// Throws `Cancelled` if somebody has set `cancel`, which may be null.
inline void check_cancelled(const std::atomic<bool>* cancel) {
    if (cancel != nullptr && cancel->load(std::memory_order_relaxed))
        throw Cancelled();
}

}  // namespace demo
