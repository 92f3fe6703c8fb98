//! JOINTS_n and WEIGHTS_n of a primitive to lists of influences.

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
use crate::asset::Influence;

/// Greatest number of sets of four influences.
const SET_LIMIT: u32 = 16;

/// Sums off 1 by no more than this are rounding and left alone, bit for bit.
const ROUNDING: f64 = 1e-6;

/// Sums off 1 by more than this are worth a warning.
const WORTH_TELLING: f64 = 1e-3;

/// What had to be mended, counted over all primitives.
#[derive(Default)]
pub(in crate::asset) struct Mended {
    /// Vertices whose weights did not sum to 1.
    pub(super) scaled: usize,
    /// The least such sum.
    pub(super) least: f64,
    /// Vertices whose weights were all 0.
    pub(super) zero: usize,
}

/// Influences of `count` vertices, by row of the skeleton; empty lists where the primitive has no weights.
pub(super) fn read(
    document: &Document,
    attributes: &Attributes<'_>,
    joints: &[u16],
    count: usize,
    mended: &mut Mended,
) -> Checked<Vec<Vec<Influence>>> {
    let mut influences = vec![Vec::new(); count];
    let sets = sets(attributes)?;
    for set in 0..sets {
        let (indices, weights) = read_set(document, attributes, set, count)?;
        let element = format!("{}/JOINTS_{set}", attributes.element);
        for (slot, &weight) in weights.iter().enumerate() {
            let vertex = slot / 4;
            if weight < 0.0 {
                let element = format!("{}/WEIGHTS_{set}", attributes.element);
                return refuse(element, format!("element {vertex} is negative"));
            }
            let index = indices[slot] as usize;
            match joints.get(index) {
                Some(&joint) if weight > 0.0 => add(&mut influences[vertex], joint, weight),
                None if weight > 0.0 => {
                    let length = joints.len();
                    let reason = format!("element {vertex}: joint {index} of {length}");
                    return refuse(element, reason);
                }
                Some(&joint) if set == 0 && slot % 4 == 0 => {
                    // Kept until all sets are read, so that a vertex without any weight has a joint.
                    influences[vertex].push(Influence { joint, weight: 0.0 });
                }
                _ => {}
            }
        }
    }
    if sets > 0 {
        for list in &mut influences {
            finish(list, mended);
        }
    }
    Ok(influences)
}

/// Number of sets, which must be numbered from 0 without gaps and come in pairs.
pub(super) fn sets(attributes: &Attributes<'_>) -> Checked<u32> {
    let has = |semantic| attributes.get(semantic).is_some();
    let mut count = 0;
    while count < SET_LIMIT && has(Semantic::Joints(count)) && has(Semantic::Weights(count)) {
        count += 1;
    }
    for (semantic, _) in attributes.iter() {
        let (kind, set) = match *semantic {
            Semantic::Joints(set) => ("JOINTS", set),
            Semantic::Weights(set) => ("WEIGHTS", set),
            _ => continue,
        };
        if set >= count {
            let element = format!("{}/{kind}_{set}", attributes.element);
            return refuse(
                element,
                "JOINTS_n and WEIGHTS_n must come in pairs, n = 0, 1, …, 15",
            );
        }
    }
    Ok(count)
}

fn read_set(
    document: &Document,
    attributes: &Attributes<'_>,
    set: u32,
    count: usize,
) -> Checked<(Vec<u32>, Vec<f32>)> {
    let four = |component, normalized| Format {
        shape: Type::Vec4,
        component,
        normalized,
    };
    let open = |semantic, formats: &[Format], role: &str| -> Checked<Accessor<'_>> {
        let row = attributes.get(semantic).unwrap_or_default();
        let accessor = Accessor::new(document, row)?.expect(formats, role)?;
        if accessor.count != count {
            let element = format!("{}/{role}_{set}", attributes.element);
            let reason = format!("{} elements for {count} positions", accessor.count);
            return refuse(element, reason);
        }
        Ok(accessor)
    };
    let integers = [
        four(ComponentType::U8, false),
        four(ComponentType::U16, false),
    ];
    let indices = open(Semantic::Joints(set), &integers, "JOINTS")?.integers()?;
    let floats = [
        Format::float(Type::Vec4),
        four(ComponentType::U8, true),
        four(ComponentType::U16, true),
    ];
    let weights = open(Semantic::Weights(set), &floats, "WEIGHTS")?.floats()?;
    Ok((indices, weights))
}

/// Adds to the joint's weight; a joint may be listed twice.
pub(in crate::asset) fn add(list: &mut Vec<Influence>, joint: u16, weight: f32) {
    match list.iter_mut().find(|influence| influence.joint == joint) {
        Some(influence) => influence.weight += weight,
        None => list.push(Influence { joint, weight }),
    }
}

/// Makes the weights sum to 1, greatest first.
pub(in crate::asset) fn finish(list: &mut Vec<Influence>, mended: &mut Mended) {
    let sum: f64 = list.iter().map(|i| f64::from(i.weight)).sum();
    if sum == 0.0 {
        mended.zero += 1;
        list.truncate(1);
        list.iter_mut().for_each(|influence| influence.weight = 1.0);
        return;
    }
    let off = (sum - 1.0).abs();
    if off > ROUNDING {
        for influence in list.iter_mut() {
            influence.weight = (f64::from(influence.weight) / sum) as f32;
        }
    }
    if off > WORTH_TELLING {
        mended.least = if mended.scaled == 0 {
            sum
        } else {
            mended.least.min(sum)
        };
        mended.scaled += 1;
    }
    // A weight may have become 0 by the division.
    list.retain(|influence| influence.weight > 0.0);
    list.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.joint.cmp(&b.joint)));
}

impl Mended {
    /// A sentence each.
    pub(in crate::asset) fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.scaled > 0 {
            let (count, least) = (self.scaled, self.least);
            warnings.push(format!(
                "weights of {count} vertices did not sum to 1 (least sum {least:.3}) and were scaled"
            ));
        }
        if self.zero > 0 {
            let count = self.zero;
            warnings.push(format!(
                "{count} vertices have weights that are all 0 and follow their first joint"
            ));
        }
        warnings
    }
}
