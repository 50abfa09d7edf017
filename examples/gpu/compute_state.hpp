// SPDX-License-Identifier: MIT
#pragma once

#include "../adapters/vulkan_depth_renderer.hpp"
#include "compute.hpp"
#include "ray_query_extensions.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

/// The states of compute.hpp's devices and buffers, for compute.cpp and compute_triangles.cpp alone.

namespace demo {

template <class Act>
auto in_words(const vulkan::Device& on, const std::string& what, Act&& act) {
    return vulkan::in_words(vulkan::name_of(on.physical), what, std::forward<Act>(act));
}

/// A shader made ready, for any buffers of its bindings.
struct ComputeProgram {
    std::vector<vk::raii::DescriptorSetLayout> sets;
    std::optional<vk::raii::PipelineLayout> layout;
    std::optional<vk::raii::Pipeline> pipeline;
};

/// Copies between host and device go through so many bytes at a time.
inline constexpr std::size_t staging_bytes = std::size_t{16} << 20;

struct ComputeDevice::State {
    explicit State(const ComputeOptions& options)
        : on({.device = options.device, .validate = options.validate, .on_message = options.on_message},
             vk::QueueFlagBits::eCompute,
             [&](const vk::raii::PhysicalDevice& physical) {
                 has_ray_queries = opens_with_ray_queries(physical, options.ray_queries);
                 return has_ray_queries ? ray_query_extensions() : vulkan::Extensions{};
             }),
          limits(on.physical.getProperties().limits) {
        if (on.physical.getProperties().apiVersion < VK_API_VERSION_1_1)
            throw std::runtime_error("Vulkan: " + vulkan::name_of(on.physical) + " is older than Vulkan 1.1");
        if (on.physical.getQueueFamilyProperties()[on.family].timestampValidBits != 0)
            in_words(on, "when it was opened", [&] {
                clock.emplace(on.device, vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, 2));
            });
    }

    /// Of buffers that shaders see, and that triangles for ray queries are made of.
    vk::BufferUsageFlags usage_of_buffers() const {
        using Usage = vk::BufferUsageFlagBits;
        const vk::BufferUsageFlags all = Usage::eStorageBuffer | Usage::eUniformBuffer |
                                         Usage::eIndirectBuffer | Usage::eTransferSrc | Usage::eTransferDst;
        return has_ray_queries
                   ? all | Usage::eShaderDeviceAddress | Usage::eAccelerationStructureBuildInputReadOnlyKHR
                   : all;
    }

    const vulkan::HostBuffer& staging() {
        if (!staging_buffer)
            staging_buffer.emplace(on, staging_bytes,
                                   vk::BufferUsageFlagBits::eTransferSrc |
                                       vk::BufferUsageFlagBits::eTransferDst);
        return *staging_buffer;
    }

    /// The program of a key, which make() makes if there is none yet: on several threads at once, if they ask
    /// for it together.
    template <class Make>
    std::shared_ptr<const ComputeProgram> program_of(std::vector<std::uint32_t> key, Make&& make) {
        {
            const std::scoped_lock lock(programs_busy);
            if (const auto found = programs.find(key); found != programs.end())
                return found->second;
        }
        std::shared_ptr<const ComputeProgram> made = make();
        const std::scoped_lock lock(programs_busy);
        return programs.try_emplace(std::move(key), std::move(made)).first->second;
    }

    std::mutex busy;
    bool has_ray_queries = false;
    vulkan::Device on;
    vk::PhysicalDeviceLimits limits;
    std::optional<vk::raii::QueryPool> clock;
    std::optional<vulkan::HostBuffer> staging_buffer;
    /// By all that they are made of. Drivers take seconds to make one; who renders one picture after the
    /// other has the same kernels again.
    std::map<std::vector<std::uint32_t>, std::shared_ptr<const ComputeProgram>> programs;
    std::mutex programs_busy;
};

struct ComputeBuffer::State {
    State(const ComputeDevice& on, std::size_t bytes)
        : device(on), size(bytes), room((std::max)((bytes + 3) / 4 * 4, std::size_t{16})),
          memory(allocate()) {}

    vulkan::Buffer allocate() const {
        const vulkan::Device& on = device.state_->on;
        const std::string what = "asked for a buffer of " + std::to_string(room) + " bytes";
        if (room > device.largest_buffer())
            throw std::runtime_error("Vulkan: shaders of " + vulkan::name_of(on.physical) +
                                     " see buffers of up to " + std::to_string(device.largest_buffer()) +
                                     " bytes, not of " + std::to_string(room));
        return in_words(on, what, [&] {
            return vulkan::Buffer(on, room, device.state_->usage_of_buffers(),
                                  vk::MemoryPropertyFlagBits::eDeviceLocal, {});
        });
    }

    void check(std::size_t offset, std::size_t bytes) const {
        if (offset > size || bytes > size - offset)
            throw std::out_of_range("Vulkan: " + std::to_string(bytes) + " bytes from " +
                                    std::to_string(offset) + " on are not in a buffer of " +
                                    std::to_string(size));
    }

    ComputeDevice device;
    std::size_t size;
    std::size_t room;
    vulkan::Buffer memory;
};

}  // namespace demo
