// SPDX-License-Identifier: MIT
#include "compute_triangles.hpp"

#include "compute_state.hpp"

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <string>

namespace demo {

namespace {

using Usage = vk::BufferUsageFlagBits;

constexpr std::size_t bytes_of_triangle = 3 * sizeof(std::uint32_t);

vk::PhysicalDeviceAccelerationStructurePropertiesKHR properties_of(const vk::raii::PhysicalDevice& device) {
    const auto chain = device.getProperties2<vk::PhysicalDeviceProperties2,
                                             vk::PhysicalDeviceAccelerationStructurePropertiesKHR>();
    return chain.get<vk::PhysicalDeviceAccelerationStructurePropertiesKHR>();
}

std::uint32_t triangles_in(std::span<const std::uint32_t> corners) {
    return static_cast<std::uint32_t>(corners.size() / 3);
}

}  // namespace

ComputeTriangles::State::State(const ComputeDevice& with, const ComputeBuffer& positions, std::size_t stride,
                               std::span<const std::uint32_t> opaque, std::span<const std::uint32_t> others)
    : device(with), vertices(positions),
      bytes_of_vertex(stride), counts{triangles_in(opaque), triangles_in(others)},
      indices(with, opaque.size_bytes() + others.size_bytes()), bottom(make(Type::eBottomLevel)),
      instance(make_instance()), top(make(Type::eTopLevel)), scratch(make_scratch()),
      scratch_address((address_of(scratch) + scratch_alignment() - 1) / scratch_alignment() *
                      scratch_alignment()) {
    indices.write(0, std::as_bytes(opaque));
    indices.write(opaque.size_bytes(), std::as_bytes(others));
    build();
}

void ComputeTriangles::State::build() const {
    const std::scoped_lock lock(device.state_->busy);
    in_words(on(), "while it arranged triangles for ray queries", [&] {
        on().run([&](const vk::raii::CommandBuffer& commands) {
            using Stage = vk::PipelineStageFlagBits;
            using Access = vk::AccessFlagBits;
            const auto wait = [&](Stage before, Access written, Stage after, vk::AccessFlags then) {
                commands.pipelineBarrier(before, after, {}, vk::MemoryBarrier(written, then), nullptr,
                                         nullptr);
            };
            constexpr Stage building = Stage::eAccelerationStructureBuildKHR;
            const vk::AccessFlags structures =
                Access::eAccelerationStructureReadKHR | Access::eAccelerationStructureWriteKHR;
            wait(Stage::eTransfer, Access::eTransferWrite, building, Access::eShaderRead);
            wait(building, Access::eAccelerationStructureWriteKHR, building, structures);
            record(commands, Type::eBottomLevel, bottom);
            wait(building, Access::eAccelerationStructureWriteKHR, building, structures);
            record(commands, Type::eTopLevel, top);
            wait(building, Access::eAccelerationStructureWriteKHR, Stage::eComputeShader,
                 Access::eAccelerationStructureReadKHR);
        });
    });
}

const vulkan::Device& ComputeTriangles::State::on() const {
    return device.state_->on;
}

vk::DeviceAddress ComputeTriangles::State::address_of(const vulkan::Buffer& buffer) const {
    return on().device.getBufferAddressKHR(vk::BufferDeviceAddressInfo(*buffer.buffer));
}

ComputeTriangles::State::Inputs ComputeTriangles::State::inputs_of(Type type) const {
    Inputs made = type == Type::eTopLevel ? inputs_of_top() : inputs_of_bottom();
    made.info = vk::AccelerationStructureBuildGeometryInfoKHR()
                    .setType(type)
                    .setFlags(vk::BuildAccelerationStructureFlagBitsKHR::ePreferFastTrace)
                    .setGeometries(made.geometries);
    return made;
}

ComputeTriangles::State::Inputs ComputeTriangles::State::inputs_of_bottom() const {
    using Flag = vk::GeometryFlagBitsKHR;
    const std::size_t vertex_count = (std::max)(vertices.size() / bytes_of_vertex, std::size_t{1});
    const vk::AccelerationStructureGeometryTrianglesDataKHR triangles(
        vk::Format::eR32G32B32Sfloat, address_of(vertices.state_->memory), bytes_of_vertex,
        static_cast<std::uint32_t>(vertex_count - 1), vk::IndexType::eUint32,
        address_of(indices.state_->memory));
    Inputs made;
    for (const Flag flag : {Flag::eOpaque, Flag::eNoDuplicateAnyHitInvocation})
        made.geometries.emplace_back(vk::GeometryTypeKHR::eTriangles, triangles, flag);
    made.ranges.emplace_back(counts[0], 0u, 0u, 0u);
    made.ranges.emplace_back(counts[1], static_cast<std::uint32_t>(counts[0] * bytes_of_triangle), 0u, 0u);
    return made;
}

ComputeTriangles::State::Inputs ComputeTriangles::State::inputs_of_top() const {
    const vk::AccelerationStructureGeometryInstancesDataKHR instances(false,
                                                                      address_of(instance.state_->memory));
    Inputs made;
    made.geometries.emplace_back(vk::GeometryTypeKHR::eInstances, instances);
    made.ranges.emplace_back(1u, 0u, 0u, 0u);
    return made;
}

vk::AccelerationStructureBuildSizesInfoKHR ComputeTriangles::State::sizes_of(Type type) const {
    const Inputs inputs = inputs_of(type);
    std::vector<std::uint32_t> primitives;
    for (const vk::AccelerationStructureBuildRangeInfoKHR& range : inputs.ranges)
        primitives.push_back(range.primitiveCount);
    return on().device.getAccelerationStructureBuildSizesKHR(vk::AccelerationStructureBuildTypeKHR::eDevice,
                                                             inputs.info, primitives);
}

vulkan::Buffer ComputeTriangles::State::allocate(vk::DeviceSize size, vk::BufferUsageFlags usage) const {
    const std::string what =
        "asked for " + std::to_string(size) + " bytes for ray queries, which --gpu-rays bvh does without";
    return in_words(on(), what, [&] {
        return vulkan::Buffer(on(), size, usage | Usage::eShaderDeviceAddress,
                              vk::MemoryPropertyFlagBits::eDeviceLocal, {});
    });
}

/// Of nothing yet.
TriangleStructure ComputeTriangles::State::make(Type type) const {
    const vk::DeviceSize size = sizes_of(type).accelerationStructureSize;
    vulkan::Buffer memory = allocate(size, Usage::eAccelerationStructureStorageKHR);
    const vk::AccelerationStructureCreateInfoKHR info({}, *memory.buffer, 0, size, type);
    return in_words(on(), "while room was made for triangles", [&] {
        return TriangleStructure{std::move(memory), {on().device, info}};
    });
}

/// The whole of `bottom` where it is.
ComputeBuffer ComputeTriangles::State::make_instance() const {
    vk::AccelerationStructureInstanceKHR one;
    for (std::size_t axis = 0; axis < 3; ++axis)
        one.transform.matrix[axis][axis] = 1.0f;
    one.mask = 0xff;
    one.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
    one.accelerationStructureReference = on().device.getAccelerationStructureAddressKHR(
        vk::AccelerationStructureDeviceAddressInfoKHR(*bottom.handle));
    return {device, std::as_bytes(std::span(&one, 1))};
}

vk::DeviceSize ComputeTriangles::State::scratch_alignment() const {
    return properties_of(on().physical).minAccelerationStructureScratchOffsetAlignment;
}

vulkan::Buffer ComputeTriangles::State::make_scratch() const {
    const vk::DeviceSize size =
        (std::max)(sizes_of(Type::eBottomLevel).buildScratchSize, sizes_of(Type::eTopLevel).buildScratchSize);
    return allocate(size + scratch_alignment(), Usage::eStorageBuffer);
}

void ComputeTriangles::State::record(const vk::raii::CommandBuffer& commands, Type type,
                                     const TriangleStructure& structure) const {
    Inputs inputs = inputs_of(type);
    inputs.info.setDstAccelerationStructure(*structure.handle).setScratchData(scratch_address);
    commands.buildAccelerationStructuresKHR(inputs.info, inputs.ranges.data());
}

ComputeTriangles::ComputeTriangles(const ComputeDevice& device, const ComputeBuffer& vertices,
                                   std::size_t bytes_of_vertex, std::span<const std::uint32_t> opaque,
                                   std::span<const std::uint32_t> others) {
    if (!device.has_ray_queries())
        throw std::runtime_error("Vulkan: " + device.name() + " was opened without ray queries");
    const std::size_t most = properties_of(device.state_->on.physical).maxPrimitiveCount;
    const std::size_t count = opaque.size() / 3 + others.size() / 3;
    if (count > most)
        throw std::runtime_error("Vulkan: ray queries of " + device.name() + " take up to " +
                                 std::to_string(most) + " triangles, not " + std::to_string(count));
    state_ = std::make_shared<State>(device, vertices, bytes_of_vertex, opaque, others);
}

void ComputeTriangles::rebuild() const {
    state_->build();
}

}  // namespace demo
