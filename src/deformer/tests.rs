//! Every GPU pass against its twin, on real input, every buffer it writes.

#![allow(clippy::unwrap_used)]

use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

mod embedding;
mod flesh;
mod instances;
mod muscle;
mod tracking;

use super::{machine::GpuMachine, *};
use crate::{
    gpu::{Access, DeviceSelector, Features, GpuOptions, testing},
    report::Progress,
    rig::Options,
};

/// Relative error of a float: products of a few rounded factors, evaluated in another order by the driver's compiler.
const ROUNDING: f32 = 2e-5;
/// Absolute error of a field value: half-float texels filtered with weights of about 12 bits. Gradients have it times
/// 1 / r, with parts of a fiftieth of the character's size.
const FILTERING: f32 = 2e-4;

/// A bundled character, prepared by default.
fn bundled(file: &str) -> Arc<Rig> {
    let model = crate::asset::load(&PathBuf::from("assets").join(file)).unwrap();
    Arc::new(Rig::prepare(&model, &Options::default(), &|_: Progress| {}).unwrap())
}

/// The pose with one joint turned from rest.
fn turned(rig: &Rig, joint: &str, turn: glam::Mat4) -> Pose {
    let mut local = vec![glam::Mat4::IDENTITY; rig.skeleton.joints.len()];
    local[rig.skeleton.find(joint).unwrap()] = turn;
    Pose::from_local(&rig.skeleton, &local).unwrap()
}

pub(super) fn gpu() -> Option<Gpu> {
    if std::env::var("DERMIS_NO_GPU").is_ok_and(|v| v == "1") {
        eprintln!("skipped: DERMIS_NO_GPU is 1");
        return None;
    }
    let options = GpuOptions {
        device: DeviceSelector::Auto,
        validation: true,
        budget: None,
        profile: crate::gpu::Profile::Off,
    };
    Some(Gpu::new(&options).expect("a Vulkan device"))
}

pub(super) fn rig(file: &str, joints: &[(&str, crate::compose::Operator)]) -> Option<Arc<Rig>> {
    let data = std::env::var_os("DERMIS_DATA")
        .map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    if !data.exists() {
        eprintln!("skipped: {} does not exist", data.display());
        return None;
    }
    let model = crate::asset::load(&data.join("characters").join(file)).unwrap();
    let joints = joints
        .iter()
        .map(|(name, op)| (name.to_string(), *op))
        .collect();
    let options = Options {
        joints,
        ..Options::default()
    };
    Some(Arc::new(
        Rig::prepare(&model, &options, &|_: Progress| {}).unwrap(),
    ))
}

/// A step's buffers, as words.
type Words = BTreeMap<u32, Vec<u32>>;

fn bound(step: &Step) -> Vec<Resource> {
    match step {
        Step::Clear(r) => vec![*r],
        Step::Empty(_) => vec![Resource::Dispatches],
        Step::Copy(a, b) | Step::Keep(a, b) => vec![*a, *b],
        Step::Take(_, b) => vec![*b],
        Step::Dispatch { bind, .. } => [&bind[..], &[Resource::Dispatches]].concat(),
    }
}

fn download(machine: &GpuMachine, step: &Step) -> Words {
    let buffers = bound(step)
        .into_iter()
        .filter(|r| matches!(r.kind(), Kind::Static | Kind::Transient));
    let used = buffers.filter(|r| machine.resources.has(*r));
    used.map(|r| (r as u32, machine.resources.read(&machine.gpu, r).unwrap()))
        .collect()
}

/// Runs one step on both devices from the same content; returns (GPU, twin).
fn both(
    machine: &GpuMachine,
    store: &mut cpu::Store,
    upload: &PoseUpload,
    step: &Step,
) -> (Words, Words) {
    for (r, words) in download(machine, step) {
        store.write(Resource::ALL[r as usize], &words);
    }
    let resources = &machine.resources;
    let (gpu, steps) = (&machine.gpu, std::slice::from_ref(step));
    let builder = resources.builder(gpu, "twin", steps, resources.instances);
    let mut frame = builder.build().unwrap();
    let slot = frame.begin().unwrap();
    machine.resources.pose(slot, upload).unwrap();
    frame.submit().unwrap();
    frame.wait().unwrap();
    store.run(std::slice::from_ref(step), 0);
    let gpu = download(machine, step);
    let twin = gpu
        .keys()
        .map(|r| (*r, store.read::<u32>(Resource::ALL[*r as usize]).to_vec()));
    let twin = twin.collect();
    (gpu, twin)
}

fn is_integer(r: Resource) -> bool {
    use Resource as R;
    matches!(
        r,
        R::Status
            | R::LiveSet
            | R::ContactSet
            | R::RegionSet
            | R::LiveA
            | R::LiveB
            | R::ContactList
            | R::RegionList
            | R::Dispatches
            | R::Faults
            | R::History
            | R::Around
            | R::Index
    )
}

/// Words that differ: integers at all, floats beyond the tolerance.
fn differing(r: Resource, gpu: &[u32], twin: &[u32], size: f32) -> Vec<usize> {
    let close = |a: u32, b: u32| {
        if is_integer(r) {
            return a == b;
        }
        let (a, b) = (f32::from_bits(a), f32::from_bits(b));
        // A walk over leaves filters operators and fields again at each of its meetings.
        let scale = match r {
            Resource::Gradients => 50.0 / size,
            Resource::SlopesA | Resource::SlopesB => 200.0 / size,
            _ => 1.0,
        };
        (a - b).abs() <= ROUNDING * (a.abs() + b.abs() + size) + FILTERING * scale
    };
    (0..gpu.len().min(twin.len()))
        .filter(|&i| !close(gpu[i], twin[i]))
        .collect()
}

fn written(step: &Step) -> Vec<Resource> {
    match step {
        Step::Empty(_) => vec![Resource::Dispatches],
        Step::Clear(r) | Step::Copy(_, r) | Step::Keep(_, r) | Step::Take(_, r) => vec![*r],
        Step::Dispatch { pass, bind, .. } => {
            let access = pass.declaration.bindings.iter().map(|b| b.access);
            access
                .zip(bind)
                .filter(|(a, _)| matches!(a, Access::Write | Access::ReadWrite))
                .map(|(_, r)| *r)
                .collect()
        }
    }
}

fn name(step: &Step) -> &'static str {
    match step {
        Step::Clear(_) => "clear",
        Step::Empty(_) => "empty",
        Step::Copy(..) => "copy",
        Step::Take(..) => "take",
        Step::Keep(..) => "keep",
        Step::Dispatch { pass, .. } => pass.declaration.name,
    }
}

/// Vertices whose outcome hangs on rounding: a projection that ended in another state or after another number of steps,
/// a bisection that turned to the other half.
fn branched(pass: &str, gpu: &Words, twin: &Words, size: f32) -> Vec<usize> {
    let (status, positions) = (Resource::Status as u32, Resource::Positions as u32);
    match pass {
        "advance" => {
            let around = Resource::Around as u32;
            (0..gpu[&around].len())
                .filter(|&v| gpu[&around][v] != twin[&around][v])
                .collect()
        }
        // Entered where they have hardly moved: a bit is a vertex.
        "track" => {
            let set = Resource::LiveSet as u32;
            let words = gpu[&set].iter().zip(&twin[&set]).enumerate();
            let bits = words.filter(|(word, _)| word % 33 != 32);
            bits.flat_map(|(word, (a, b))| (0..(a ^ b).count_ones() as usize).map(move |_| word))
                .collect()
        }
        "project" | "moved" | "settle" | "ease" => (0..gpu[&status].len())
            .filter(|&v| gpu[&status][v] != twin[&status][v])
            .collect(),
        "touch" => differing(
            Resource::Positions,
            &gpu[&positions],
            &twin[&positions],
            size,
        )
        .into_iter()
        .map(|word| word / 4)
        .collect(),
        _ => Vec::new(),
    }
}

/// Gives the twin the GPU's outcome at branched vertices; the sets follow their states.
fn accept(branched: &[usize], step: &Step, gpu: &Words, twin: &mut Words) {
    for r in written(step) {
        let width = match r {
            Resource::LiveSet | Resource::ContactSet => {
                if !branched.is_empty() {
                    twin.insert(r as u32, gpu[&(r as u32)].clone());
                }
                continue;
            }
            // A word of the set tells nothing of the vertex.
            _ if name(step) == "track" => continue,
            Resource::Status | Resource::Around => 1,
            _ => 4,
        };
        for &v in branched {
            let words = v * width..(v + 1) * width;
            let from = gpu[&(r as u32)][words.clone()].to_vec();
            twin.get_mut(&(r as u32)).unwrap()[words].copy_from_slice(&from);
        }
    }
}

fn compare(
    machine: &GpuMachine,
    store: &mut cpu::Store,
    upload: &PoseUpload,
    step: &Step,
    size: f32,
) {
    let (gpu, mut twin) = both(machine, store, upload, step);
    // At most 1 vertex in 200 is that close to a threshold.
    let branched = branched(name(step), &gpu, &twin, size);
    let vertices = store.read::<u32>(Resource::Status).len();
    assert!(
        branched.len() * 200 <= vertices + 199,
        "{}: {} of {vertices} vertices branched",
        name(step),
        branched.len()
    );
    accept(&branched, step, &gpu, &mut twin);
    for r in written(step) {
        let (a, b) = (&gpu[&(r as u32)], &twin[&(r as u32)]);
        let wrong = differing(r, a, b, size);
        let first = wrong
            .first()
            .map(|&i| (i, f32::from_bits(a[i]), f32::from_bits(b[i]), a[i], b[i]));
        assert!(
            wrong.is_empty(),
            "{} {}: {} words differ, first {first:?}",
            name(step),
            r.label(),
            wrong.len()
        );
        // The comparison can fail: a perturbed buffer is rejected.
        let mut broken = b.clone();
        let at = broken.len() / 2;
        broken[at] = if is_integer(r) {
            broken[at] ^ 1
        } else {
            (f32::from_bits(broken[at]) + 0.05 * size + 0.05).to_bits()
        };
        assert!(
            differing(r, a, &broken, size).contains(&at),
            "{} {}: a wrong value passed",
            name(step),
            r.label()
        );
    }
}

fn compare_all(file: &str, joints: &[(&str, crate::compose::Operator)], methods: &[Method]) {
    if let Some(rig) = rig(file, joints) {
        compare_steps(&rig, methods);
    }
}

fn compare_steps(rig: &Arc<Rig>, methods: &[Method]) {
    if let Some(gpu) = gpu() {
        compare_on(&gpu, rig, methods);
    }
}

fn compare_on(gpu: &Gpu, rig: &Arc<Rig>, methods: &[Method]) {
    for &method in methods {
        let settings = Settings {
            method,
            rounds: 6,
            ..Settings::default()
        };
        let mut deformer =
            Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &settings).unwrap();
        let mut twin = Deformer::new(&Device::Cpu, rig.clone(), &settings).unwrap();
        let pose = Pose::random(&rig.skeleton, 60.0, 3).unwrap();
        if method == Method::Tracking {
            // From a skin that has been tracked, the steps of a small move.
            let rest = Pose::rest(&rig.skeleton);
            let close = Pose::interpolate(&rig.skeleton, &rest, &pose, 0.95).unwrap();
            deformer.advance(&close).unwrap();
            deformer.wait().unwrap();
            deformer
                .upload_substeps(std::slice::from_ref(&pose))
                .unwrap();
        } else {
            deformer.advance(&pose).unwrap();
            deformer.wait().unwrap();
        }
        let (Machine::Gpu(machine), Machine::Cpu(cpu)) = (&deformer.machine, &mut twin.machine)
        else {
            unreachable!()
        };
        cpu.store.pose(&deformer.upload);
        (cpu.store.atlas, cpu.store.operators) = machine.resources.images(&machine.gpu).unwrap();
        let size = rig
            .mesh
            .positions
            .iter()
            .fold(0.0f32, |a, p| a.max(p.length()));
        for step in plan::frame(&deformer.statics.sizes, &settings).steps {
            compare(machine, &mut cpu.store, &deformer.upload, &step, size);
        }
    }
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn every_pass_agrees_with_its_twin_on_cesium_man() {
    use crate::compose::Operator::{Blend, Bulge};
    let all = [Method::Lbs, Method::Dqs, Method::Implicit];
    compare_all(
        "khronos/CesiumMan.glb",
        &[("joint_8", Blend), ("joint_11", Bulge)],
        &all,
    );
}

#[test]
fn every_pass_agrees_with_its_twin_where_shaders_weigh_texels() {
    use crate::compose::Operator::{Blend, Bulge, Union};
    let Some(gpu) = testing::with(&GpuOptions::default(), Features::NONE) else {
        return;
    };
    for (below, method) in [(Blend, Method::Implicit), (Union, Method::Tracking)] {
        let operators = [("joint_8", below), ("joint_11", Bulge)];
        let Some(rig) = rig("khronos/CesiumMan.glb", &operators) else {
            return;
        };
        compare_on(&gpu, &rig, &[method]);
    }
}

#[test]
fn every_pass_agrees_with_its_twin_on_a_human() {
    let methods = [Method::Implicit, Method::Tracking];
    compare_all("mesh2motion/human-male.glb", &[], &methods);
}

#[test]
fn every_pass_of_tracking_agrees_with_its_twin_where_bulges_are_below() {
    use crate::compose::Operator::{Bulge, Union};
    compare_all(
        "khronos/CesiumMan.glb",
        &[("joint_8", Union), ("joint_11", Bulge)],
        &[Method::Tracking],
    );
}

#[test]
fn the_same_pose_gives_the_same_bits() {
    let (Some(gpu), Some(rig)) = (gpu(), rig("khronos/CesiumMan.glb", &[])) else {
        return;
    };
    let pose = Pose::random(&rig.skeleton, 60.0, 3).unwrap();
    let skins = [0, 1].map(|_| {
        let mut deformer =
            Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &Settings::default()).unwrap();
        deformer.advance(&Pose::rest(&rig.skeleton)).unwrap();
        deformer.advance(&pose).unwrap();
        deformer.read().unwrap()
    });
    assert!(skins[0] == skins[1]);
    assert!(skins[0].state.contains(&(state::ON_ISO as u8)));
}

#[test]
fn the_rest_pose_is_a_fixed_point() {
    let (Some(gpu), Some(rig)) = (gpu(), rig("khronos/CesiumMan.glb", &[])) else {
        return;
    };
    for device in [Device::Cpu, Device::Gpu(gpu)] {
        let mut deformer = Deformer::new(&device, rig.clone(), &Settings::default()).unwrap();
        deformer.advance(&Pose::rest(&rig.skeleton)).unwrap();
        let skin = deformer.read().unwrap();
        let (low, high) = rig
            .mesh
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| {
                (l.min(*p), h.max(*p))
            });
        for (row, p) in skin.positions.iter().enumerate() {
            let rest = rig.mesh.positions[rig.rows.vertex[row] as usize];
            assert!((*p - rest).length() <= 1e-5 * (high - low).length());
        }
    }
}

#[test]
fn no_vertex_moves_further_than_the_radius_of_its_part() {
    for file in ["khronos/CesiumMan.glb", "mesh2motion/human-male.glb"] {
        let (Some(gpu), Some(rig)) = (gpu(), rig(file, &[])) else {
            return;
        };
        let pose = Pose::random(&rig.skeleton, 90.0, 5).unwrap();
        let skins = [Method::Dqs, Method::Implicit].map(|method| {
            let settings = Settings {
                method,
                ..Settings::default()
            };
            let device = Device::Gpu(gpu.clone());
            let mut deformer = Deformer::new(&device, rig.clone(), &settings).unwrap();
            deformer.advance(&pose).unwrap();
            deformer.read().unwrap()
        });
        let mut moved = 0;
        for row in 0..rig.rows.vertex.len() {
            let v = rig.rows.vertex[row] as usize;
            let distance = skins[0].positions[row].distance(skins[1].positions[row]);
            let radius = rig.radius[rig.part[v] as usize];
            assert!(
                distance <= 1.001 * radius,
                "{file} row {row}: {distance} of {radius}"
            );
            moved += usize::from(distance > 0.05 * radius);
        }
        assert!(moved > 10, "{file}: the pose moves nothing");
    }
}

#[test]
fn what_moves_as_one_is_not_projected_and_is_on_its_iso_value() {
    let (Some(gpu), Some(rig)) = (gpu(), rig("mesh2motion/human-male.glb", &[])) else {
        return;
    };
    let mut local = vec![glam::Mat4::IDENTITY; rig.skeleton.joints.len()];
    local[rig.skeleton.find("head").unwrap()] = glam::Mat4::from_rotation_x(0.4);
    let pose = Pose::from_local(&rig.skeleton, &local).unwrap();
    let device = Device::Gpu(gpu);
    let mut deformer = Deformer::new(&device, rig.clone(), &Settings::default()).unwrap();
    deformer.advance(&pose).unwrap();
    let read = |d: &mut Deformer, r| d.machine.read::<u32>(r).unwrap();
    let status = read(&mut deformer, Resource::Status);
    let iso = deformer.machine.read::<f32>(Resource::IsoValues).unwrap();
    let at = deformer
        .machine
        .read::<[f32; 4]>(Resource::Positions)
        .unwrap();
    // The composed field there, by the pass that measures iso-values.
    let measure = plan::measure_iso(&deformer.statics.sizes);
    let Deformer {
        machine, upload, ..
    } = &mut deformer;
    machine
        .once(&measure, upload, Resource::Positions, &at)
        .unwrap();
    let field = machine.read::<f32>(Resource::IsoValues).unwrap();
    let settled = |v: &usize| state::of(status[*v]) == state::ON_ISO;
    let all: Vec<usize> = (0..status.len()).filter(settled).collect();
    let still = all.iter().filter(|v| state::evaluations(status[**v]) == 0);
    for &v in still.clone() {
        assert!((field[v] - iso[v]).abs() <= 1e-4, "{v}");
        assert_eq!(at[v][3], iso[v]);
    }
    let still = still.count();
    assert!(still * 2 > all.len() && still < all.len(), "{still}");
}
