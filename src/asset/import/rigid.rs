//! _RIGID of a primitive: how far each vertex follows its joint rigidly when a skin is tracked.

use gltf::json::{
    accessor::{ComponentType, Type},
    mesh::Semantic,
};

use super::{
    accessor::{Accessor, Format},
    document::Document,
    fault::{Checked, refuse},
    geometry::Attributes,
};

/// The attribute without its underscore, as the `gltf` crate has it.
const NAME: &str = "RIGID";

/// Values outside of 0 to 1 by no more than this are rounding.
const ROUNDING: f32 = 1e-6;

/// Values of `count` vertices in [0, 1]; none where the primitive has no such attribute.
pub(super) fn read(
    document: &Document,
    attributes: &Attributes<'_>,
    count: usize,
) -> Checked<Option<Vec<f32>>> {
    let Some(row) = attributes.get(Semantic::Extras(NAME.into())) else {
        return Ok(None);
    };
    let element = format!("{}/_{NAME}", attributes.element);
    let scalar = |component, normalized| Format {
        shape: Type::Scalar,
        component,
        normalized,
    };
    let formats = [
        Format::float(Type::Scalar),
        scalar(ComponentType::U8, false),
        scalar(ComponentType::U8, true),
        scalar(ComponentType::U16, false),
        scalar(ComponentType::U16, true),
    ];
    let accessor = Accessor::new(document, row)?.expect(&formats, "_RIGID")?;
    if accessor.count != count {
        let reason = format!("{} elements for {count} positions", accessor.count);
        return refuse(element, reason);
    }
    let values = accessor.floats()?;
    let fits = |x: &f32| (-ROUNDING..=1.0 + ROUNDING).contains(x);
    if let Some(bad) = values.iter().position(|x| !fits(x)) {
        let reason = format!("element {bad}: {} is not in 0 to 1", values[bad]);
        return refuse(element, reason);
    }
    Ok(Some(values.iter().map(|x| x.clamp(0.0, 1.0)).collect()))
}
