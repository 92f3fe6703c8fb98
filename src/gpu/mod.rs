//! Vulkan runtime: device, memory, buffers, images, pipelines, timestamps. Knows nothing of skin.
