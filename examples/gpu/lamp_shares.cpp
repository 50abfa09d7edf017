// SPDX-License-Identifier: MIT
#include "gpu/lamp_shares.hpp"

#include "spirv/lamp_shares.hpp"

#include <lightmesh/fill/share_finder.hpp>

#include <algorithm>

namespace demo {

namespace {

/// As lamp_shares.glsl has it.
constexpr std::size_t shares_of_group = 4;

/// Of a dispatch: all on a GPU, about a second of them on a CPU that plays one.
std::size_t shares_at_once(const ComputeDevice& device) {
    return device.is_cpu() ? std::size_t{1} << 12 : lightmesh::most_listed_shares;
}

}  // namespace

LampShares::LampShares(const ComputeDevice& device, const GpuScene& scene)
    : device_(device), work_(device, std::size_t{1} << 20),
      found_(device, lightmesh::most_listed_shares * sizeof(std::uint32_t)),
      kernel_(device, spirv::lamp_shares.on(device), scene.bindings_with(work_, found_),
              sizeof(std::uint32_t)) {}

void LampShares::operator()(std::span<const std::byte> work, std::span<std::uint32_t> found,
                            const std::atomic<bool>* cancel) {
    const std::scoped_lock lock(busy_);
    check_cancelled(cancel);
    if (work_.size() < work.size()) {
        work_ = ComputeBuffer(device_, (std::max)(work.size(), 2 * work_.size()));
        kernel_.bind({.set = 1, .binding = 0, .resource = work_});
    }
    work_.write(0, work);
    const std::size_t at_once = shares_at_once(device_);
    for (std::size_t first = 0; first < found.size(); first += at_once) {
        check_cancelled(cancel);
        const std::size_t count = (std::min)(at_once, found.size() - first);
        const auto number = static_cast<std::uint32_t>(first);
        spent_.seconds_device += device_.run([&](const ComputeCommands& commands) {
            commands.dispatch(kernel_,
                              static_cast<std::uint32_t>((count + shares_of_group - 1) / shares_of_group), 1,
                              1, std::as_bytes(std::span(&number, 1)));
        });
        ++spent_.dispatches;
    }
    found_.read(0, std::as_writable_bytes(found));
    for (const std::uint32_t share : found)
        spent_.rays += share >> 8;
}

DeviceFill LampShares::spent() const {
    const std::scoped_lock lock(busy_);
    return spent_;
}

}  // namespace demo
