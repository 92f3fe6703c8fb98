/* Counts what dermis makes on the host's device: dermis loads its functions through the host's, so these can be others. */

#include <string.h>

#include "host.h"

static struct objects counted;

static void made(uint32_t number)
{
    counted.made += number;
    counted.live += number;
}

static void gone(int there)
{
    if (there)
        counted.live--;
}

struct objects objects_of_dermis(void)
{
    return counted;
}

/* vkCreateX and vkDestroyX that count X. */
#define COUNT(X)                                                                                                              \
    static PFN_vkCreate##X create_##X;                                                                                        \
    static PFN_vkDestroy##X destroy_##X;                                                                                      \
    static VKAPI_ATTR VkResult VKAPI_CALL count_create_##X(VkDevice device, const Vk##X##CreateInfo *info,                    \
                                                           const VkAllocationCallbacks *callbacks, Vk##X *out)                \
    {                                                                                                                         \
        VkResult result = create_##X(device, info, callbacks, out);                                                           \
        made(result == VK_SUCCESS);                                                                                           \
        return result;                                                                                                        \
    }                                                                                                                         \
    static VKAPI_ATTR void VKAPI_CALL count_destroy_##X(VkDevice device, Vk##X object,                                        \
                                                        const VkAllocationCallbacks *callbacks)                               \
    {                                                                                                                         \
        gone(object != VK_NULL_HANDLE);                                                                                       \
        destroy_##X(device, object, callbacks);                                                                               \
    }

COUNT(Buffer)
COUNT(BufferView)
COUNT(CommandPool)
COUNT(DescriptorPool)
COUNT(DescriptorSetLayout)
COUNT(Fence)
COUNT(Image)
COUNT(ImageView)
COUNT(PipelineCache)
COUNT(PipelineLayout)
COUNT(QueryPool)
COUNT(Sampler)
COUNT(Semaphore)
COUNT(ShaderModule)

static PFN_vkCreateComputePipelines create_pipelines;
static PFN_vkDestroyPipeline destroy_pipeline;
static PFN_vkAllocateMemory allocate_memory;
static PFN_vkFreeMemory free_memory;

static VKAPI_ATTR VkResult VKAPI_CALL count_create_pipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                             const VkComputePipelineCreateInfo *infos,
                                                             const VkAllocationCallbacks *callbacks, VkPipeline *out)
{
    VkResult result = create_pipelines(device, cache, count, infos, callbacks, out);
    uint32_t i;
    for (i = 0; i < count; i++)
        made(out[i] != VK_NULL_HANDLE);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL count_destroy_pipeline(VkDevice device, VkPipeline pipeline,
                                                         const VkAllocationCallbacks *callbacks)
{
    gone(pipeline != VK_NULL_HANDLE);
    destroy_pipeline(device, pipeline, callbacks);
}

static VKAPI_ATTR VkResult VKAPI_CALL count_allocate_memory(VkDevice device, const VkMemoryAllocateInfo *info,
                                                            const VkAllocationCallbacks *callbacks, VkDeviceMemory *out)
{
    VkResult result = allocate_memory(device, info, callbacks, out);
    made(result == VK_SUCCESS);
    return result;
}

static VKAPI_ATTR void VKAPI_CALL count_free_memory(VkDevice device, VkDeviceMemory memory,
                                                    const VkAllocationCallbacks *callbacks)
{
    gone(memory != VK_NULL_HANDLE);
    free_memory(device, memory, callbacks);
}

/* Keeps the driver's function and gives ours in its place. */
#define REPLACE(word, theirs, ours, type)                                                                                     \
    if (!strcmp(name, word)) {                                                                                                \
        theirs = (type)found;                                                                                                 \
        return (PFN_vkVoidFunction)ours;                                                                                      \
    }
#define REPLACE_BOTH(X)                                                                                                       \
    REPLACE("vkCreate" #X, create_##X, count_create_##X, PFN_vkCreate##X)                                                     \
    REPLACE("vkDestroy" #X, destroy_##X, count_destroy_##X, PFN_vkDestroy##X)

static PFN_vkGetDeviceProcAddr get_device_proc_addr;

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL count_device_functions(VkDevice device, const char *name)
{
    PFN_vkVoidFunction found = get_device_proc_addr(device, name);
    if (!found)
        return NULL;
    REPLACE_BOTH(Buffer)
    REPLACE_BOTH(BufferView)
    REPLACE_BOTH(CommandPool)
    REPLACE_BOTH(DescriptorPool)
    REPLACE_BOTH(DescriptorSetLayout)
    REPLACE_BOTH(Fence)
    REPLACE_BOTH(Image)
    REPLACE_BOTH(ImageView)
    REPLACE_BOTH(PipelineCache)
    REPLACE_BOTH(PipelineLayout)
    REPLACE_BOTH(QueryPool)
    REPLACE_BOTH(Sampler)
    REPLACE_BOTH(Semaphore)
    REPLACE_BOTH(ShaderModule)
    REPLACE("vkCreateComputePipelines", create_pipelines, count_create_pipelines, PFN_vkCreateComputePipelines)
    REPLACE("vkDestroyPipeline", destroy_pipeline, count_destroy_pipeline, PFN_vkDestroyPipeline)
    REPLACE("vkAllocateMemory", allocate_memory, count_allocate_memory, PFN_vkAllocateMemory)
    REPLACE("vkFreeMemory", free_memory, count_free_memory, PFN_vkFreeMemory)
    return found;
}

dm_function counting_loader(void *instance, const char *name)
{
    PFN_vkVoidFunction found = vkGetInstanceProcAddr(instance, name);
    if (found && !strcmp(name, "vkGetDeviceProcAddr")) {
        get_device_proc_addr = (PFN_vkGetDeviceProcAddr)found;
        return (dm_function)count_device_functions;
    }
    return (dm_function)found;
}
