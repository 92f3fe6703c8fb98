//! Vulkan runtime: device, memory, buffers, images, pipelines, timestamps. Knows nothing of skin.

mod declare;

pub use declare::{Access, Binding, Declaration};
