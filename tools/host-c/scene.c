/* The host's own drawing: a render pass into a picture of its own, pipelines, a camera. Nothing here knows of dermis, but that
   pictures look like those of `dermis render`: the same light and colours, and as many samples a pixel. */

#include <math.h>
#include <string.h>

#include "host.h"
#include "backdrop.frag.h"
#include "backdrop.vert.h"
#include "host.vert.h"
#include "skin.frag.h"

#define COLOUR_FORMAT VK_FORMAT_R8G8B8A8_UNORM /* the shaders encode sRGB themselves */
#define DEPTH_FORMAT VK_FORMAT_D32_SFLOAT
#define SAMPLES VK_SAMPLE_COUNT_4_BIT
#define STAGES (VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT)

static void create_pass(struct gpu *gpu, struct scene *scene)
{
    const VkPipelineStageFlags tests = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                       VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    const VkPipelineStageFlags output = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    const VkAccessFlags writes = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    const VkAccessFlags reads = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    /* Many samples and depth, thrown away at the end, and the picture that the samples are resolved into. */
    VkAttachmentDescription attachments[3] = {
        {.format = COLOUR_FORMAT, .samples = SAMPLES, .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
         .storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE, .finalLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL},
        {.format = DEPTH_FORMAT, .samples = SAMPLES, .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
         .storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE, .finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL},
        {.format = COLOUR_FORMAT, .samples = VK_SAMPLE_COUNT_1_BIT, .loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
         .storeOp = VK_ATTACHMENT_STORE_OP_STORE, .finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}};
    VkAttachmentReference colour = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkAttachmentReference depth = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    VkAttachmentReference resolved = {2, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS, .colorAttachmentCount = 1,
                                    .pColorAttachments = &colour, .pResolveAttachments = &resolved,
                                    .pDepthStencilAttachment = &depth};
    /* Frames share the pictures, so that each waits for the drawing of the one before; the copy waits for the last one.
       The vertices need nothing here: dermis records their barrier, as the description of its output says. */
    VkSubpassDependency dependencies[2] = {
        {VK_SUBPASS_EXTERNAL, 0, output | tests | VK_PIPELINE_STAGE_TRANSFER_BIT, output | tests, writes, writes | reads, 0},
        {0, VK_SUBPASS_EXTERNAL, output, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
         VK_ACCESS_TRANSFER_READ_BIT, 0}};
    VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                   .attachmentCount = 3, .pAttachments = attachments,
                                   .subpassCount = 1, .pSubpasses = &subpass,
                                   .dependencyCount = 2, .pDependencies = dependencies};
    VK(vkCreateRenderPass(gpu->device, &info, NULL, &scene->pass));
}

static void create_framebuffer(struct gpu *gpu, struct scene *scene)
{
    VkImageView views[3];
    VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO, .renderPass = scene->pass,
                                    .attachmentCount = 3, .pAttachments = views,
                                    .width = PICTURE_SIZE, .height = PICTURE_SIZE, .layers = 1};
    image_create(gpu, COLOUR_FORMAT, SAMPLES, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, VK_IMAGE_ASPECT_COLOR_BIT,
                 &scene->samples);
    image_create(gpu, DEPTH_FORMAT, SAMPLES, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT,
                 &scene->depth);
    image_create(gpu, COLOUR_FORMAT, VK_SAMPLE_COUNT_1_BIT,
                 VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT,
                 &scene->colour);
    views[0] = scene->samples.view;
    views[1] = scene->depth.view;
    views[2] = scene->colour.view;
    VK(vkCreateFramebuffer(gpu->device, &info, NULL, &scene->framebuffer));
}

static VkShaderModule create_shader(struct gpu *gpu, const uint32_t *code, size_t bytes)
{
    VkShaderModuleCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = bytes, .pCode = code};
    VkShaderModule module;
    VK(vkCreateShaderModule(gpu->device, &info, NULL, &module));
    return module;
}

static void create_layout(struct gpu *gpu, struct scene *scene)
{
    VkPushConstantRange push = {STAGES, 0, sizeof scene->view};
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                       .pushConstantRangeCount = 1, .pPushConstantRanges = &push};
    VK(vkCreatePipelineLayout(gpu->device, &info, NULL, &scene->layout));
}

/* Shaders and what they read: the skin, vertex by vertex and with depth, or the backdrop, which has no vertices. */
static VkPipeline create_pipeline(struct gpu *gpu, const struct scene *scene, VkShaderModule vertex, VkShaderModule fragment,
                                  int skin)
{
    VkPipelineShaderStageCreateInfo stages[2] = {
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_VERTEX_BIT,
         .module = vertex, .pName = "main"},
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
         .module = fragment, .pName = "main"}};
    VkVertexInputBindingDescription binding = {0, sizeof(struct vertex), VK_VERTEX_INPUT_RATE_VERTEX};
    VkVertexInputAttributeDescription attributes[2] = {
        {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(struct vertex, position)},
        {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(struct vertex, normal)}};
    VkPipelineVertexInputStateCreateInfo input = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                  .vertexBindingDescriptionCount = skin ? 1 : 0,
                                                  .pVertexBindingDescriptions = &binding,
                                                  .vertexAttributeDescriptionCount = skin ? 2 : 0,
                                                  .pVertexAttributeDescriptions = attributes};
    VkPipelineInputAssemblyStateCreateInfo assembly = {.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                       .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    VkViewport viewport = {0, 0, PICTURE_SIZE, PICTURE_SIZE, 0, 1};
    VkRect2D scissor = {{0, 0}, {PICTURE_SIZE, PICTURE_SIZE}};
    VkPipelineViewportStateCreateInfo area = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                              .viewportCount = 1, .pViewports = &viewport,
                                              .scissorCount = 1, .pScissors = &scissor};
    /* The camera turns y over, so that what is counter-clockwise in the model stays so on the screen. Back sides are drawn,
       and the shader makes them stand out. */
    VkPipelineRasterizationStateCreateInfo raster = {.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                     .polygonMode = VK_POLYGON_MODE_FILL, .cullMode = VK_CULL_MODE_NONE,
                                                     .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE, .lineWidth = 1};
    VkPipelineMultisampleStateCreateInfo samples = {.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                    .rasterizationSamples = SAMPLES};
    VkPipelineDepthStencilStateCreateInfo depth = {.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                   .depthTestEnable = skin ? VK_TRUE : VK_FALSE,
                                                   .depthWriteEnable = skin ? VK_TRUE : VK_FALSE,
                                                   .depthCompareOp = VK_COMPARE_OP_LESS};
    VkPipelineColorBlendAttachmentState opaque = {.colorWriteMask = 0xf};
    VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                 .attachmentCount = 1, .pAttachments = &opaque};
    VkGraphicsPipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, .stageCount = 2, .pStages = stages,
        .pVertexInputState = &input, .pInputAssemblyState = &assembly, .pViewportState = &area,
        .pRasterizationState = &raster, .pMultisampleState = &samples, .pDepthStencilState = &depth,
        .pColorBlendState = &blend, .layout = scene->layout, .renderPass = scene->pass};
    VkPipeline pipeline;
    VK(vkCreateGraphicsPipelines(gpu->device, VK_NULL_HANDLE, 1, &info, NULL, &pipeline));
    vkDestroyShaderModule(gpu->device, vertex, NULL);
    vkDestroyShaderModule(gpu->device, fragment, NULL);
    return pipeline;
}

void scene_create(struct gpu *gpu, struct scene *out)
{
    memset(out, 0, sizeof *out);
    create_pass(gpu, out);
    create_framebuffer(gpu, out);
    create_layout(gpu, out);
    out->backdrop = create_pipeline(gpu, out, create_shader(gpu, backdrop_vert, sizeof backdrop_vert),
                                    create_shader(gpu, backdrop_frag, sizeof backdrop_frag), 0);
    out->skin = create_pipeline(gpu, out, create_shader(gpu, host_vert, sizeof host_vert),
                                create_shader(gpu, skin_frag, sizeof skin_frag), 1);
}

void scene_destroy(struct gpu *gpu, struct scene *scene)
{
    vkDestroyPipeline(gpu->device, scene->skin, NULL);
    vkDestroyPipeline(gpu->device, scene->backdrop, NULL);
    vkDestroyPipelineLayout(gpu->device, scene->layout, NULL);
    vkDestroyFramebuffer(gpu->device, scene->framebuffer, NULL);
    image_destroy(gpu, &scene->colour);
    image_destroy(gpu, &scene->depth);
    image_destroy(gpu, &scene->samples);
    vkDestroyRenderPass(gpu->device, scene->pass, NULL);
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The centre of the box around all points. */
static void find_centre(const float *points, uint32_t count, float centre[3])
{
    uint32_t point;
    int i;
    for (i = 0; i < 3; i++) {
        float least = INFINITY, most = -INFINITY;
        for (point = 0; point < count; point++) {
            least = fminf(least, points[3 * (size_t)point + (size_t)i]);
            most = fmaxf(most, points[3 * (size_t)point + (size_t)i]);
        }
        centre[i] = (least + most) / 2;
    }
}

/* The camera stands in front (glTF's characters look along z, up is y), a little to their left and above, just so far away
   that all points are in the picture. Its lens is that of `dermis render`, 28 degrees from the picture's bottom to its top. */
void scene_look_at(struct scene *scene, const float *points, uint32_t count)
{
    const float turn = 0.45f, tilt = 0.15f, slope = tanf(14 * 3.14159265f / 180), margin = 1.05f;
    const float right[3] = {cosf(turn), 0, -sinf(turn)};
    const float back[3] = {sinf(turn) * cosf(tilt), sinf(tilt), cosf(turn) * cosf(tilt)};
    const float up[3] = {-sinf(turn) * sinf(tilt), cosf(tilt), -cosf(turn) * sinf(tilt)};
    float *centre = scene->target, away = 0, radius = 0, nearest, farthest, *m = scene->view.clip_from_model;
    uint32_t point;
    int i;
    find_centre(points, count, centre);
    for (point = 0; point < count; point++) {
        float offset[3], aside;
        for (i = 0; i < 3; i++)
            offset[i] = points[3 * (size_t)point + (size_t)i] - centre[i];
        aside = fmaxf(fabsf(dot(offset, right)), fabsf(dot(offset, up)));
        away = fmaxf(away, dot(offset, back) + margin * aside / slope);
        radius = fmaxf(radius, sqrtf(dot(offset, offset)));
    }
    nearest = fmaxf(away - radius, away / 100);
    farthest = away + radius;
    memset(&scene->view, 0, sizeof scene->view);
    /* Rows of the matrix: x, y turned over for Vulkan, depth from 0 to 1, and the distance that all is divided by. */
    for (i = 0; i < 3; i++) {
        m[4 * i] = right[i] / slope;
        m[4 * i + 1] = -up[i] / slope;
        m[4 * i + 2] = -back[i] * farthest / (farthest - nearest);
        m[4 * i + 3] = -back[i];
        scene->view.eye[i] = centre[i] + away * back[i];
        scene->view.right[i] = right[i];
        scene->view.up[i] = up[i];
    }
    m[12] = -dot(right, centre) / slope;
    m[13] = dot(up, centre) / slope;
    m[14] = (dot(back, centre) + away - nearest) * farthest / (farthest - nearest);
    m[15] = dot(back, centre) + away;
    scene->view.eye[3] = 1;
}

void scene_draw(const struct scene *scene, VkCommandBuffer commands, VkBuffer vertices, VkBuffer indices, uint32_t count)
{
    const VkClearValue clear[2] = {{.color = {{0, 0, 0, 1}}}, {.depthStencil = {1, 0}}};
    const float backdrop[2][4] = {{240 / 255.0f, 241 / 255.0f, 243 / 255.0f, 1}, {206 / 255.0f, 209 / 255.0f, 214 / 255.0f, 1}};
    const VkDeviceSize offset = 0;
    VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO, .renderPass = scene->pass,
                                   .framebuffer = scene->framebuffer,
                                   .renderArea = {{0, 0}, {PICTURE_SIZE, PICTURE_SIZE}},
                                   .clearValueCount = 2, .pClearValues = clear};
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, scene->backdrop);
    vkCmdPushConstants(commands, scene->layout, STAGES, 0, sizeof backdrop, backdrop);
    vkCmdDraw(commands, 3, 1, 0, 0);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, scene->skin);
    vkCmdPushConstants(commands, scene->layout, STAGES, 0, sizeof scene->view, &scene->view);
    vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &offset);
    vkCmdBindIndexBuffer(commands, indices, 0, VK_INDEX_TYPE_UINT32);
    vkCmdDrawIndexed(commands, count, 1, 0, 0, 0);
    vkCmdEndRenderPass(commands);
}

void scene_copy(const struct scene *scene, VkCommandBuffer commands, VkBuffer to)
{
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                      .imageExtent = {PICTURE_SIZE, PICTURE_SIZE, 1}};
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdCopyImageToBuffer(commands, scene->colour.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to, 1, &region);
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, NULL, 0,
                         NULL);
}
