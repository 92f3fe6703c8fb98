//! Composition of fields: operators, opening curves and the program that the shaders follow.

/// How a joint's part and its parent's part are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Operator {
    /// max(f1, f2): a crease.
    #[default]
    Union,
    /// Gradient-based blend (appendix A).
    Blend,
    /// Gradient-based bulge in contact.
    Bulge,
}

/// For each field (a row each), how it meets its parent's field.
#[derive(Clone, Debug, Default)]
pub struct Composition {
    /// Field of the nearest ancestor joint that has one, or `u32::MAX`.
    pub parent: Vec<u32>,
    /// Operator at the joint between the two.
    pub operator: Vec<Operator>,
    /// Magnitude of the bulge operator, 1 as the authors have it.
    pub magnitude: f32,
}
