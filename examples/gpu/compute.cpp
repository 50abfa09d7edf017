// SPDX-License-Identifier: MIT
#include "compute.hpp"

#include "../render/stopwatch.hpp"
#include "compute_state.hpp"
#include "compute_triangles.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

namespace demo {

namespace {

vk::MemoryBarrier everything_before() {
    using Access = vk::AccessFlagBits;
    return {Access::eShaderWrite | Access::eTransferWrite,
            Access::eShaderRead | Access::eShaderWrite | Access::eUniformRead | Access::eIndirectCommandRead |
                Access::eTransferRead | Access::eTransferWrite | Access::eHostRead};
}

void wait_for_everything_before(const vk::raii::CommandBuffer& commands) {
    using Stage = vk::PipelineStageFlagBits;
    commands.pipelineBarrier(Stage::eComputeShader | Stage::eTransfer,
                             Stage::eComputeShader | Stage::eTransfer | Stage::eDrawIndirect | Stage::eHost,
                             {}, everything_before(), nullptr, nullptr);
}

}  // namespace

// ---- the device

struct ComputeCommands::Recording {
    const ComputeDevice::State& state;
    const vk::raii::CommandBuffer& commands;
};

ComputeDevice::ComputeDevice(const ComputeOptions& options) : state_(std::make_shared<State>(options)) {}

ComputeDevice ComputeDevice::opened_anew(bool ray_queries) const {
    return ComputeDevice({.device = state_->on.options.device, .ray_queries = ray_queries});
}

std::string ComputeDevice::name() const {
    return vulkan::name_of(state_->on.physical);
}

std::string ComputeDevice::driver() const {
    const auto properties = state_->on.physical.getProperties();
    if (properties.apiVersion >= VK_API_VERSION_1_2) {
        const auto chain =
            state_->on.physical
                .getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
        const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
        return std::string(driver.driverName.data()) + " " + driver.driverInfo.data();
    }
    return "driver " + std::to_string(properties.driverVersion);
}

bool ComputeDevice::has_ray_queries() const {
    return state_->has_ray_queries;
}

bool ComputeDevice::is_cpu() const {
    return state_->on.physical.getProperties().deviceType == vk::PhysicalDeviceType::eCpu;
}

std::size_t ComputeDevice::largest_buffer() const {
    return state_->limits.maxStorageBufferRange;
}

double ComputeDevice::run(const std::function<void(const ComputeCommands&)>& record) const {
    const std::scoped_lock lock(state_->busy);
    return in_words(state_->on, "while it computed", [&] {
        const Stopwatch watch;
        const auto& clock = state_->clock;
        state_->on.run([&](const vk::raii::CommandBuffer& commands) {
            if (clock) {
                commands.resetQueryPool(**clock, 0, 2);
                commands.writeTimestamp(vk::PipelineStageFlagBits::eTopOfPipe, **clock, 0);
            }
            record(ComputeCommands({*state_, commands}));
            wait_for_everything_before(commands);
            if (clock)
                commands.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, **clock, 1);
        });
        if (clock) {
            const auto ticks = clock->getResults<std::uint64_t>(
                0, 2, 2 * sizeof(std::uint64_t), sizeof(std::uint64_t),
                vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait);
            if (ticks.second[1] > ticks.second[0])
                return static_cast<double>(ticks.second[1] - ticks.second[0]) * 1e-9 *
                       static_cast<double>(state_->limits.timestampPeriod);
        }
        return watch.seconds();
    });
}

double ComputeDevice::least_time(const std::function<double()>& run) const {
    double least = run();
    if (is_cpu())
        return least;
    double spent = least;
    for (int i = 1; i < 5 || spent < 1.0; ++i) {
        const double seconds = run();
        least = (std::min)(least, seconds);
        spent += seconds;
    }
    return least;
}

// ---- buffers

ComputeBuffer::ComputeBuffer(const ComputeDevice& device, std::size_t size)
    : state_(std::make_shared<State>(device, size)) {
    device.run([&](const ComputeCommands& commands) { commands.fill(*this, 0, state_->room, 0); });
}

ComputeBuffer::ComputeBuffer(const ComputeDevice& device, std::span<const std::byte> bytes)
    : ComputeBuffer(device, bytes.size()) {
    write(0, bytes);
}

std::size_t ComputeBuffer::size() const {
    return state_->size;
}

void ComputeBuffer::write(std::size_t offset, std::span<const std::byte> bytes) const {
    const ComputeWrite one{offset, bytes};
    write(std::span(&one, 1));
}

void ComputeBuffer::write(std::span<const ComputeWrite> parts) const {
    for (const ComputeWrite& part : parts)
        state_->check(part.offset, part.bytes.size());
    ComputeDevice::State& device = *state_->device.state_;
    const std::scoped_lock lock(device.busy);
    in_words(device.on, "while it was written to", [&] {
        std::vector<vk::BufferCopy> copies;
        std::size_t staged = 0;
        const auto submit = [&] {
            if (copies.empty())
                return;
            device.on.run([&](const vk::raii::CommandBuffer& commands) {
                commands.copyBuffer(*device.staging().buffer, *state_->memory.buffer, copies);
                wait_for_everything_before(commands);
            });
            copies.clear();
            staged = 0;
        };
        for (const ComputeWrite& part : parts) {
            for (std::size_t done = 0; done < part.bytes.size();) {
                if (staged == staging_bytes)
                    submit();
                const std::size_t size = (std::min)(staging_bytes - staged, part.bytes.size() - done);
                std::memcpy(static_cast<std::byte*>(device.staging().mapped) + staged,
                            part.bytes.data() + done, size);
                copies.emplace_back(staged, part.offset + done, size);
                staged += size;
                done += size;
            }
        }
        submit();
    });
}

void ComputeBuffer::read(std::size_t offset, std::span<std::byte> bytes) const {
    state_->check(offset, bytes.size());
    ComputeDevice::State& device = *state_->device.state_;
    const std::scoped_lock lock(device.busy);
    in_words(device.on, "while it was read", [&] {
        for (std::size_t done = 0; done < bytes.size(); done += staging_bytes) {
            const std::size_t size = (std::min)(staging_bytes, bytes.size() - done);
            device.on.run([&](const vk::raii::CommandBuffer& commands) {
                commands.copyBuffer(*state_->memory.buffer, *device.staging().buffer,
                                    vk::BufferCopy(offset + done, 0, size));
                wait_for_everything_before(commands);
            });
            std::memcpy(bytes.data() + done, device.staging().mapped, size);
        }
    });
}

// ---- kernels

struct ComputeKernel::State {
    State(const ComputeDevice& on, std::span<const std::uint32_t> spirv,
          std::span<const ComputeBinding> bindings_, std::size_t push_bytes_)
        : device(on), bindings(bindings_.begin(), bindings_.end()), push_bytes(push_bytes_) {
        check();
        in_words(device.state_->on, "while a shader was made ready for it", [&] { make(spirv); });
    }

    void check() const {
        const vk::PhysicalDeviceLimits& limits = device.state_->limits;
        const auto count_of = [&](vk::DescriptorType type) {
            return static_cast<std::size_t>(std::ranges::count(bindings, type, type_of));
        };
        const auto require = [&](std::size_t needed, std::size_t limit, const char* what) {
            if (needed > limit)
                throw std::runtime_error("Vulkan: " + device.name() + " has room for " +
                                         std::to_string(limit) + " " + what + " a shader, not for " +
                                         std::to_string(needed));
        };
        require(count_of(vk::DescriptorType::eStorageBuffer), limits.maxPerStageDescriptorStorageBuffers,
                "storage buffers");
        require(count_of(vk::DescriptorType::eUniformBuffer), limits.maxPerStageDescriptorUniformBuffers,
                "uniform buffers");
        require(push_bytes, limits.maxPushConstantsSize, "bytes of push constants");
        for (const ComputeBinding& b : bindings) {
            require(b.set + 1, limits.maxBoundDescriptorSets, "sets of buffers");
            if (b.is_uniform)
                require(b.buffer().state_->room, limits.maxUniformBufferRange, "bytes of a uniform buffer");
        }
    }

    void make(std::span<const std::uint32_t> spirv) {
        const vk::raii::Device& on = device.state_->on.device;
        program = device.state_->program_of(key_of(spirv), [&] { return make_program(on, spirv); });
        if (program->sets.empty())
            return;
        std::map<vk::DescriptorType, std::uint32_t> counts;
        for (const ComputeBinding& b : bindings)
            ++counts[type_of(b)];
        std::vector<vk::DescriptorPoolSize> sizes;
        for (const auto& [type, count] : counts)
            sizes.emplace_back(type, count);
        const std::vector<vk::DescriptorSetLayout> handles = handles_of(program->sets);
        pool.emplace(on, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                                      static_cast<std::uint32_t>(handles.size()), sizes));
        sets.emplace(on, vk::DescriptorSetAllocateInfo(**pool, handles));
        for (const ComputeBinding& b : bindings)
            point_to(b);
    }

    /// All that a program is made of.
    std::vector<std::uint32_t> key_of(std::span<const std::uint32_t> spirv) const {
        std::vector<std::uint32_t> key(spirv.begin(), spirv.end());
        for (const ComputeBinding& b : bindings)
            key.insert(key.end(), {b.set, b.binding, static_cast<std::uint32_t>(type_of(b))});
        key.push_back(static_cast<std::uint32_t>(push_bytes));
        return key;
    }

    std::shared_ptr<const ComputeProgram> make_program(const vk::raii::Device& on,
                                                       std::span<const std::uint32_t> spirv) const {
        auto made = std::make_shared<ComputeProgram>();
        std::uint32_t set_count = 0;
        for (const ComputeBinding& b : bindings)
            set_count = (std::max)(set_count, b.set + 1);
        for (std::uint32_t set = 0; set < set_count; ++set) {
            std::vector<vk::DescriptorSetLayoutBinding> of_set;
            for (const ComputeBinding& b : bindings)
                if (b.set == set)
                    of_set.emplace_back(b.binding, type_of(b), 1, vk::ShaderStageFlagBits::eCompute);
            made->sets.emplace_back(on, vk::DescriptorSetLayoutCreateInfo().setBindings(of_set));
        }
        const std::vector<vk::DescriptorSetLayout> handles = handles_of(made->sets);
        auto layout_info = vk::PipelineLayoutCreateInfo().setSetLayouts(handles);
        const vk::PushConstantRange range(vk::ShaderStageFlagBits::eCompute, 0,
                                          static_cast<std::uint32_t>(push_bytes));
        if (push_bytes != 0)
            layout_info.setPushConstantRanges(range);
        made->layout.emplace(on, layout_info);
        const vk::raii::ShaderModule shader(on,
                                            vk::ShaderModuleCreateInfo({}, spirv.size_bytes(), spirv.data()));
        const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *shader, "main");
        made->pipeline.emplace(on, nullptr, vk::ComputePipelineCreateInfo({}, stage, **made->layout));
        return made;
    }

    static std::vector<vk::DescriptorSetLayout>
    handles_of(std::span<const vk::raii::DescriptorSetLayout> layouts) {
        std::vector<vk::DescriptorSetLayout> handles;
        for (const vk::raii::DescriptorSetLayout& layout : layouts)
            handles.push_back(*layout);
        return handles;
    }

    void point_to(const ComputeBinding& b) const {
        vk::WriteDescriptorSet write(*(*sets)[b.set], b.binding, 0, 1, type_of(b));
        vk::WriteDescriptorSetAccelerationStructureKHR triangles;
        vk::DescriptorBufferInfo whole;
        if (const auto* seen = std::get_if<ComputeTriangles>(&b.resource)) {
            triangles.setAccelerationStructures(*seen->state_->top.handle);
            write.setPNext(&triangles);
        } else {
            whole.setBuffer(*b.buffer().state_->memory.buffer).setRange(VK_WHOLE_SIZE);
            write.setPBufferInfo(&whole);
        }
        device.state_->on.device.updateDescriptorSets(write, nullptr);
    }

    static vk::DescriptorType type_of(const ComputeBinding& b) {
        if (std::holds_alternative<ComputeTriangles>(b.resource))
            return vk::DescriptorType::eAccelerationStructureKHR;
        return b.is_uniform ? vk::DescriptorType::eUniformBuffer : vk::DescriptorType::eStorageBuffer;
    }

    ComputeDevice device;
    std::vector<ComputeBinding> bindings;  ///< they keep the buffers and triangles alive
    std::size_t push_bytes;
    std::shared_ptr<const ComputeProgram> program;
    std::optional<vk::raii::DescriptorPool> pool;
    std::optional<vk::raii::DescriptorSets> sets;
};

ComputeKernel::ComputeKernel(const ComputeDevice& device, std::span<const std::uint32_t> spirv,
                             std::span<const ComputeBinding> bindings, std::size_t push_bytes)
    : state_(std::make_shared<State>(device, spirv, bindings, push_bytes)) {}

void ComputeKernel::bind(const ComputeBinding& binding) const {
    for (ComputeBinding& b : state_->bindings) {
        if (b.set == binding.set && b.binding == binding.binding &&
            State::type_of(b) == State::type_of(binding)) {
            b = binding;
            state_->point_to(b);
            return;
        }
    }
    throw std::out_of_range("Vulkan: a shader has no binding " + std::to_string(binding.binding) +
                            " of set " + std::to_string(binding.set));
}

// ---- commands

namespace {

void begin_dispatch(const vk::raii::CommandBuffer& commands, const ComputeProgram& program,
                    const vk::raii::DescriptorSets* sets, std::span<const std::byte> push) {
    wait_for_everything_before(commands);
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, **program.pipeline);
    if (sets != nullptr) {
        std::vector<vk::DescriptorSet> handles;
        for (const vk::raii::DescriptorSet& set : *sets)
            handles.push_back(*set);
        commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, **program.layout, 0, handles, nullptr);
    }
    if (!push.empty())
        commands.pushConstants<std::byte>(
            **program.layout, vk::ShaderStageFlagBits::eCompute, 0,
            vk::ArrayProxy<const std::byte>(static_cast<std::uint32_t>(push.size()), push.data()));
}

}  // namespace

void ComputeCommands::dispatch(const ComputeKernel& kernel, std::uint32_t x, std::uint32_t y, std::uint32_t z,
                               std::span<const std::byte> push) const {
    const auto& most = recording_.state.limits.maxComputeWorkGroupCount;
    if (x > most[0] || y > most[1] || z > most[2])
        throw std::runtime_error(
            "Vulkan: " + vulkan::name_of(recording_.state.on.physical) + " counts up to " +
            std::to_string(most[0]) + " x " + std::to_string(most[1]) + " x " + std::to_string(most[2]) +
            " workgroups, not " + std::to_string(x) + " x " + std::to_string(y) + " x " + std::to_string(z));
    const auto& of = *kernel.state_;
    begin_dispatch(recording_.commands, *of.program, of.sets ? &*of.sets : nullptr, push);
    recording_.commands.dispatch(x, y, z);
}

void ComputeCommands::dispatch_indirect(const ComputeKernel& kernel, const ComputeBuffer& counts,
                                        std::size_t offset, std::span<const std::byte> push) const {
    const auto& of = *kernel.state_;
    begin_dispatch(recording_.commands, *of.program, of.sets ? &*of.sets : nullptr, push);
    recording_.commands.dispatchIndirect(*counts.state_->memory.buffer, offset);
}

void ComputeCommands::fill(const ComputeBuffer& buffer, std::size_t offset, std::size_t size,
                           std::uint32_t word) const {
    wait_for_everything_before(recording_.commands);
    recording_.commands.fillBuffer(*buffer.state_->memory.buffer, offset, size, word);
}

}  // namespace demo
