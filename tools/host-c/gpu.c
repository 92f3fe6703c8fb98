/* The host's own Vulkan: instance, device, queue, memory. Where dermis has a say in it, a comment tells so. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host.h"

static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                 VkDebugUtilsMessageTypeFlagsEXT types,
                                                 const VkDebugUtilsMessengerCallbackDataEXT *data, void *user)
{
    struct gpu *gpu = user;
    (void)severity;
    (void)types;
    gpu->complaints++;
    fprintf(stderr, "validation: %s\n", data->pMessage);
    return VK_FALSE;
}

/* With DERMIS_VALIDATION=1 in the environment the validation layers watch the host and dermis alike. */
static void create_instance(struct gpu *gpu)
{
    static const char *const layers[] = {"VK_LAYER_KHRONOS_validation"};
    static const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    static const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    const char *wanted = getenv("DERMIS_VALIDATION");
    VkValidationFeaturesEXT validation = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                          .enabledValidationFeatureCount = 1, .pEnabledValidationFeatures = enabled};
    VkDebugUtilsMessengerCreateInfoEXT messages = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .pNext = &validation,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = on_message,
        .pUserData = gpu};
    /* Vulkan 1.2 is the least that dermis works with. */
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "host-c",
                                     .apiVersion = VK_API_VERSION_1_2};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
    PFN_vkCreateDebugUtilsMessengerEXT create_messenger;
    if (!wanted || strcmp(wanted, "1") != 0) {
        VK(vkCreateInstance(&info, NULL, &gpu->instance));
        return;
    }
    info.pNext = &messages; /* heard while the instance itself is made and destroyed, too */
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = layers;
    info.enabledExtensionCount = 2;
    info.ppEnabledExtensionNames = extensions;
    VK(vkCreateInstance(&info, NULL, &gpu->instance));
    gpu->features |= DM_FEATURE_DEBUG_UTILS; /* on, so dermis may name its objects */
    messages.pNext = NULL;
    create_messenger = (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(gpu->instance,
                                                                                 "vkCreateDebugUtilsMessengerEXT");
    VK(create_messenger(gpu->instance, &messages, NULL, &gpu->messenger));
}

static int rank_of(VkPhysicalDevice physical)
{
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    if (properties.apiVersion < VK_API_VERSION_1_2)
        return 0;
    switch (properties.deviceType) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return 2;
    default: return 1;
    }
}

static void pick_physical_device(struct gpu *gpu)
{
    VkPhysicalDevice devices[16];
    uint32_t count = 16, i;
    int best = 0;
    VkResult result = vkEnumeratePhysicalDevices(gpu->instance, &count, devices);
    if (result != VK_INCOMPLETE)
        vulkan_check(result, "vkEnumeratePhysicalDevices");
    for (i = 0; i < count; i++) {
        int rank = rank_of(devices[i]);
        if (rank > best) {
            best = rank;
            gpu->physical = devices[i];
        }
    }
    if (!best)
        die("no device of Vulkan 1.2 or newer");
    vkGetPhysicalDeviceMemoryProperties(gpu->physical, &gpu->memory);
}

static void require_graphics(const struct gpu *gpu)
{
    VkQueueFamilyProperties families[16];
    uint32_t count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(gpu->physical, &count, families);
    if (gpu->family >= count || !(families[gpu->family].queueFlags & VK_QUEUE_GRAPHICS_BIT))
        die("no queue family that does both graphics and compute");
}

/* dermis tells which queue family, extensions and features serve it; an engine adds its own. */
static void create_device(struct gpu *gpu)
{
    static const float priority = 1.0f;
    dm_vulkan_requirements needs = {.size = sizeof needs};
    VkPhysicalDeviceSynchronization2Features synchronization = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SYNCHRONIZATION_2_FEATURES, .synchronization2 = VK_TRUE};
    VkPhysicalDeviceTimelineSemaphoreFeatures timeline = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES, .timelineSemaphore = VK_TRUE};
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = &timeline,
                               .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue};
    DM(dm_vulkan_get_requirements((dm_get_instance_proc_addr)vkGetInstanceProcAddr, gpu->instance, gpu->physical, &needs));
    gpu->family = needs.queue_family;
    require_graphics(gpu);
    if (needs.features & DM_FEATURE_SYNCHRONIZATION2) {
        timeline.pNext = &synchronization;
        gpu->features |= DM_FEATURE_SYNCHRONIZATION2;
    }
    queue.queueFamilyIndex = gpu->family;
    info.enabledExtensionCount = needs.extension_count;
    info.ppEnabledExtensionNames = needs.extensions;
    VK(vkCreateDevice(gpu->physical, &info, NULL, &gpu->device));
    vkGetDeviceQueue(gpu->device, gpu->family, 0, &gpu->queue);
}

void gpu_create(struct gpu *gpu)
{
    memset(gpu, 0, sizeof *gpu);
    create_instance(gpu);
    pick_physical_device(gpu);
    create_device(gpu);
}

void gpu_destroy(struct gpu *gpu)
{
    vkDestroyDevice(gpu->device, NULL);
    if (gpu->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy = (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
            gpu->instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy(gpu->instance, gpu->messenger, NULL);
    }
    vkDestroyInstance(gpu->instance, NULL);
}

static VkDeviceMemory allocate(struct gpu *gpu, const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags)
{
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size};
    VkDeviceMemory memory;
    uint32_t type = 0;
    while (type < gpu->memory.memoryTypeCount &&
           !(needs->memoryTypeBits & 1u << type && (gpu->memory.memoryTypes[type].propertyFlags & flags) == flags))
        type++;
    if (type == gpu->memory.memoryTypeCount)
        die("no memory type that fits");
    info.memoryTypeIndex = type;
    VK(vkAllocateMemory(gpu->device, &info, NULL, &memory));
    return memory;
}

void buffer_create(struct gpu *gpu, VkDeviceSize bytes, VkBufferUsageFlags usage, int mapped, struct buffer *out)
{
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = bytes, .usage = usage};
    VkMemoryRequirements needs;
    memset(out, 0, sizeof *out);
    out->bytes = bytes;
    VK(vkCreateBuffer(gpu->device, &info, NULL, &out->buffer));
    vkGetBufferMemoryRequirements(gpu->device, out->buffer, &needs);
    out->memory = allocate(gpu, &needs, mapped ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT
                                               : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    VK(vkBindBufferMemory(gpu->device, out->buffer, out->memory, 0));
    if (mapped)
        VK(vkMapMemory(gpu->device, out->memory, 0, VK_WHOLE_SIZE, 0, &out->mapped));
}

void buffer_destroy(struct gpu *gpu, struct buffer *buffer)
{
    vkDestroyBuffer(gpu->device, buffer->buffer, NULL);
    vkFreeMemory(gpu->device, buffer->memory, NULL);
}

void image_create(struct gpu *gpu, VkFormat format, VkSampleCountFlagBits samples, VkImageUsageFlags usage,
                  VkImageAspectFlags aspect, struct image *out)
{
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, .imageType = VK_IMAGE_TYPE_2D, .format = format,
                              .extent = {PICTURE_SIZE, PICTURE_SIZE, 1}, .mipLevels = 1, .arrayLayers = 1,
                              .samples = samples, .tiling = VK_IMAGE_TILING_OPTIMAL, .usage = usage};
    VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO, .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                  .format = format, .subresourceRange = {aspect, 0, 1, 0, 1}};
    VkMemoryRequirements needs;
    VK(vkCreateImage(gpu->device, &info, NULL, &out->image));
    vkGetImageMemoryRequirements(gpu->device, out->image, &needs);
    out->memory = allocate(gpu, &needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    VK(vkBindImageMemory(gpu->device, out->image, out->memory, 0));
    view.image = out->image;
    VK(vkCreateImageView(gpu->device, &view, NULL, &out->view));
}

void image_destroy(struct gpu *gpu, struct image *image)
{
    vkDestroyImageView(gpu->device, image->view, NULL);
    vkDestroyImage(gpu->device, image->image, NULL);
    vkFreeMemory(gpu->device, image->memory, NULL);
}
