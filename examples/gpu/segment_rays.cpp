// SPDX-License-Identifier: MIT
#include "gpu/segment_rays.hpp"

#include "spirv/blocked.hpp"

#include <algorithm>
#include <vector>

namespace demo {

namespace {

using lightmesh::Segment;
static_assert(sizeof(Segment) == 24, "shaders read six words");

/// Of a dispatch: a million rays on a GPU, about a second of them on a CPU that plays one.
std::size_t segments_at_once(const ComputeDevice& device) {
    const std::size_t most = device.is_cpu() ? std::size_t{1} << 16 : std::size_t{1} << 20;
    return (std::max)((std::min)(most, device.largest_buffer() / sizeof(Segment) / group_size * group_size),
                      std::size_t{group_size});
}

}  // namespace

SegmentRays::SegmentRays(const ComputeDevice& device, const GpuScene& scene)
    : device_(device), at_once_(segments_at_once(device)), segments_(device, at_once_ * sizeof(Segment)),
      blocked_(device, at_once_ / 8),
      kernel_(device, spirv::blocked.on(device), scene.bindings_with(segments_, blocked_),
              sizeof(std::uint32_t)) {}

void SegmentRays::operator()(std::span<const Segment> segments, std::span<std::uint8_t> hit,
                             const std::atomic<bool>* cancel) {
    const std::scoped_lock lock(busy_);
    std::vector<std::uint32_t> bits;
    for (std::size_t first = 0; first < segments.size(); first += at_once_) {
        check_cancelled(cancel);
        const auto some = segments.subspan(first, (std::min)(at_once_, segments.size() - first));
        const auto count = static_cast<std::uint32_t>(some.size());
        const std::size_t groups = (some.size() + group_size - 1) / group_size;
        segments_.write(0, std::as_bytes(some));
        spent_.seconds_device += device_.run([&](const ComputeCommands& commands) {
            commands.dispatch(kernel_, static_cast<std::uint32_t>(groups), 1, 1,
                              std::as_bytes(std::span(&count, 1)));
        });
        bits.resize(2 * groups);
        blocked_.read(0, std::as_writable_bytes(std::span(bits)));
        for (std::size_t i = 0; i < some.size(); ++i)
            hit[first + i] = static_cast<std::uint8_t>(bits[i / 32] >> i % 32 & 1);
        ++spent_.dispatches;
        spent_.rays += some.size();
    }
}

DeviceFill SegmentRays::spent() const {
    const std::scoped_lock lock(busy_);
    return spent_;
}

}  // namespace demo
