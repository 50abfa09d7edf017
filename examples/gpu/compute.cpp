// SPDX-License-Identifier: MIT
#include "compute.hpp"

#include "../adapters/vulkan_depth_renderer.hpp"
#include "../render/stopwatch.hpp"

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

namespace demo {

namespace {

constexpr vk::BufferUsageFlags usage_of_buffers =
    vk::BufferUsageFlagBits::eStorageBuffer | vk::BufferUsageFlagBits::eUniformBuffer |
    vk::BufferUsageFlagBits::eIndirectBuffer | vk::BufferUsageFlagBits::eTransferSrc |
    vk::BufferUsageFlagBits::eTransferDst;

/// Copies between host and device go through so many bytes at a time.
constexpr std::size_t staging_bytes = std::size_t{16} << 20;

template <class Act>
auto in_words(const vulkan::Device& on, const std::string& what, Act&& act) {
    return vulkan::in_words(vulkan::name_of(on.physical), what, std::forward<Act>(act));
}

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

/// A shader made ready, for any buffers of its bindings.
struct ComputeProgram {
    std::vector<vk::raii::DescriptorSetLayout> sets;
    std::optional<vk::raii::PipelineLayout> layout;
    std::optional<vk::raii::Pipeline> pipeline;
};

struct ComputeDevice::State {
    explicit State(const ComputeOptions& options)
        : on({.device = options.device, .validate = options.validate, .on_message = options.on_message},
             vk::QueueFlagBits::eCompute),
          limits(on.physical.getProperties().limits) {
        if (on.physical.getProperties().apiVersion < VK_API_VERSION_1_1)
            throw std::runtime_error("Vulkan: " + vulkan::name_of(on.physical) + " is older than Vulkan 1.1");
        if (on.physical.getQueueFamilyProperties()[on.family].timestampValidBits != 0)
            in_words(on, "when it was opened", [&] {
                clock.emplace(on.device, vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, 2));
            });
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
    vulkan::Device on;
    vk::PhysicalDeviceLimits limits;
    std::optional<vk::raii::QueryPool> clock;
    std::optional<vulkan::HostBuffer> staging_buffer;
    /// By all that they are made of. Drivers take seconds to make one; who renders one picture after the
    /// other has the same kernels again.
    std::map<std::vector<std::uint32_t>, std::shared_ptr<const ComputeProgram>> programs;
    std::mutex programs_busy;
};

struct ComputeCommands::Recording {
    const ComputeDevice::State& state;
    const vk::raii::CommandBuffer& commands;
};

ComputeDevice::ComputeDevice(const ComputeOptions& options) : state_(std::make_shared<State>(options)) {}

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
            return vulkan::Buffer(on, room, usage_of_buffers, vk::MemoryPropertyFlagBits::eDeviceLocal, {});
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
        const auto uniform = static_cast<std::uint32_t>(
            std::ranges::count_if(bindings, [](const ComputeBinding& b) { return b.is_uniform; }));
        const auto storage = static_cast<std::uint32_t>(bindings.size()) - uniform;
        const auto require = [&](std::size_t needed, std::size_t limit, const char* what) {
            if (needed > limit)
                throw std::runtime_error("Vulkan: " + device.name() + " has room for " +
                                         std::to_string(limit) + " " + what + " a shader, not for " +
                                         std::to_string(needed));
        };
        require(storage, limits.maxPerStageDescriptorStorageBuffers, "storage buffers");
        require(uniform, limits.maxPerStageDescriptorUniformBuffers, "uniform buffers");
        require(push_bytes, limits.maxPushConstantsSize, "bytes of push constants");
        for (const ComputeBinding& b : bindings) {
            require(b.set + 1, limits.maxBoundDescriptorSets, "sets of buffers");
            if (b.is_uniform)
                require(b.buffer.state_->room, limits.maxUniformBufferRange, "bytes of a uniform buffer");
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
            key.insert(key.end(), {b.set, b.binding, b.is_uniform ? 1u : 0u});
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
        const vk::DescriptorBufferInfo whole(*b.buffer.state_->memory.buffer, 0, VK_WHOLE_SIZE);
        device.state_->on.device.updateDescriptorSets(
            vk::WriteDescriptorSet(*(*sets)[b.set], b.binding, 0, 1, type_of(b)).setPBufferInfo(&whole),
            nullptr);
    }

    static vk::DescriptorType type_of(const ComputeBinding& b) {
        return b.is_uniform ? vk::DescriptorType::eUniformBuffer : vk::DescriptorType::eStorageBuffer;
    }

    ComputeDevice device;
    std::vector<ComputeBinding> bindings;  ///< they keep the buffers alive
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
        if (b.set == binding.set && b.binding == binding.binding && b.is_uniform == binding.is_uniform) {
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
