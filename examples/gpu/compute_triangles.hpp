// SPDX-License-Identifier: MIT
#pragma once

#include "../adapters/vulkan_depth_renderer.hpp"
#include "compute.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// The acceleration structures of `ComputeTriangles`, for compute.cpp and compute_triangles.cpp alone.

namespace demo {

/// An acceleration structure and its memory.
struct TriangleStructure {
    vulkan::Buffer memory;
    vk::raii::AccelerationStructureKHR handle;
};

/// All triangles in one structure, and that structure once in another one, which shaders see.
struct ComputeTriangles::State {
    State(const ComputeDevice& on, const ComputeBuffer& positions, std::size_t stride,
          std::span<const std::uint32_t> opaque, std::span<const std::uint32_t> others);

    void build() const;

    ComputeDevice device;
    ComputeBuffer vertices;
    std::size_t bytes_of_vertex;
    std::array<std::uint32_t, 2> counts;  ///< of triangles: opaque ones, others
    ComputeBuffer indices;
    TriangleStructure bottom;
    ComputeBuffer instance;  ///< of `bottom`, in `top`
    TriangleStructure top;
    vulkan::Buffer scratch;
    vk::DeviceAddress scratch_address;  ///< where builds may work in it

private:
    using Type = vk::AccelerationStructureTypeKHR;

    /// What a structure is built of.
    struct Inputs {
        std::vector<vk::AccelerationStructureGeometryKHR> geometries;
        std::vector<vk::AccelerationStructureBuildRangeInfoKHR> ranges;
        vk::AccelerationStructureBuildGeometryInfoKHR info;
    };

    const vulkan::Device& on() const;
    vk::DeviceAddress address_of(const vulkan::Buffer& buffer) const;
    Inputs inputs_of(Type type) const;
    Inputs inputs_of_bottom() const;
    Inputs inputs_of_top() const;
    vk::AccelerationStructureBuildSizesInfoKHR sizes_of(Type type) const;
    vulkan::Buffer allocate(vk::DeviceSize size, vk::BufferUsageFlags usage) const;
    TriangleStructure make(Type type) const;
    ComputeBuffer make_instance() const;
    vk::DeviceSize scratch_alignment() const;
    vulkan::Buffer make_scratch() const;
    void record(const vk::raii::CommandBuffer& commands, Type type, const TriangleStructure& structure) const;
};

}  // namespace demo
