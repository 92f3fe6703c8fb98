/*
 * A small engine that has dermis deform a character on its own Vulkan device, within its own command buffers, into its own
 * vertex buffer: what embedding takes, in the order in which it is to be done.
 *
 *     host-c [--frames N] [--picture FRAME] [--method lbs|dqs|implicit|tracking] CHARACTER.glb OUT.png
 *
 * It plays the first clip over and over at 30 frames a second and writes one frame, by default the last, as a picture. It
 * fails where dermis leaves anything behind. With DERMIS_VALIDATION=1 in the environment it runs under Vulkan's validation
 * layers and fails where they say anything.
 */

#define _POSIX_C_SOURCE 199309L

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host.h"

#define FRAMES_PER_SECOND 30.0f

struct arguments {
    const char *character;
    const char *picture;
    uint32_t frames;
    uint32_t shown; /* the frame that the picture shows */
    uint32_t method;
};

/* What dermis made for us, and the buffers that it is used with. */
struct character {
    dm_context context;
    dm_rig rig;
    dm_rig_info info;
    float clip_seconds;
    dm_deformer deformer;
    dm_output output;
    struct buffer vertices;
    struct buffer indices;
    float *pose; /* 16 numbers a joint */
};

/* One of the frames in flight. */
struct slot {
    VkCommandBuffer commands;
    VkFence done;
};

void die(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    fputs("host-c: ", stderr);
    vfprintf(stderr, format, list);
    fputc('\n', stderr);
    va_end(list);
    exit(1);
}

void vulkan_check(VkResult result, const char *call)
{
    if (result != VK_SUCCESS)
        die("%s: VkResult %d", call, (int)result);
}

void dermis_check(dm_result result, const char *call)
{
    if (result != DM_OK)
        die("%s: dm_result %d: %s", call, (int)result, dm_last_error());
}

static uint32_t method_of(const char *name)
{
    static const char *const names[] = {"lbs", "dqs", "implicit", "tracking"}; /* in the order of DM_LBS and so on */
    uint32_t i;
    for (i = 0; i < 4; i++)
        if (!strcmp(name, names[i]))
            return i;
    die("no method %s", name);
    return 0;
}

static struct arguments parse(int count, char **words)
{
    struct arguments out = {NULL, NULL, 30, UINT32_MAX, DM_IMPLICIT};
    int i;
    for (i = 1; i < count; i++) {
        if (!strcmp(words[i], "--frames") && i + 1 < count)
            out.frames = (uint32_t)strtoul(words[++i], NULL, 10);
        else if (!strcmp(words[i], "--picture") && i + 1 < count)
            out.shown = (uint32_t)strtoul(words[++i], NULL, 10);
        else if (!strcmp(words[i], "--method") && i + 1 < count)
            out.method = method_of(words[++i]);
        else if (!out.character)
            out.character = words[i];
        else if (!out.picture)
            out.picture = words[i];
        else
            die("one argument too many: %s", words[i]);
    }
    if (out.shown == UINT32_MAX)
        out.shown = out.frames - 1;
    if (!out.picture || out.shown >= out.frames)
        die("usage: host-c [--frames N] [--picture FRAME] [--method lbs|dqs|implicit|tracking] CHARACTER.glb OUT.png");
    return out;
}

static void on_log(void *user, int32_t level, const char *message)
{
    (void)user;
    if (level <= DM_LOG_WARNING)
        fprintf(stderr, "dermis: %s\n", message);
}

/* Lends the device to dermis. Handles of Vulkan are pointers, so they fit as they are. An engine that does not want to know
   what dermis makes passes vkGetInstanceProcAddr itself. */
static dm_context adopt(const struct gpu *gpu)
{
    dm_vulkan_desc desc = {.size = sizeof desc,
                           .api_version = DM_API_VERSION,
                           .get_instance_proc_addr = counting_loader,
                           .instance = gpu->instance,
                           .physical_device = gpu->physical,
                           .device = gpu->device,
                           .queue = gpu->queue,
                           .queue_family = gpu->family,
                           .features = gpu->features,
                           .log = on_log};
    dm_context context;
    DM(dm_context_adopt(&desc, &context));
    return context;
}

static dm_deformer create_deformer(const struct character *character, uint32_t method)
{
    dm_settings settings = {.size = sizeof settings};
    dm_deformer deformer;
    DM(dm_settings_default(&settings));
    settings.method = method;
    DM(dm_deformer_create(character->context, character->rig, &settings, &deformer));
    return deformer;
}

/* The output is a vertex buffer of our own layout. dermis binds it as a storage buffer; the vertex stage reads it next. */
static void create_output(struct gpu *gpu, struct character *character)
{
    dm_output_desc desc = {.size = sizeof desc,
                           .stride = sizeof(struct vertex),
                           .normal_offset = offsetof(struct vertex, normal),
                           .normal_format = DM_NORMAL_F32,
                           .stages = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT,
                           .access = VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT,
                           .queue_family = DM_SAME_FAMILY};
    buffer_create(gpu, character->info.vertices * sizeof(struct vertex),
                  VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, 0, &character->vertices);
    desc.buffer = (uint64_t)character->vertices.buffer;
    desc.bytes = character->vertices.bytes;
    DM(dm_output_create(character->context, character->deformer, &desc, &character->output));
}

static void load(struct gpu *gpu, const struct arguments *arguments, struct character *out)
{
    size_t corners;
    memset(out, 0, sizeof *out);
    out->context = adopt(gpu);
    DM(dm_rig_load(arguments->character, NULL, &out->rig));
    out->info.size = sizeof out->info;
    DM(dm_rig_get_info(out->rig, &out->info));
    if (out->info.clips)
        DM(dm_rig_clip_seconds(out->rig, 0, &out->clip_seconds));
    out->pose = malloc(sizeof *out->pose * 16 * out->info.joints);
    if (!out->pose)
        die("no memory for a pose");
    out->deformer = create_deformer(out, arguments->method);
    create_output(gpu, out);
    corners = (size_t)out->info.triangles * 3;
    buffer_create(gpu, corners * sizeof(uint32_t), VK_BUFFER_USAGE_INDEX_BUFFER_BIT, 1, &out->indices);
    DM(dm_rig_indices(out->rig, out->indices.mapped, corners));
}

static void on_allocation(void *user, const char *class_name, const char *name, uint64_t bytes)
{
    (void)user;
    die("%s (%s, %llu bytes) is left", name, class_name, (unsigned long long)bytes);
}

/* Output before its buffer, and everything of dermis before the device; the order of the others does not matter. */
static void unload(struct gpu *gpu, struct character *character)
{
    DM(dm_output_destroy(character->output));
    DM(dm_deformer_destroy(character->deformer));
    DM(dm_rig_destroy(character->rig));
    DM(dm_context_allocations(character->context, on_allocation, NULL)); /* nothing is left to be reported */
    DM(dm_context_destroy(character->context));
    if (objects_of_dermis().live)
        die("%u Vulkan objects of dermis are left", objects_of_dermis().live);
    buffer_destroy(gpu, &character->indices);
    buffer_destroy(gpu, &character->vertices);
    free(character->pose);
}

/* A character without a clip stays at rest, where every matrix of a pose is the identity. */
static void pose_at(struct character *character, uint32_t frame)
{
    float seconds = (float)frame / FRAMES_PER_SECOND;
    size_t i;
    if (character->info.clips) {
        if (seconds > character->clip_seconds)
            seconds = fmodf(seconds, character->clip_seconds);
        DM(dm_rig_pose_clip(character->rig, 0, seconds, character->pose, character->info.joints));
        return;
    }
    for (i = 0; i < (size_t)character->info.joints * 16; i++)
        character->pose[i] = i % 16 % 5 == 0 ? 1.0f : 0.0f;
}

/* Turns the camera onto the frame that the picture shows. A second deformer, read back, tells where it is: what is drawn
   shall reach that pose by the frames before it, since a tracked skin depends on them. */
static void aim(struct scene *scene, struct character *character, uint32_t frame)
{
    dm_skin skin = {.size = sizeof skin, .vertices = character->info.vertices};
    dm_deformer deformer = create_deformer(character, DM_LBS);
    skin.positions = malloc(sizeof(float) * 3 * skin.vertices);
    if (!skin.positions)
        die("no memory for positions");
    pose_at(character, frame);
    DM(dm_deformer_advance(deformer, character->pose, character->info.joints)); /* submits to our queue */
    DM(dm_deformer_read(deformer, &skin));
    DM(dm_deformer_destroy(deformer));
    scene_look_at(scene, skin.positions, skin.vertices);
    free(skin.positions);
}

static VkCommandPool create_slots(struct gpu *gpu, struct slot slots[SLOTS])
{
    VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                         .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                         .queueFamilyIndex = gpu->family};
    VkCommandBufferAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                        .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY, .commandBufferCount = 1};
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, .flags = VK_FENCE_CREATE_SIGNALED_BIT};
    VkCommandPool pool;
    uint32_t i;
    VK(vkCreateCommandPool(gpu->device, &pool_info, NULL, &pool));
    info.commandPool = pool;
    for (i = 0; i < SLOTS; i++) {
        VK(vkAllocateCommandBuffers(gpu->device, &info, &slots[i].commands));
        VK(vkCreateFence(gpu->device, &fence, NULL, &slots[i].done));
    }
    return pool;
}

static void destroy_slots(struct gpu *gpu, struct slot slots[SLOTS], VkCommandPool pool)
{
    uint32_t i;
    for (i = 0; i < SLOTS; i++)
        vkDestroyFence(gpu->device, slots[i].done, NULL);
    vkDestroyCommandPool(gpu->device, pool, NULL);
}

/* Waits until the device is done with what was submitted from the slot before, and begins anew. */
static void begin(struct gpu *gpu, struct slot *slot)
{
    VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                     .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    VK(vkWaitForFences(gpu->device, 1, &slot->done, VK_TRUE, UINT64_MAX));
    VK(vkResetFences(gpu->device, 1, &slot->done));
    VK(vkBeginCommandBuffer(slot->commands, &info));
}

static void submit(struct gpu *gpu, struct slot *slot)
{
    VkSubmitInfo info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1,
                         .pCommandBuffers = &slot->commands};
    VK(vkEndCommandBuffer(slot->commands));
    VK(vkQueueSubmit(gpu->queue, 1, &info, slot->done));
}

/* The frame: dermis records its work first, the render pass reads the vertices afterwards, one submission carries both. */
static void frame(struct gpu *gpu, struct slot slots[SLOTS], struct scene *scene, struct character *character,
                  uint32_t number)
{
    struct slot *slot = &slots[number % SLOTS];
    begin(gpu, slot); /* also makes the pose of this slot free to be overwritten */
    pose_at(character, number);
    DM(dm_frame_record(character->deformer, slot->commands, number % SLOTS, character->pose, character->info.joints,
                       character->output));
    scene_draw(scene, slot->commands, character->vertices.buffer, character->indices.buffer, character->info.triangles * 3);
    submit(gpu, slot);
}

static double milliseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* Waits for the frame and writes its picture; tells the milliseconds that it takes, the wait aside. */
static double save_picture(struct gpu *gpu, struct slot *slot, const struct scene *scene, const char *path)
{
    struct buffer pixels;
    double start;
    VK(vkQueueWaitIdle(gpu->queue));
    start = milliseconds();
    buffer_create(gpu, (VkDeviceSize)PICTURE_SIZE * PICTURE_SIZE * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT, 1, &pixels);
    begin(gpu, slot);
    scene_copy(scene, slot->commands, pixels.buffer);
    submit(gpu, slot);
    VK(vkQueueWaitIdle(gpu->queue));
    png_write(path, pixels.mapped, PICTURE_SIZE, PICTURE_SIZE);
    buffer_destroy(gpu, &pixels);
    return milliseconds() - start;
}

/* As `dermis render` takes them. */
static void print_camera(const struct scene *scene)
{
    const float *eye = scene->view.eye, *target = scene->target;
    printf("--size %ux%u --eye %.9g,%.9g,%.9g --target %.9g,%.9g,%.9g\n", PICTURE_SIZE, PICTURE_SIZE, eye[0], eye[1], eye[2],
           target[0], target[1], target[2]);
}

int main(int count, char **words)
{
    const struct arguments arguments = parse(count, words);
    struct gpu gpu;
    struct scene scene;
    struct character character;
    struct slot slots[SLOTS];
    struct objects objects;
    VkCommandPool pool;
    dm_memory memory = {.size = sizeof memory};
    double start, took;
    uint32_t number;

    gpu_create(&gpu);
    load(&gpu, &arguments, &character);
    scene_create(&gpu, &scene);
    pool = create_slots(&gpu, slots);
    aim(&scene, &character, arguments.shown);

    objects = objects_of_dermis();
    start = milliseconds();
    for (number = 0; number < arguments.frames; number++) {
        frame(&gpu, slots, &scene, &character, number);
        if (number == arguments.shown)
            start += save_picture(&gpu, &slots[(number + 1) % SLOTS], &scene, arguments.picture);
    }
    VK(vkQueueWaitIdle(gpu.queue));
    took = milliseconds() - start;
    objects.made = objects_of_dermis().made - objects.made;
    DM(dm_context_memory(character.context, &memory));

    destroy_slots(&gpu, slots, pool);
    scene_destroy(&gpu, &scene);
    unload(&gpu, &character);
    gpu_destroy(&gpu);
    print_camera(&scene);
    printf("%u frames of %u vertices, %.2f ms a frame; dermis used %llu bytes of device memory in %u objects, made %u more "
           "during the frames, and left none\n",
           arguments.frames, character.info.vertices, took / arguments.frames, (unsigned long long)memory.total,
           objects.live, objects.made);
    return gpu.complaints ? 1 : 0;
}
