//! Twin of the pass that copies vectors.

/// The first `count` vectors of `source`.
pub fn ceiling_copy(source: &[[f32; 4]], count: u32) -> Vec<[f32; 4]> {
    source.iter().take(count as usize).copied().collect()
}
