//! Several spines on one mesh, each where its weights say.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    bend::{BendOptions, Bent, Placement},
    register::{PAST_BENT_LIMIT, Registration},
    spine::Spine,
};
use crate::{Error, Result};

/// One spine's share in a mesh: a registration of all its points.
#[derive(Clone, Copy, Debug)]
pub struct Layer<'a> {
    /// Points on the rest spine.
    pub rest: &'a Registration,
    /// The bent spine.
    pub bent: &'a Spine,
    /// How they follow it.
    pub options: BendOptions,
    /// From 0 to 1, a point each: a group of vertices, a mask.
    pub weights: &'a [f64],
}

/// Bends points by all layers: where weights sum up to less than 1, the rest stays; where to more, they share.
///
/// Positions and normals are averages, so that volume is kept where one weight is 1; a mask is best wide against the movement
/// there. Points that no layer moves have no flags and an infinite distance.
///
/// # Errors
/// [`Error::Argument`] naming the layer and the weight that is out of range, or where there is another number of points,
/// normals or weights; as [`Placement::new`].
pub fn blend(positions: &[DVec3], normals: &[DVec3], layers: &[Layer<'_>]) -> Result<Bent> {
    let mut placements = Vec::with_capacity(layers.len());
    for (row, layer) in layers.iter().enumerate() {
        let name = |what: &str| format!("layers/{row}/{what}");
        let counts = [
            ("positions", layer.rest.anchors.len(), positions.len()),
            ("normals", layer.rest.tilts.len(), normals.len()),
            ("weights", layer.weights.len(), positions.len()),
        ];
        for (what, given, wanted) in counts {
            if given != wanted {
                let reason = format!("{given} given, it has to be {wanted}");
                return Err(Error::argument(name(what), reason));
            }
        }
        let outside = |w: &f64| !(0.0..=1.0).contains(w);
        if let Some(weight) = layer.weights.iter().position(outside) {
            let reason = format!("{} is not from 0 to 1", layer.weights[weight]);
            return Err(Error::argument(name(&format!("weights/{weight}")), reason));
        }
        placements.push(Placement::new(layer.rest, layer.bent, &layer.options)?);
    }
    let point = |row: usize| {
        let normal = normals.get(row).copied();
        mixed(row, positions[row], normal, layers, &placements)
    };
    let rows: Vec<Mixed> = (0..positions.len()).into_par_iter().map(point).collect();
    Ok(Bent {
        positions: rows.iter().map(|m| m.position).collect(),
        normals: rows.iter().filter_map(|m| m.normal).collect(),
        distances: rows.iter().map(|m| m.distance).collect(),
        flags: rows.iter().map(|m| m.flags).collect(),
    })
}

struct Mixed {
    position: DVec3,
    normal: Option<DVec3>,
    distance: f64,
    flags: u32,
}

fn mixed(
    row: usize,
    position: DVec3,
    normal: Option<DVec3>,
    layers: &[Layer<'_>],
    placements: &[Placement],
) -> Mixed {
    let sum: f64 = layers.iter().map(|l| l.weights[row]).sum();
    let (stays, scale) = ((1.0 - sum).max(0.0), 1.0 / sum.max(1.0));
    let mut out = Mixed {
        position: stays * position,
        normal: normal.map(|n| stays * n),
        distance: f64::INFINITY,
        flags: 0,
    };
    for (layer, placement) in layers.iter().zip(placements) {
        let weight = layer.weights[row] * scale;
        if weight == 0.0 {
            continue;
        }
        let anchor = &layer.rest.anchors[row];
        let section = layer.bent.section(placement.arc(anchor));
        let (bent, room) = placement.point(anchor, &section);
        out.position += weight * bent;
        if let Some(normal) = &mut out.normal {
            *normal += weight * placement.normal(anchor, &layer.rest.tilts[row], &section);
        }
        let distance = anchor.distance.min(room / section.curvature.length());
        out.distance = out.distance.min(distance);
        out.flags |= anchor.flags | if room <= 0.0 { PAST_BENT_LIMIT } else { 0 };
    }
    out.normal = out.normal.map(DVec3::normalize_or_zero);
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::flesh::{Curve, Map, Round, SpineDesc, bend, register};

    fn spines() -> (Spine, Spine) {
        let line = Curve::BSpline(vec![DVec3::ZERO, 4.0 * DVec3::X]);
        let rest = Spine::new(&SpineDesc::new(line)).unwrap();
        let arc = Curve::Arc(Round {
            start: DVec3::ZERO,
            tangent: DVec3::X,
            normal: DVec3::Y,
            radius: 3.0,
            length: 4.0,
        });
        let bent = Spine::like(&SpineDesc::new(arc), &rest).unwrap();
        (rest, bent)
    }

    #[test]
    fn weights_mix_layers_and_rest() {
        let (rest, bent) = spines();
        let points: Vec<DVec3> = (0..4).map(|i| DVec3::new(f64::from(i), 0.4, 0.2)).collect();
        let normals = vec![DVec3::Y; 4];
        let registered = register(&rest, Map::Normal, &points, &normals).unwrap();
        let layer = |weights| Layer {
            rest: &registered,
            bent: &bent,
            options: BendOptions::default(),
            weights,
        };
        let whole = bend(&registered, &bent, &BendOptions::default()).unwrap();
        let one = blend(&points, &normals, &[layer(&[0.0, 0.5, 1.0, 1.0])]).unwrap();
        assert_eq!(
            (one.positions[0], one.flags[0], one.distances[0]),
            (points[0], 0, f64::INFINITY)
        );
        assert!(one.positions[1].distance(points[1].midpoint(whole.positions[1])) < 1e-12);
        assert!(one.positions[2].distance(whole.positions[2]) < 1e-12);
        assert!(one.normals[2].distance(whole.normals[2]) < 1e-12);
        assert_eq!(one.normals[0], DVec3::Y);
        // Twice the whole weight is shared.
        let full = [1.0; 4];
        let two = blend(&points, &normals, &[layer(&full), layer(&full)]).unwrap();
        assert!(two.positions[3].distance(whole.positions[3]) < 1e-12);
    }

    #[test]
    fn weights_that_are_wrong_are_named() {
        let (rest, bent) = spines();
        let registered = register(&rest, Map::Normal, &[DVec3::X], &[]).unwrap();
        let said = |weights: &[f64]| {
            let options = BendOptions::default();
            let layer = Layer {
                rest: &registered,
                bent: &bent,
                options,
                weights,
            };
            blend(&[DVec3::X], &[], &[layer]).unwrap_err().to_string()
        };
        assert_eq!(
            said(&[f64::NAN]),
            "layers/0/weights/0: NaN is not from 0 to 1"
        );
        assert_eq!(said(&[]), "layers/0/weights: 0 given, it has to be 1");
    }
}
