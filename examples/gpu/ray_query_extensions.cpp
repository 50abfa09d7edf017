// SPDX-License-Identifier: MIT
#include "ray_query_extensions.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>
#include <string>

namespace demo {

namespace {

constexpr std::array extension_names{
    VK_KHR_RAY_QUERY_EXTENSION_NAME,
    VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
    VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
    VK_KHR_BUFFER_DEVICE_ADDRESS_EXTENSION_NAME,
    VK_EXT_DESCRIPTOR_INDEXING_EXTENSION_NAME,
    VK_KHR_SPIRV_1_4_EXTENSION_NAME,
    VK_KHR_SHADER_FLOAT_CONTROLS_EXTENSION_NAME,
};

using RayQueryFeatures = vk::PhysicalDeviceRayQueryFeaturesKHR;
using StructureFeatures = vk::PhysicalDeviceAccelerationStructureFeaturesKHR;
using AddressFeatures = vk::PhysicalDeviceBufferDeviceAddressFeatures;

bool has_ray_queries(const vk::raii::PhysicalDevice& device) {
    std::set<std::string> known;
    for (const vk::ExtensionProperties& extension : device.enumerateDeviceExtensionProperties())
        known.emplace(extension.extensionName.data());
    if (!std::ranges::all_of(extension_names, [&](const char* name) { return known.contains(name); }))
        return false;
    const auto features = device.getFeatures2<vk::PhysicalDeviceFeatures2, RayQueryFeatures,
                                              StructureFeatures, AddressFeatures>();
    return features.get<RayQueryFeatures>().rayQuery != 0 &&
           features.get<StructureFeatures>().accelerationStructure != 0 &&
           features.get<AddressFeatures>().bufferDeviceAddress != 0;
}

}  // namespace

bool opens_with_ray_queries(const vk::raii::PhysicalDevice& device, const std::optional<bool>& are_wanted) {
    const bool is_cpu = device.getProperties().deviceType == vk::PhysicalDeviceType::eCpu;
    if (!are_wanted.value_or(!is_cpu))
        return false;
    const bool are_there = has_ray_queries(device);
    if (are_wanted.has_value() && !are_there)
        throw std::runtime_error("Vulkan: " + vulkan::name_of(device) + " has no ray queries");
    return are_there;
}

vulkan::Extensions ray_query_extensions() {
    static const vk::StructureChain<vk::DeviceCreateInfo, RayQueryFeatures, StructureFeatures,
                                    AddressFeatures>
        features{{}, {true}, {true}, {true}};
    return {{extension_names.begin(), extension_names.end()}, features.get().pNext};
}

}  // namespace demo
