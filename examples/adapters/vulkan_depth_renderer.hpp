// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/bounds.hpp>

#include <glm/common.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vulkan/vulkan_raii.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace demo {

/// Which device, and what to watch.
struct VulkanDepthOptions {
    /// Empty: the first discrete GPU, else the first device of the next kind (integrated, virtual, CPU). Else
    /// an index into `vulkan_device_names()`, or a part of a name.
    std::string device;
    /// Runs under VK_LAYER_KHRONOS_validation, which must be installed.
    bool validate = false;
    /// Called for each warning and error of the layers, where they report it.
    std::function<void(const std::string&)> on_message;
};

namespace vulkan {

/// Vertex shader: gl_Position = clip_from_eye * vec4(position - eye, 1), compiled from depth.vert.
inline constexpr std::uint32_t depth_shader[] = {
    0x07230203, 0x00010300, 0x000d000b, 0x00000028, 0x00000000, 0x00020011, 0x00000001, 0x0006000b,
    0x00000001, 0x4c534c47, 0x6474732e, 0x3035342e, 0x00000000, 0x0003000e, 0x00000000, 0x00000001,
    0x0007000f, 0x00000000, 0x00000004, 0x6e69616d, 0x00000000, 0x0000000d, 0x00000019, 0x00050048,
    0x0000000b, 0x00000000, 0x0000000b, 0x00000000, 0x00050048, 0x0000000b, 0x00000001, 0x0000000b,
    0x00000001, 0x00050048, 0x0000000b, 0x00000002, 0x0000000b, 0x00000003, 0x00050048, 0x0000000b,
    0x00000003, 0x0000000b, 0x00000004, 0x00030047, 0x0000000b, 0x00000002, 0x00040048, 0x00000012,
    0x00000000, 0x00000005, 0x00050048, 0x00000012, 0x00000000, 0x00000023, 0x00000000, 0x00050048,
    0x00000012, 0x00000000, 0x00000007, 0x00000010, 0x00050048, 0x00000012, 0x00000001, 0x00000023,
    0x00000040, 0x00030047, 0x00000012, 0x00000002, 0x00040047, 0x00000019, 0x0000001e, 0x00000000,
    0x00020013, 0x00000002, 0x00030021, 0x00000003, 0x00000002, 0x00030016, 0x00000006, 0x00000020,
    0x00040017, 0x00000007, 0x00000006, 0x00000004, 0x00040015, 0x00000008, 0x00000020, 0x00000000,
    0x0004002b, 0x00000008, 0x00000009, 0x00000001, 0x0004001c, 0x0000000a, 0x00000006, 0x00000009,
    0x0006001e, 0x0000000b, 0x00000007, 0x00000006, 0x0000000a, 0x0000000a, 0x00040020, 0x0000000c,
    0x00000003, 0x0000000b, 0x0004003b, 0x0000000c, 0x0000000d, 0x00000003, 0x00040015, 0x0000000e,
    0x00000020, 0x00000001, 0x0004002b, 0x0000000e, 0x0000000f, 0x00000000, 0x00040018, 0x00000010,
    0x00000007, 0x00000004, 0x00040017, 0x00000011, 0x00000006, 0x00000003, 0x0004001e, 0x00000012,
    0x00000010, 0x00000011, 0x00040020, 0x00000013, 0x00000009, 0x00000012, 0x0004003b, 0x00000013,
    0x00000014, 0x00000009, 0x00040020, 0x00000015, 0x00000009, 0x00000010, 0x00040020, 0x00000018,
    0x00000001, 0x00000011, 0x0004003b, 0x00000018, 0x00000019, 0x00000001, 0x0004002b, 0x0000000e,
    0x0000001b, 0x00000001, 0x00040020, 0x0000001c, 0x00000009, 0x00000011, 0x0004002b, 0x00000006,
    0x00000020, 0x3f800000, 0x00040020, 0x00000026, 0x00000003, 0x00000007, 0x00050036, 0x00000002,
    0x00000004, 0x00000000, 0x00000003, 0x000200f8, 0x00000005, 0x00050041, 0x00000015, 0x00000016,
    0x00000014, 0x0000000f, 0x0004003d, 0x00000010, 0x00000017, 0x00000016, 0x0004003d, 0x00000011,
    0x0000001a, 0x00000019, 0x00050041, 0x0000001c, 0x0000001d, 0x00000014, 0x0000001b, 0x0004003d,
    0x00000011, 0x0000001e, 0x0000001d, 0x00050083, 0x00000011, 0x0000001f, 0x0000001a, 0x0000001e,
    0x00050051, 0x00000006, 0x00000021, 0x0000001f, 0x00000000, 0x00050051, 0x00000006, 0x00000022,
    0x0000001f, 0x00000001, 0x00050051, 0x00000006, 0x00000023, 0x0000001f, 0x00000002, 0x00070050,
    0x00000007, 0x00000024, 0x00000021, 0x00000022, 0x00000023, 0x00000020, 0x00050091, 0x00000007,
    0x00000025, 0x00000017, 0x00000024, 0x00050041, 0x00000026, 0x00000027, 0x0000000d, 0x0000000f,
    0x0003003e, 0x00000027, 0x00000025, 0x000100fd, 0x00010038};

/// The shader's push constants.
struct PushedView {
    glm::mat4 clip_from_eye;
    glm::vec3 eye;
};
static_assert(sizeof(glm::vec3) == 12 && sizeof(PushedView) == 76, "glm::vec3 and glm::mat4 must be packed");

inline std::runtime_error no_device(const std::string& why) {
    return std::runtime_error(
        "Vulkan: " + why +
        ". Install a driver for your GPU, or Mesa's software renderer: on Debian and Ubuntu `apt "
        "install libvulkan1 mesa-vulkan-drivers`. Or ask for another depth renderer");
}

/// The result of act(); what Vulkan throws becomes one sentence about a device.
template <class Act>
auto in_words(const std::string& device, const std::string& what, Act&& act) {
    const auto said = [&](const std::string& why) {
        return std::runtime_error("Vulkan: " + device + " " + why + ", " + what);
    };
    try {
        return act();
    } catch (const vk::OutOfDeviceMemoryError&) {
        throw said("has no memory left");
    } catch (const vk::OutOfHostMemoryError&) {
        throw said("finds no memory left on the host");
    } catch (const vk::DeviceLostError&) {
        throw said("was lost (its driver gave up, or stopped work that took too long)");
    } catch (const vk::FeatureNotPresentError&) {
        throw said("lacks a feature");
    } catch (const vk::SystemError& error) {
        throw said(std::string("failed (") + error.what() + ")");
    }
}

inline vk::raii::Context load() {
    try {
        return vk::raii::Context();
    } catch (const std::runtime_error&) {
        throw no_device("the loader libvulkan.so.1 is not there");
    }
}

inline VKAPI_ATTR VkBool32 VKAPI_CALL pass_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                   VkDebugUtilsMessageTypeFlagsEXT,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data,
                                                   void* options) {
    const auto& on_message = static_cast<const VulkanDepthOptions*>(options)->on_message;
    if (on_message)
        on_message(data->pMessage);
    return VK_FALSE;
}

inline vk::DebugUtilsMessengerCreateInfoEXT messenger_info(const VulkanDepthOptions& options) {
    using Severity = vk::DebugUtilsMessageSeverityFlagBitsEXT;
    using Kind = vk::DebugUtilsMessageTypeFlagBitsEXT;
    return vk::DebugUtilsMessengerCreateInfoEXT()
        .setMessageSeverity(Severity::eWarning | Severity::eError)
        .setMessageType(Kind::eGeneral | Kind::eValidation | Kind::ePerformance)
        .setPfnUserCallback(&pass_message)
        .setPUserData(const_cast<VulkanDepthOptions*>(&options));
}

inline vk::raii::Instance make_instance(const vk::raii::Context& context, const VulkanDepthOptions& options) {
    constexpr const char* layer = "VK_LAYER_KHRONOS_validation";
    constexpr const char* debug_utils = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const auto application =
        vk::ApplicationInfo().setPApplicationName("lightmesh").setApiVersion(VK_API_VERSION_1_1);
    auto info = vk::InstanceCreateInfo().setPApplicationInfo(&application);
    const auto messages = messenger_info(options);
    if (options.validate)
        info.setPEnabledLayerNames(layer).setPEnabledExtensionNames(debug_utils).setPNext(&messages);
    try {
        return {context, info};
    } catch (const vk::LayerNotPresentError&) {
        throw std::runtime_error(
            "Vulkan: the validation layer is not there: on Debian and Ubuntu `apt install "
            "vulkan-validationlayers`");
    } catch (const vk::SystemError& error) {
        throw no_device(std::string("no driver is there (") + error.what() + ")");
    }
}

inline std::string name_of(const vk::raii::PhysicalDevice& device) {
    return device.getProperties().deviceName.data();
}

inline std::vector<vk::raii::PhysicalDevice> devices_of(const vk::raii::Instance& instance) {
    std::vector<vk::raii::PhysicalDevice> devices;
    try {
        devices = vk::raii::PhysicalDevices(instance);
    } catch (const vk::SystemError& error) {
        throw no_device(std::string("no device answers (") + error.what() + ")");
    }
    if (devices.empty())
        throw no_device("there is no device");
    return devices;
}

/// Small is good.
inline int rank(const vk::raii::PhysicalDevice& device) {
    switch (device.getProperties().deviceType) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
        return 0;
    case vk::PhysicalDeviceType::eIntegratedGpu:
        return 1;
    case vk::PhysicalDeviceType::eVirtualGpu:
        return 2;
    case vk::PhysicalDeviceType::eCpu:
        return 3;
    default:
        return 4;
    }
}

inline vk::raii::PhysicalDevice choose_device(const vk::raii::Instance& instance, const std::string& wanted) {
    auto devices = devices_of(instance);
    if (wanted.empty())
        return *std::ranges::min_element(devices, {}, rank);
    std::string names;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const std::string name = name_of(devices[i]);
        if (wanted == std::to_string(i) || name.find(wanted) != std::string::npos)
            return devices[i];
        names += "\n  " + std::to_string(i) + ": " + name;
    }
    throw std::runtime_error("Vulkan: no device \"" + wanted + "\"; there are:" + names);
}

/// The first family of queues that take this kind of work: to draw, or to compute.
inline std::uint32_t family_for(const vk::raii::PhysicalDevice& device, vk::QueueFlagBits work) {
    const auto families = device.getQueueFamilyProperties();
    const auto found = std::ranges::find_if(families, [work](const vk::QueueFamilyProperties& family) {
        return static_cast<bool>(family.queueFlags & work);
    });
    if (found == families.end())
        throw std::runtime_error("Vulkan: " + name_of(device) + " cannot " +
                                 (work == vk::QueueFlagBits::eGraphics ? "draw" : "compute"));
    return static_cast<std::uint32_t>(found - families.begin());
}

/// Extensions of a device beyond Vulkan 1.1, and the features to turn on.
struct Extensions {
    std::vector<const char*> names;
    const void* features = nullptr;  ///< a chain, which must live until the device is open
};

/// A device with one queue. Keep it where it is: others point to it.
struct Device {
    /// `extend(physical)`: the `Extensions` to open the chosen device with.
    template <class Extend>
    Device(VulkanDepthOptions chosen, vk::QueueFlagBits work, Extend&& extend)
        : options(std::move(chosen)), context(load()), instance(make_instance(context, options)),
          physical(choose_device(instance, options.device)), family(family_for(physical, work)),
          device(make_device(while_opening([&] { return extend(physical); }))), queue(device, family, 0),
          commands(make_pool()) {
        if (options.validate)
            while_opening([&] { messenger.emplace(instance, messenger_info(options)); });
    }
    explicit Device(VulkanDepthOptions chosen)
        : Device(std::move(chosen), vk::QueueFlagBits::eGraphics,
                 [](const vk::raii::PhysicalDevice&) { return Extensions{}; }) {}
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VulkanDepthOptions options;
    vk::raii::Context context;
    vk::raii::Instance instance;
    std::optional<vk::raii::DebugUtilsMessengerEXT> messenger;
    vk::raii::PhysicalDevice physical;
    std::uint32_t family;
    vk::raii::Device device;
    vk::raii::Queue queue;
    vk::raii::CommandPool commands;

    /// A memory type that has all of `needed`, and `wished` too if there is one.
    std::uint32_t memory_type(std::uint32_t allowed, vk::MemoryPropertyFlags needed,
                              vk::MemoryPropertyFlags wished) const {
        const auto memory = physical.getMemoryProperties();
        for (const vk::MemoryPropertyFlags flags : {needed | wished, needed})
            for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i)
                if ((allowed >> i & 1) != 0 && (memory.memoryTypes[i].propertyFlags & flags) == flags)
                    return i;
        throw std::runtime_error("Vulkan: " + name_of(physical) + " has no memory of the kind needed");
    }

    /// Records commands by record(buffer), submits them once and waits until they are done.
    template <class Record>
    void run(Record&& record) const {
        const vk::raii::CommandBuffers buffers(
            device, vk::CommandBufferAllocateInfo(*commands, vk::CommandBufferLevel::ePrimary, 1));
        const vk::raii::CommandBuffer& buffer = buffers.front();
        buffer.begin(vk::CommandBufferBeginInfo(vk::CommandBufferUsageFlagBits::eOneTimeSubmit));
        record(buffer);
        buffer.end();
        const vk::raii::Fence done(device, vk::FenceCreateInfo());
        queue.submit(vk::SubmitInfo().setCommandBuffers(*buffer), *done);
        while (device.waitForFences(*done, true, std::numeric_limits<std::uint64_t>::max()) !=
               vk::Result::eSuccess) {
        }
    }

private:
    template <class Act>
    auto while_opening(Act&& act) const {
        return in_words(name_of(physical), "when it was opened", std::forward<Act>(act));
    }

    vk::raii::Device make_device(const Extensions& extensions) const {
        const float priority = 1.0f;
        const vk::DeviceQueueCreateInfo one_queue({}, family, 1, &priority);
        return while_opening([&] {
            return vk::raii::Device(physical, vk::DeviceCreateInfo()
                                                  .setQueueCreateInfos(one_queue)
                                                  .setPEnabledExtensionNames(extensions.names)
                                                  .setPNext(extensions.features));
        });
    }

    vk::raii::CommandPool make_pool() const {
        return while_opening([&] {
            return vk::raii::CommandPool(
                device, vk::CommandPoolCreateInfo(vk::CommandPoolCreateFlagBits::eTransient, family));
        });
    }
};

/// A buffer and its memory.
struct Buffer {
    Buffer(const Device& on, std::size_t size, vk::BufferUsageFlags usage, vk::MemoryPropertyFlags needed,
           vk::MemoryPropertyFlags wished)
        : buffer(on.device, vk::BufferCreateInfo({}, size, usage)),
          memory(allocate(on, usage, needed, wished)) {
        buffer.bindMemory(*memory, 0);
    }

    vk::raii::Buffer buffer;
    vk::raii::DeviceMemory memory;

private:
    vk::raii::DeviceMemory allocate(const Device& on, vk::BufferUsageFlags usage,
                                    vk::MemoryPropertyFlags needed, vk::MemoryPropertyFlags wished) const {
        const auto requirements = buffer.getMemoryRequirements();
        const vk::MemoryAllocateFlagsInfo with_address(vk::MemoryAllocateFlagBits::eDeviceAddress);
        auto info = vk::MemoryAllocateInfo(requirements.size,
                                           on.memory_type(requirements.memoryTypeBits, needed, wished));
        if (usage & vk::BufferUsageFlagBits::eShaderDeviceAddress)
            info.setPNext(&with_address);
        return {on.device, info};
    }
};

/// A buffer that the host can read or write at any time.
struct HostBuffer : Buffer {
    HostBuffer(const Device& on, std::size_t size, vk::BufferUsageFlags usage)
        : Buffer(on, size, usage,
                 vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent,
                 vk::MemoryPropertyFlagBits::eHostCached),
          mapped(memory.mapMemory(0, VK_WHOLE_SIZE)) {}

    void* mapped;
};

/// A copy of `bytes` in the device's own memory.
inline Buffer upload(const Device& on, std::span<const std::byte> bytes, vk::BufferUsageFlags usage) {
    const HostBuffer staging(on, bytes.size(), vk::BufferUsageFlagBits::eTransferSrc);
    std::memcpy(staging.mapped, bytes.data(), bytes.size());
    Buffer copy(on, bytes.size(), usage | vk::BufferUsageFlagBits::eTransferDst,
                vk::MemoryPropertyFlagBits::eDeviceLocal, {});
    on.run([&](const vk::raii::CommandBuffer& commands) {
        commands.copyBuffer(*staging.buffer, *copy.buffer, vk::BufferCopy(0, 0, bytes.size()));
    });
    return copy;
}

/// Cleared to nothing, drawn into, then copied from: the dependencies make each of these wait for the one
/// before, also from pass to pass.
inline vk::raii::RenderPass make_pass(const Device& on) {
    const vk::AttachmentDescription depth({}, vk::Format::eD32Sfloat, vk::SampleCountFlagBits::e1,
                                          vk::AttachmentLoadOp::eClear, vk::AttachmentStoreOp::eStore,
                                          vk::AttachmentLoadOp::eDontCare, vk::AttachmentStoreOp::eDontCare,
                                          vk::ImageLayout::eUndefined, vk::ImageLayout::eTransferSrcOptimal);
    const vk::AttachmentReference reference(0, vk::ImageLayout::eDepthStencilAttachmentOptimal);
    const auto subpass = vk::SubpassDescription().setPDepthStencilAttachment(&reference);
    using Stage = vk::PipelineStageFlagBits;
    using Access = vk::AccessFlagBits;
    const auto tests = Stage::eEarlyFragmentTests | Stage::eLateFragmentTests;
    const auto writes = Access::eDepthStencilAttachmentRead | Access::eDepthStencilAttachmentWrite;
    const std::array dependencies{
        vk::SubpassDependency(VK_SUBPASS_EXTERNAL, 0, Stage::eTransfer | tests, tests,
                              Access::eTransferRead | Access::eDepthStencilAttachmentWrite, writes),
        vk::SubpassDependency(0, VK_SUBPASS_EXTERNAL, tests, Stage::eTransfer,
                              Access::eDepthStencilAttachmentWrite, Access::eTransferRead)};
    return {on.device, vk::RenderPassCreateInfo().setAttachments(depth).setSubpasses(subpass).setDependencies(
                           dependencies)};
}

inline vk::raii::PipelineLayout make_layout(const Device& on) {
    const vk::PushConstantRange range(vk::ShaderStageFlagBits::eVertex, 0, sizeof(PushedView));
    return {on.device, vk::PipelineLayoutCreateInfo().setPushConstantRanges(range)};
}

/// Triangles of both sides, nearest first by reversed depth, pictures of any size.
inline vk::raii::Pipeline make_pipeline(const Device& on, const vk::raii::RenderPass& pass,
                                        const vk::raii::PipelineLayout& layout) {
    const vk::raii::ShaderModule shader(on.device, vk::ShaderModuleCreateInfo().setCode(depth_shader));
    const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eVertex, *shader, "main");
    const vk::VertexInputBindingDescription binding(0, sizeof(glm::vec3), vk::VertexInputRate::eVertex);
    const vk::VertexInputAttributeDescription position(0, 0, vk::Format::eR32G32B32Sfloat, 0);
    const auto input = vk::PipelineVertexInputStateCreateInfo()
                           .setVertexBindingDescriptions(binding)
                           .setVertexAttributeDescriptions(position);
    const vk::PipelineInputAssemblyStateCreateInfo assembly({}, vk::PrimitiveTopology::eTriangleList);
    const vk::PipelineViewportStateCreateInfo viewport({}, 1, nullptr, 1, nullptr);
    const auto rasterization = vk::PipelineRasterizationStateCreateInfo()
                                   .setCullMode(vk::CullModeFlagBits::eNone)
                                   .setLineWidth(1.0f);
    const vk::PipelineMultisampleStateCreateInfo multisample({}, vk::SampleCountFlagBits::e1);
    const vk::PipelineDepthStencilStateCreateInfo depth({}, true, true, vk::CompareOp::eGreater);
    const std::array changing{vk::DynamicState::eViewport, vk::DynamicState::eScissor};
    const auto dynamic = vk::PipelineDynamicStateCreateInfo().setDynamicStates(changing);
    return {on.device, nullptr,
            vk::GraphicsPipelineCreateInfo()
                .setStages(stage)
                .setPVertexInputState(&input)
                .setPInputAssemblyState(&assembly)
                .setPViewportState(&viewport)
                .setPRasterizationState(&rasterization)
                .setPMultisampleState(&multisample)
                .setPDepthStencilState(&depth)
                .setPDynamicState(&dynamic)
                .setLayout(*layout)
                .setRenderPass(*pass)};
}

/// A D32 picture to draw into, and room on the host for copies of `views` such pictures.
struct Target {
    Target(const Device& on, const vk::raii::RenderPass& pass, std::uint32_t side, std::size_t count)
        : resolution(side), views(count), image(on.device, image_info(side)), memory(allocate(on)),
          view(make_view(on)), frame(on.device, vk::FramebufferCreateInfo({}, *pass, *view, side, side, 1)),
          copies(on, count * bytes_per_view(side), vk::BufferUsageFlagBits::eTransferDst) {}

    static std::size_t bytes_per_view(std::uint32_t side) { return sizeof(float) * side * side; }

    std::uint32_t resolution;
    std::size_t views;
    vk::raii::Image image;
    vk::raii::DeviceMemory memory;
    vk::raii::ImageView view;
    vk::raii::Framebuffer frame;
    HostBuffer copies;

private:
    static vk::ImageCreateInfo image_info(std::uint32_t side) {
        return vk::ImageCreateInfo()
            .setImageType(vk::ImageType::e2D)
            .setFormat(vk::Format::eD32Sfloat)
            .setExtent({side, side, 1})
            .setMipLevels(1)
            .setArrayLayers(1)
            .setUsage(vk::ImageUsageFlagBits::eDepthStencilAttachment | vk::ImageUsageFlagBits::eTransferSrc);
    }

    vk::raii::DeviceMemory allocate(const Device& on) const {
        const auto requirements = image.getMemoryRequirements();
        const auto type =
            on.memory_type(requirements.memoryTypeBits, vk::MemoryPropertyFlagBits::eDeviceLocal, {});
        vk::raii::DeviceMemory fresh(on.device, vk::MemoryAllocateInfo(requirements.size, type));
        image.bindMemory(*fresh, 0);
        return fresh;
    }

    vk::raii::ImageView make_view(const Device& on) const {
        return {on.device, vk::ImageViewCreateInfo({}, *image, vk::ImageViewType::e2D, vk::Format::eD32Sfloat,
                                                   {}, {vk::ImageAspectFlagBits::eDepth, 0, 1, 0, 1})};
    }
};

}  // namespace vulkan

/// Names of the devices that there are, in the order of their indices. Throws std::runtime_error that says
/// what to install if there is none.
inline std::vector<std::string> vulkan_device_names() {
    const vk::raii::Context context = vulkan::load();
    const vk::raii::Instance instance = vulkan::make_instance(context, {});
    std::vector<std::string> names;
    for (const auto& device : vulkan::devices_of(instance))
        names.push_back(vulkan::name_of(device));
    return names;
}

/// A `lightmesh::DepthRenderer` on Vulkan 1.1, without a window: D32 depth, reversed, both sides of all
/// triangles; many views in one submission. Copies share the device and one copy of the triangles, and wait
/// for each other.
///
/// Needs Vulkan-Hpp (vulkan_raii.hpp) to compile and a Vulkan driver to run; links to nothing but libdl. Copy
/// it into your program.
class VulkanDepthRenderer {
public:
    /// Copies the triangles (three indices each, positions in world units) to the device. Throws
    /// std::invalid_argument for no triangles, an index too large and a position that is not finite;
    /// std::runtime_error that says what to install where there is no loader, driver or device, one that
    /// lists the devices if none fits, and one sentence about what fails within Vulkan.
    VulkanDepthRenderer(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                        const VulkanDepthOptions& options = {}) {
        check(positions, indices);
        auto on = std::make_unique<const vulkan::Device>(options);
        vulkan::in_words(vulkan::name_of(on->physical), "while triangles were copied to it",
                         [&] { state_ = std::make_shared<State>(std::move(on), positions, indices); });
    }

    /// The device that was chosen.
    std::string device_name() const { return vulkan::name_of(state_->on->physical); }

    /// Its largest picture.
    int largest_resolution() const {
        const auto limits = state_->on->physical.getProperties().limits;
        return static_cast<int>((std::min)(
            {limits.maxImageDimension2D, limits.maxFramebufferWidth, limits.maxFramebufferHeight}));
    }

    lightmesh::Bounds bounds() const { return state_->bounds; }

    void render_depth(const lightmesh::DepthView& view, std::span<float> distance) {
        render_depth(std::span(&view, 1), std::span<const std::span<float>>(&distance, 1));
    }

    /// Views of one resolution. As many of them go into a submission as fit into 512 MiB, at least one.
    void render_depth(std::span<const lightmesh::DepthView> views,
                      std::span<const std::span<float>> distances) {
        const std::scoped_lock lock(state_->busy);
        const auto side = static_cast<std::uint32_t>(views.front().resolution);
        if (views.front().resolution > largest_resolution())
            throw std::runtime_error("Vulkan: " + device_name() + " renders pictures of up to " +
                                     std::to_string(largest_resolution()) + " texels, not " +
                                     std::to_string(side));
        constexpr std::size_t most_bytes = std::size_t{512} << 20;
        const std::size_t at_once =
            (std::max)(std::size_t{1}, most_bytes / vulkan::Target::bytes_per_view(side));
        for (std::size_t first = 0; first < views.size(); first += at_once) {
            const std::size_t count = (std::min)(at_once, views.size() - first);
            vulkan::in_words(device_name(), "while it rendered depths", [&] {
                state_->render(views.subspan(first, count), distances.subspan(first, count));
            });
        }
    }

private:
    struct State {
        State(std::unique_ptr<const vulkan::Device> device, std::span<const glm::vec3> positions,
              std::span<const std::uint32_t> triangles)
            : on(std::move(device)), pass(vulkan::make_pass(*on)), layout(vulkan::make_layout(*on)),
              pipeline(vulkan::make_pipeline(*on, pass, layout)),
              vertices(vulkan::upload(*on, std::as_bytes(positions), vk::BufferUsageFlagBits::eVertexBuffer)),
              indices(vulkan::upload(*on, std::as_bytes(triangles), vk::BufferUsageFlagBits::eIndexBuffer)),
              index_count(static_cast<std::uint32_t>(triangles.size())), bounds{positions[triangles[0]],
                                                                                positions[triangles[0]]} {
            for (const std::uint32_t i : triangles) {
                bounds.low = glm::min(bounds.low, positions[i]);
                bounds.high = glm::max(bounds.high, positions[i]);
            }
        }

        void render(std::span<const lightmesh::DepthView> views,
                    std::span<const std::span<float>> distances) {
            const auto side = static_cast<std::uint32_t>(views.front().resolution);
            if (!target || target->resolution != side || target->views < views.size()) {
                target.reset();
                target.emplace(*on, pass, side, views.size());
            }
            on->run([&](const vk::raii::CommandBuffer& commands) {
                begin(commands);
                for (std::size_t i = 0; i < views.size(); ++i)
                    draw(commands, views[i], i);
                const vk::MemoryBarrier written(vk::AccessFlagBits::eTransferWrite,
                                                vk::AccessFlagBits::eHostRead);
                commands.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer,
                                         vk::PipelineStageFlagBits::eHost, {}, written, nullptr, nullptr);
            });
            for (std::size_t i = 0; i < views.size(); ++i)
                read(views[i], i, distances[i]);
        }

        void begin(const vk::raii::CommandBuffer& commands) const {
            const auto side = static_cast<float>(target->resolution);
            commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *pipeline);
            commands.setViewport(0, vk::Viewport(0.0f, 0.0f, side, side, 0.0f, 1.0f));
            commands.setScissor(0, vk::Rect2D({0, 0}, {target->resolution, target->resolution}));
            commands.bindVertexBuffers(0, *vertices.buffer, vk::DeviceSize{0});
            commands.bindIndexBuffer(*indices.buffer, 0, vk::IndexType::eUint32);
        }

        void draw(const vk::raii::CommandBuffer& commands, const lightmesh::DepthView& view,
                  std::size_t place) const {
            const std::uint32_t side = target->resolution;
            const vk::ClearValue nothing(vk::ClearDepthStencilValue(0.0f, 0));
            const vk::RenderPassBeginInfo info(*pass, *target->frame, vk::Rect2D({0, 0}, {side, side}),
                                               nothing);
            commands.beginRenderPass(info, vk::SubpassContents::eInline);
            const vulkan::PushedView pushed{view.clip_from_eye(), view.eye};
            commands.pushConstants<vulkan::PushedView>(*layout, vk::ShaderStageFlagBits::eVertex, 0, pushed);
            commands.drawIndexed(index_count, 1, 0, 0, 0);
            commands.endRenderPass();
            const vk::BufferImageCopy whole(place * vulkan::Target::bytes_per_view(side), 0, 0,
                                            {vk::ImageAspectFlagBits::eDepth, 0, 0, 1}, {}, {side, side, 1});
            commands.copyImageToBuffer(*target->image, vk::ImageLayout::eTransferSrcOptimal,
                                       *target->copies.buffer, whole);
        }

        void read(const lightmesh::DepthView& view, std::size_t place, std::span<float> distance) const {
            const auto side = static_cast<std::size_t>(view.resolution);
            const float* depth = static_cast<const float*>(target->copies.mapped) + place * side * side;
            for (int row = 0; row < view.resolution; ++row)
                for (int column = 0; column < view.resolution; ++column) {
                    const auto texel =
                        static_cast<std::size_t>(row) * side + static_cast<std::size_t>(column);
                    distance[texel] = view.distance(column, row, depth[texel]);
                }
        }

        std::mutex busy;
        std::unique_ptr<const vulkan::Device> on;
        vk::raii::RenderPass pass;
        vk::raii::PipelineLayout layout;
        vk::raii::Pipeline pipeline;
        vulkan::Buffer vertices;
        vulkan::Buffer indices;
        std::uint32_t index_count;
        lightmesh::Bounds bounds;
        std::optional<vulkan::Target> target;
    };

    static void check(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices) {
        if (indices.empty() || indices.size() % 3 != 0)
            throw std::invalid_argument(
                "Vulkan depth renderer: there are " + std::to_string(indices.size()) +
                " indices; it needs three for each triangle, and at least one triangle");
        const std::uint32_t largest = *std::ranges::max_element(indices);
        if (largest >= positions.size())
            throw std::invalid_argument("Vulkan depth renderer: index " + std::to_string(largest) +
                                        " is too large for " + std::to_string(positions.size()) +
                                        " positions");
        const auto wrong = std::ranges::find_if(positions, [](const glm::vec3& p) {
            return !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
        });
        if (wrong != positions.end())
            throw std::invalid_argument("Vulkan depth renderer: position " +
                                        std::to_string(wrong - positions.begin()) + " is not finite");
    }

    std::shared_ptr<State> state_;
};

}  // namespace demo
