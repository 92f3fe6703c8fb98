//! Fleshing in the frame: volume, normals, the way back, and what lies beyond the limit.

use glam::{DMat3, Mat4, Vec3};

use super::*;
use crate::{
    flesh::Map,
    mesh::Mesh,
    rig::{FileRows, Fleshing, Joint, Skeleton, SpineChain, Weights},
};

const MAPS: [Map; 3] = [Map::Radial, Map::Normal, Map::Binormal];
/// Joints of the creature, a unit apart.
const JOINTS: usize = 6;

/// Evenly spread numbers from 0 to 1.
struct Spread(f64);

impl Spread {
    fn next(&mut self) -> f32 {
        self.0 = (self.0 * 9301.0 + 0.211_327).fract();
        self.0 as f32
    }

    fn signed(&mut self) -> f32 {
        2.0 * self.next() - 1.0
    }
}

/// A chain of joints, each turned against its parent.
fn chain(turns: &[Mat4]) -> Vec<Mat4> {
    let mut at = Mat4::IDENTITY;
    let step = |(row, turn): (usize, &Mat4)| {
        let along = if row == 0 { 0.0 } else { 1.0 };
        at = at * Mat4::from_translation(Vec3::X * along) * *turn;
        at
    };
    turns.iter().enumerate().map(step).collect()
}

/// Joints bent in a plane or out of it, and twisted.
fn turns(planar: bool, angle: f32) -> Vec<Mat4> {
    let turn = |row: usize| {
        let row = row as f32;
        let bend = Mat4::from_rotation_z(angle * (0.6 + 0.4 * (2.0 * row).sin()));
        match planar {
            true => bend,
            false => {
                bend * Mat4::from_rotation_y(0.7 * angle * row.cos()) * Mat4::from_rotation_x(0.3)
            }
        }
    };
    (0..JOINTS).map(turn).collect()
}

/// Weights of the four nearest joints, smooth from point to point.
fn nearest_four(bind: &[Mat4], points: &[Vec3]) -> Weights {
    let mut all = Weights {
        width: 4,
        ..Weights::default()
    };
    for point in points {
        let square = |j: usize| bind[j].w_axis.truncate().distance_squared(*point) + 0.1;
        let mut joints: Vec<usize> = (0..bind.len()).collect();
        joints.sort_by(|a, b| square(*a).total_cmp(&square(*b)));
        let weights: Vec<f32> = joints[..4].iter().map(|j| square(*j).powi(-2)).collect();
        let sum: f32 = weights.iter().sum();
        all.joints.extend(joints[..4].iter().map(|j| *j as u16));
        all.weights.extend(weights.iter().map(|w| w / sum));
    }
    all
}

/// Points that follow a spine wholly, with rows of their own, on joints bound at `bind`.
fn creature(
    bind: &[Mat4],
    points: Vec<Vec3>,
    normals: Vec<Vec3>,
    map: impl Into<Option<Map>>,
) -> Arc<Rig> {
    let map = map.into();
    let count = points.len() as u32;
    let joint = |(row, bind): (usize, &Mat4)| Joint {
        name: format!("tail_{row}"),
        parent: row.checked_sub(1),
        bind: *bind,
        inverse_bind: bind.inverse(),
    };
    let last = bind.len() - 1;
    let skeleton = Skeleton {
        joints: bind.iter().enumerate().map(joint).collect(),
        children: (0..=last)
            .map(|j| if j < last { vec![j + 1] } else { vec![] })
            .collect(),
    };
    let triangles: Vec<[u32; 3]> = (0..count / 3)
        .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
        .collect();
    let weights = nearest_four(bind, &points);
    let mesh = Mesh::new(points, triangles.clone());
    // All vertices are of the first part: the last bone has no end.
    let part = vec![0; count as usize];
    let spine = SpineChain {
        root: "tail_0".into(),
        tip: format!("tail_{last}"),
        map: map.unwrap_or_default(),
    };
    let spines = if map.is_some() { vec![spine] } else { vec![] };
    let fleshing = Fleshing::new(&spines, &skeleton, &mesh, &weights, &part).unwrap();
    let rows = FileRows {
        vertex: (0..count).collect(),
        normals,
        triangles,
    };
    Arc::new(Rig {
        radius: vec![1.0; bind.len()],
        geometric: vec![true; count as usize],
        rigid: vec![0.0; count as usize],
        mean_value: vec![0.0; mesh.one_ring.items.len()],
        neighbourhood: mesh.one_ring.clone(),
        mesh,
        rows,
        skeleton,
        weights,
        part,
        fleshing,
        ..Rig::default()
    })
}

/// From one set of joints to another.
fn moved(device: &Device, rig: &Arc<Rig>, to: &[Mat4]) -> Skin {
    let settings = Settings {
        method: Method::Dqs,
        ..Settings::default()
    };
    let joints = rig.skeleton.joints.iter().zip(to);
    let pose = Pose {
        matrices: joints.map(|(joint, to)| *to * joint.inverse_bind).collect(),
    };
    let mut deformer = Deformer::new(device, rig.clone(), &settings).unwrap();
    deformer.advance(&pose).unwrap();
    deformer.read().unwrap()
}

/// Points around a chain of joints, some past its ends.
fn cloud(bind: &[Mat4], count: usize, radius: f32, spread: &mut Spread) -> Vec<Vec3> {
    let point = |_| {
        let joint = ((spread.next() * JOINTS as f32) as usize).min(JOINTS - 1);
        let along = if joint == 0 {
            spread.signed()
        } else {
            spread.next()
        };
        let across = Vec3::new(0.0, spread.signed(), spread.signed()) * radius;
        bind[joint].transform_point3(across + along * Vec3::X)
    };
    (0..count).map(point).collect()
}

/// Worst error of the determinants and of normals, by central differences.
fn differences(device: &Device, map: Option<Map>, planar: bool, count: usize) -> (f64, f64) {
    const STEP: f32 = 0.005;
    let (rest, bent) = (chain(&turns(true, 0.12)), chain(&turns(planar, -0.4)));
    let mut spread = Spread(0.37);
    let centres = cloud(&rest, count, 0.25, &mut spread);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let around = |c: &Vec3| axes.map(|a| [*c + STEP * a, *c - STEP * a]).concat();
    let mut points: Vec<Vec3> = centres.iter().flat_map(around).collect();
    points.extend(&centres);
    let normals: Vec<Vec3> = points
        .iter()
        .map(|_| Vec3::new(spread.signed(), spread.signed(), spread.signed()).normalize())
        .collect();
    let rig = creature(&rest, points.clone(), normals.clone(), map);
    let skin = moved(device, &rig, &bent);
    let (mut volume, mut normal) = (0f64, 0f64);
    for row in 0..count {
        let at = |k: usize| skin.positions[6 * row + k].as_dvec3();
        // The steps as they were rounded.
        let gap = |k: usize| points[6 * row + 2 * k].distance(points[6 * row + 2 * k + 1]);
        let column = |k: usize| (at(2 * k) - at(2 * k + 1)) / f64::from(gap(k));
        let jacobian = DMat3::from_cols(column(0), column(1), column(2));
        volume = volume.max((jacobian.determinant() - 1.0).abs());
        let centre = 6 * count + row;
        let wanted = jacobian.inverse().transpose() * normals[centre].as_dvec3();
        normal = normal.max(wanted.normalize().distance(skin.normals[centre].as_dvec3()));
    }
    (volume, normal)
}

#[test]
fn volume_is_kept_everywhere_and_normals_are_those_of_the_map() {
    let Some(gpu) = gpu() else { return };
    let device = Device::Gpu(gpu);
    for map in MAPS {
        for planar in [true, false] {
            // 17,000 points six times. Positions of 5 in f32 over a step of .01: 1e-4.
            let (volume, normal) = differences(&device, Some(map), planar, 17_000);
            assert!(volume < 5e-4, "{map:?} {planar}: {volume:e}");
            assert!(normal < 5e-4, "{map:?} {planar}: {normal:e}");
        }
    }
}

#[test]
fn plain_skinning_loses_volume() {
    let Some(gpu) = gpu() else { return };
    let (volume, normal) = differences(&Device::Gpu(gpu), None, true, 500);
    assert!(volume > 0.1 && normal > 0.01, "{volume} {normal}");
}

#[test]
fn the_way_back_is_the_same_with_the_poses_exchanged() {
    let Some(gpu) = gpu() else { return };
    let device = Device::Gpu(gpu);
    let (rest, bent) = (chain(&turns(true, 0.12)), chain(&turns(false, -0.4)));
    for map in MAPS {
        let points = cloud(&rest, 9000, 0.25, &mut Spread(0.71));
        let normals = vec![Vec3::Y; points.len()];
        let rig = creature(&rest, points.clone(), normals, map);
        let there = moved(&device, &rig, &bent);
        let rig = creature(&bent, there.positions, there.normals, map);
        let back = moved(&device, &rig, &rest);
        // The creature's size is 6.
        for (row, point) in points.iter().enumerate() {
            let missed = back.positions[row].distance(*point);
            let turned = back.normals[row].distance(Vec3::Y);
            assert!(
                missed < 6.0 * 1e-5 && turned < 1e-4,
                "{map:?} {row}: {missed} {turned}"
            );
        }
    }
}

#[test]
fn the_limit_is_passed_without_a_jump() {
    let Some(gpu) = gpu() else { return };
    let device = Device::Gpu(gpu);
    // From the spine far past the centre of curvature, in steps of .002.
    let points: Vec<Vec3> = (0..3000)
        .map(|k| Vec3::new(2.5, 0.002 * k as f32, 0.3))
        .collect();
    for map in MAPS {
        let rig = creature(
            &chain(&turns(true, 0.0)),
            points.clone(),
            vec![Vec3::Z; 3000],
            map,
        );
        for angle in [0.4f32, 0.8, -0.7] {
            let bent = chain(&[Mat4::from_rotation_z(angle); JOINTS]);
            let skin = moved(&device, &rig, &bent);
            for pair in skin.positions.windows(2) {
                let step = pair[0].distance(pair[1]);
                assert!(
                    pair[1].is_finite() && step < 0.05,
                    "{map:?} {angle}: {step}"
                );
            }
            assert!(skin.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3));
            // Bent towards the points, all from the limit on say so; away from them, none has one.
            let past = skin.state.iter().position(|s| *s != 0).unwrap_or(3000);
            assert_eq!(angle > 0.0, past < 3000, "{map:?} {angle}: {past}");
            let [before, after] = [&skin.state[..past], &skin.state[past..]];
            let is = |rows: &[u8], state: u32| rows.iter().all(|s| u32::from(*s) == state);
            assert!(is(before, state::UNTOUCHED) && is(after, state::PAST_LIMIT));
        }
    }
}

#[test]
fn a_spine_that_cannot_be_is_refused_by_name() {
    let bind = chain(&turns(true, 0.1));
    let rig = creature(
        &bind,
        vec![Vec3::X, Vec3::Y, Vec3::Z],
        vec![Vec3::Y; 3],
        Map::Radial,
    );
    let refused = |chains: &[(&str, &str)]| {
        let chain = |(root, tip): &(&str, &str)| SpineChain {
            root: root.to_string(),
            tip: tip.to_string(),
            map: Map::Radial,
        };
        let chains: Vec<SpineChain> = chains.iter().map(chain).collect();
        let (mesh, weights) = (&rig.mesh, &rig.weights);
        let made = Fleshing::new(&chains, &rig.skeleton, mesh, weights, &rig.part);
        made.unwrap_err().to_string()
    };
    assert!(refused(&[("tail_0", "wing")]).contains("wing"));
    assert!(refused(&[("tail_3", "tail_1")]).contains("tail_1"));
    assert!(refused(&[("tail_2", "tail_2")]).contains("no length"));
    assert!(refused(&[("tail_0", "tail_3"), ("tail_3", "tail_5")]).contains("two spines"));
}

#[test]
fn the_pass_agrees_with_its_twin_after_every_method() {
    let model = crate::asset::load(&PathBuf::from("assets/mannequin.glb")).unwrap();
    let chain = SpineChain {
        root: "left_upper_arm".into(),
        tip: "left_hand".into(),
        map: Map::Normal,
    };
    let options = Options {
        spines: vec![chain],
        ..Options::default()
    };
    let rig = Arc::new(Rig::prepare(&model, &options, &|_: Progress| {}).unwrap());
    assert!(rig.fleshing.places.iter().any(|p| p.weight < 1.0));
    assert!(rig.fleshing.places.iter().any(|p| p.weight == 1.0));
    compare_steps(
        &rig,
        &[Method::Lbs, Method::Dqs, Method::Implicit, Method::Tracking],
    );
}
