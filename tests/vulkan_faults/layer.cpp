// SPDX-License-Identifier: MIT

// A Vulkan layer that makes a device fail, for tests of what is said then. LIGHTMESH_VULKAN_FAULT says how:
//
//     memory:N    from the N-th allocation on the device has no memory left
//     lost:N      from the N-th submission on the device is lost
//     feature     the device lacks a feature, so that it can't be opened
//     old         the device knows Vulkan 1.0 only

#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

namespace {

/// One instance and one device at a time: what they are called by further down.
PFN_vkGetInstanceProcAddr next_instance_address = nullptr;
PFN_vkGetDeviceProcAddr next_device_address = nullptr;
PFN_vkGetPhysicalDeviceProperties next_properties = nullptr;
VkInstance the_instance = VK_NULL_HANDLE;
VkDevice the_device = VK_NULL_HANDLE;
std::uint64_t allocations = 0;
std::uint64_t submissions = 0;

template <class Function>
Function next_of_device(const char* name) {
    return reinterpret_cast<Function>(next_device_address(the_device, name));
}

std::string_view fault() {
    const char* text = std::getenv("LIGHTMESH_VULKAN_FAULT");
    return text == nullptr ? "" : text;
}

/// Whether the fault is of this kind, and this is its N-th time or a later one.
bool fails(std::string_view kind, std::uint64_t time) {
    const std::string_view text = fault();
    return text.starts_with(kind) && text.size() > kind.size() + 1 &&
           time >= std::strtoull(text.data() + kind.size() + 1, nullptr, 10);
}

/// The link of the chain of layers that a structure for an instance or a device carries.
template <class Link, class Info>
Link* link_of(const Info* info, VkStructureType type) {
    auto* link = static_cast<const Link*>(info->pNext);
    while (link != nullptr && !(link->sType == type && link->function == VK_LAYER_LINK_INFO))
        link = static_cast<const Link*>(link->pNext);
    return const_cast<Link*>(link);
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info,
                                               const VkAllocationCallbacks* allocator, VkInstance* instance) {
    auto* link = link_of<VkLayerInstanceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (link == nullptr)
        return VK_ERROR_INITIALIZATION_FAILED;
    next_instance_address = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    const auto of_physical_devices = link->u.pLayerInfo->pfnNextGetPhysicalDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create =
        reinterpret_cast<PFN_vkCreateInstance>(next_instance_address(VK_NULL_HANDLE, "vkCreateInstance"));
    const VkResult result = create(info, allocator, instance);
    if (result != VK_SUCCESS)
        return result;
    the_instance = *instance;
    next_properties = reinterpret_cast<PFN_vkGetPhysicalDeviceProperties>(
        of_physical_devices(the_instance, "vkGetPhysicalDeviceProperties"));
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                             const VkAllocationCallbacks* allocator, VkDevice* device) {
    auto* link = link_of<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (link == nullptr)
        return VK_ERROR_INITIALIZATION_FAILED;
    if (fault() == "feature")
        return VK_ERROR_FEATURE_NOT_PRESENT;
    next_device_address = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(
        link->u.pLayerInfo->pfnNextGetInstanceProcAddr(the_instance, "vkCreateDevice"));
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const VkResult result = create(physical, info, allocator, device);
    if (result == VK_SUCCESS)
        the_device = *device;
    return result;
}

VKAPI_ATTR void VKAPI_CALL get_properties(VkPhysicalDevice physical, VkPhysicalDeviceProperties* properties) {
    next_properties(physical, properties);
    if (fault() == "old")
        properties->apiVersion = VK_API_VERSION_1_0;
}

VKAPI_ATTR VkResult VKAPI_CALL allocate_memory(VkDevice device, const VkMemoryAllocateInfo* info,
                                               const VkAllocationCallbacks* allocator,
                                               VkDeviceMemory* memory) {
    if (fails("memory", ++allocations))
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return next_of_device<PFN_vkAllocateMemory>("vkAllocateMemory")(device, info, allocator, memory);
}

VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* submits,
                                      VkFence fence) {
    if (fails("lost", ++submissions))
        return VK_ERROR_DEVICE_LOST;
    return next_of_device<PFN_vkQueueSubmit>("vkQueueSubmit")(queue, count, submits, fence);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_address(VkInstance instance, const char* name);
VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_address(VkDevice device, const char* name);

PFN_vkVoidFunction own(std::string_view name) {
    const auto function = [](auto* pointer) {
        return reinterpret_cast<PFN_vkVoidFunction>(pointer);
    };
    if (name == "vkGetInstanceProcAddr")
        return function(instance_address);
    if (name == "vkGetDeviceProcAddr")
        return function(device_address);
    if (name == "vkCreateInstance")
        return function(create_instance);
    if (name == "vkCreateDevice")
        return function(create_device);
    if (name == "vkGetPhysicalDeviceProperties")
        return function(get_properties);
    if (name == "vkAllocateMemory")
        return function(allocate_memory);
    if (name == "vkQueueSubmit")
        return function(submit);
    return nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_address(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction found = own(name);
    return found != nullptr ? found : next_instance_address(instance, name);
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_address(VkDevice device, const char* name) {
    const PFN_vkVoidFunction found = own(name);
    return found != nullptr ? found : next_device_address(device, name);
}

}  // namespace

extern "C" VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* interface) {
    interface->loaderLayerInterfaceVersion = 2;
    interface->pfnGetInstanceProcAddr = instance_address;
    interface->pfnGetDeviceProcAddr = device_address;
    interface->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}
