//! Rows of the file that follow a spine.

use glam::Vec3;

use super::{Resource, Statics};
use crate::{
    layout::FleshRow,
    rig::{FleshPlace, Fleshing, Rig, SpinePoint},
};

impl Statics {
    /// The rows, each with its place along a spine, and what they share.
    pub(super) fn flesh(&mut self, rig: &Rig) {
        let fleshing = &rig.fleshing;
        let first_weights = first_weights(fleshing);
        let row = |row: usize, vertex: &u32, normal: &Vec3| {
            let places = &fleshing.places;
            let at = places
                .binary_search_by_key(vertex, |place| place.vertex)
                .ok()?;
            let place = &places[at];
            let points = fleshing.points_of(place.spine as usize);
            let of_points = [points.start, points.len()].map(|n| n as u32);
            Some(FleshRow {
                rows: [row as u32, first_weights[at], of_points[0], of_points[1]],
                ..flesh_row(place, fleshing, *normal)
            })
        };
        let file = rig.rows.vertex.iter().zip(&rig.rows.normals).enumerate();
        let rows: Vec<FleshRow> = file.filter_map(|(k, (v, n))| row(k, v, n)).collect();
        let point = |p: &SpinePoint| p.position.extend(f32::from(p.joint)).to_array();
        let points: Vec<[f32; 4]> = fleshing.points.iter().map(point).collect();
        self.sizes.fleshed = rows.len() as u32;
        self.put(Resource::FleshRows, &rows);
        self.put(Resource::SpineWeights, &fleshing.weights);
        self.put(Resource::SpinePoints, &points);
    }
}

/// Row of the first weight of every place.
fn first_weights(fleshing: &Fleshing) -> Vec<u32> {
    let points = |place: &FleshPlace| fleshing.points_of(place.spine as usize).len() as u32;
    let begins = fleshing.places.iter().scan(0, |next, place| {
        let first = *next;
        *next += points(place);
        Some(first)
    });
    begins.collect()
}

fn flesh_row(place: &FleshPlace, fleshing: &Fleshing, normal: Vec3) -> FleshRow {
    let [speed, quicken] = place.speed;
    let [x, y] = place.straight;
    let [share, share_rate] = place.share;
    let [a, b] = place.joints.map(f32::from);
    let map = fleshing.chains[place.spine as usize].map as u32 as f32;
    let covector = Vec3::from_array(place.basis.map(|v| v.dot(normal)));
    FleshRow {
        tangent: place.tangent.extend(speed).to_array(),
        side: place.side.extend(place.past).to_array(),
        straight: [x, y, place.weight, quicken],
        covector: covector.extend(share).to_array(),
        frame: [a, b, share_rate, map],
        turning: [place.turning[0], place.turning[1], 0.0, 0.0],
        rows: [0; 4],
    }
}
