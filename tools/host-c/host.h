/* What the files of the host share: its device (gpu.c), its scene (scene.c), its pictures (png.c), a counter (count.c). */

#ifndef HOST_H
#define HOST_H

#include <vulkan/vulkan.h>

#include "dermis.h"

/* Pixels along each side of the picture. */
#define PICTURE_SIZE 320

/* Frames that are on the device at once. dermis keeps as many poses. */
#define SLOTS DM_FRAME_SLOTS

/* Both end the program with a message where a call fails: a real engine would hand the error on. */
#define VK(call) vulkan_check((call), #call)
#define DM(call) dermis_check((call), #call)

void die(const char *format, ...);
void vulkan_check(VkResult result, const char *call);
void dermis_check(dm_result result, const char *call);

/* The host's device, all of which is the host's own. dermis borrows it. */
struct gpu {
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger; /* null without validation */
    VkPhysicalDevice physical;
    VkPhysicalDeviceMemoryProperties memory;
    VkDevice device;
    VkQueue queue;
    uint32_t family;
    uint32_t features; /* DM_FEATURE_..., those that were turned on */
    int complaints;    /* messages of the validation layers */
};

struct buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    VkDeviceSize bytes;
    void *mapped; /* NULL for memory of the device */
};

struct image {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;
};

void gpu_create(struct gpu *gpu);
void gpu_destroy(struct gpu *gpu);
void buffer_create(struct gpu *gpu, VkDeviceSize bytes, VkBufferUsageFlags usage, int mapped, struct buffer *out);
void buffer_destroy(struct gpu *gpu, struct buffer *buffer);
void image_create(struct gpu *gpu, VkFormat format, VkSampleCountFlagBits samples, VkImageUsageFlags usage,
                  VkImageAspectFlags aspect, struct image *out);
void image_destroy(struct gpu *gpu, struct image *image);

/* Vulkan objects of dermis' own, memory among them. */
struct objects {
    uint32_t made;
    uint32_t live;
};

/* In place of vkGetInstanceProcAddr, for dermis; and what was counted since. */
dm_function counting_loader(void *instance, const char *name);
struct objects objects_of_dermis(void);

/* A vertex of the skin. dermis writes position and normal; the rest stays as the host has put it. */
struct vertex {
    float position[3];
    float normal[3];
    float uv[2];
};

/* Constants of the shaders: shaders/shared/skin.glsl has the same. */
struct view {
    float clip_from_model[16]; /* column-major */
    float eye[4];              /* a point: the last is 1 */
    float right[4];            /* of the picture; the last is the width of edges, 0 for none */
    float up[4];
    float edge[4];
};

/* Pictures to draw into, and how to draw a skin. */
struct scene {
    struct image samples;
    struct image depth;
    struct image colour; /* samples, resolved */
    VkRenderPass pass;
    VkFramebuffer framebuffer;
    VkPipelineLayout layout;
    VkPipeline backdrop;
    VkPipeline skin;
    struct view view;
    float target[3]; /* where the camera looks */
};

void scene_create(struct gpu *gpu, struct scene *out);
void scene_destroy(struct gpu *gpu, struct scene *scene);
/* Turns the camera onto points, 3 numbers each. */
void scene_look_at(struct scene *scene, const float *points, uint32_t count);
void scene_draw(const struct scene *scene, VkCommandBuffer commands, VkBuffer vertices, VkBuffer indices, uint32_t count);
/* Records the copy of the picture, 4 bytes a pixel, to where the processor can read it. */
void scene_copy(const struct scene *scene, VkCommandBuffer commands, VkBuffer to);

/* Writes a picture of 4 bytes a pixel, without its alpha. */
void png_write(const char *path, const uint8_t *pixels, uint32_t width, uint32_t height);

#endif
