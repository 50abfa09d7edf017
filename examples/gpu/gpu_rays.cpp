// SPDX-License-Identifier: MIT
#include "gpu/gpu_rays.hpp"

#include "spirv/closest.hpp"
#include "spirv/occluded.hpp"

#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

namespace demo {

namespace {

/// Of a submission.
constexpr std::uint32_t most_groups = 65535;

std::vector<ComputeBinding> bindings_of(const ComputeDevice& device, const GpuScene& scene) {
    const ComputeBuffer nothing(device, std::size_t{16});
    return scene.bindings_with(nothing, nothing);
}

}  // namespace

GpuRays::GpuRays(const ComputeDevice& device, const GpuScene& scene)
    : device_(device), closest_(device, spirv::closest.on(device), bindings_of(device, scene), 8),
      occluded_(device, spirv::occluded.on(device), bindings_of(device, scene), 8) {}

std::vector<GpuRays::Closest> GpuRays::run(const ComputeKernel& kernel,
                                           std::span<const lightmesh::Segment> segments) {
    std::vector<glm::vec4> ends;
    ends.reserve(2 * segments.size());
    for (const lightmesh::Segment& segment : segments) {
        ends.emplace_back(segment.origin, 0.0f);
        ends.emplace_back(segment.target, 0.0f);
    }
    const ComputeBuffer asked(device_, std::as_bytes(std::span(ends)));
    const ComputeBuffer answers(device_, segments.size() * sizeof(Closest));
    kernel.bind({.set = 1, .binding = 0, .resource = asked});
    kernel.bind({.set = 1, .binding = 1, .resource = answers});
    const auto ask = [&] {
        return device_.run([&](const ComputeCommands& commands) {
            const auto count = static_cast<std::uint32_t>(segments.size());
            for (std::uint32_t first = 0; first < count; first += most_groups * group_size) {
                const std::uint32_t groups =
                    (std::min)((count - first + group_size - 1) / group_size, most_groups);
                const std::array push{first, count};
                commands.dispatch(kernel, groups, 1, 1, std::as_bytes(std::span(push)));
            }
        });
    };
    seconds_ = is_timed_ ? device_.least_time(ask) : ask();
    return answers.read_all<Closest>();
}

std::vector<GpuRays::Closest> GpuRays::closest(std::span<const lightmesh::Segment> segments) {
    return run(closest_, segments);
}

std::vector<float> GpuRays::let_through(std::span<const lightmesh::Segment> segments) {
    std::vector<float> shares;
    shares.reserve(segments.size());
    for (const Closest& answer : run(occluded_, segments))
        shares.push_back(std::bit_cast<float>(answer.triangle));
    return shares;
}

}  // namespace demo
