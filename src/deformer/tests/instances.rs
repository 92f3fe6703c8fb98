//! Several instances of a rig in one deformer: the same bits as by deformers of their own, and fields once.

use std::sync::Arc;

use glam::Mat4;

use super::{bundled, gpu, turned};
use crate::{
    deformer::{Deformer, Device, Method, Resource, Settings, Skin, TrackedState},
    report::{Iterations, MemoryReport},
    rig::{Pose, Rig},
};

const METHODS: [Method; 4] = [Method::Lbs, Method::Dqs, Method::Implicit, Method::Tracking];

fn several(method: Method, instances: u32) -> Settings {
    Settings {
        method,
        instances,
        ..Settings::default()
    }
}

fn bent(rig: &Rig, degrees: f32) -> Pose {
    turned(rig, "lower", Mat4::from_rotation_z(degrees.to_radians()))
}

type Outcome = (Skin, Option<TrackedState>);

/// The end of a course of every instance, from one deformer; a row of `courses` is an instance.
fn together(
    device: &Device,
    rig: &Arc<Rig>,
    settings: &Settings,
    courses: &[Vec<Pose>],
) -> (Vec<Outcome>, Vec<Iterations>) {
    let count = courses.len() as u32;
    let settings = Settings {
        instances: count,
        ..*settings
    };
    let mut deformer = Deformer::new(device, rig.clone(), &settings).unwrap();
    let frame = |frame: usize| {
        let poses: Vec<Pose> = courses.iter().map(|c| c[frame].clone()).collect();
        deformer.advance(&poses).unwrap();
        deformer.iterations().unwrap()
    };
    let iterations = (0..courses[0].len()).map(frame).collect();
    let outcome = |row| {
        let mut instance = deformer.instance(row).unwrap();
        (instance.read().unwrap(), instance.save().unwrap())
    };
    ((0..count).map(outcome).collect(), iterations)
}

/// The same from a deformer of its own.
fn alone(
    device: &Device,
    rig: &Arc<Rig>,
    settings: &Settings,
    course: &[Pose],
) -> (Outcome, Vec<Iterations>) {
    let mut deformer = Deformer::new(device, rig.clone(), settings).unwrap();
    let frame = |pose: &Pose| {
        deformer.advance(pose).unwrap();
        deformer.iterations().unwrap()
    };
    let iterations = course.iter().map(frame).collect();
    let outcome = (deformer.read().unwrap(), deformer.save().unwrap());
    (outcome, iterations)
}

fn same_bits(device: &Device, rig: &Arc<Rig>, settings: &Settings, courses: &[Vec<Pose>]) {
    let name = settings.method.name();
    let (all, iterations) = together(device, rig, settings, courses);
    let mut evaluations = vec![0; courses[0].len()];
    for (row, (course, of_all)) in courses.iter().zip(&all).enumerate() {
        let (own, of_one) = alone(device, rig, settings, course);
        assert!(own.0 == of_all.0, "{name} {row}: skin");
        assert!(own.1 == of_all.1, "{name} {row}: state");
        for (sum, i) in evaluations.iter_mut().zip(of_one) {
            *sum += i.evaluations;
        }
    }
    let counted: Vec<u64> = iterations.iter().map(|i| i.evaluations).collect();
    assert_eq!(counted, evaluations, "{name}");
    assert!(all[0].0 != all[1].0, "the poses differ");
}

/// Small turns, a large one at once, a still one and one that comes and goes: their sub-steps, rounds and halves differ.
fn courses(rig: &Rig) -> Vec<Vec<Pose>> {
    let degrees = [
        [2.0, 4.0, 6.0],
        [5.0, 130.0, 125.0],
        [0.0, 0.0, 0.0],
        [50.0, 0.0, 11.0],
    ];
    let course = |row: [f32; 3]| row.map(|d| bent(rig, d)).to_vec();
    degrees.map(course).to_vec()
}

#[test]
fn instances_have_the_bits_of_deformers_of_their_own() {
    let Some(gpu) = gpu() else { return };
    let (device, rig) = (Device::Gpu(gpu.clone()), bundled("arm.glb"));
    for method in METHODS {
        same_bits(&device, &rig, &several(method, 1), &courses(&rig));
    }
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn instances_that_are_done_again_in_halves_leave_the_others_alone() {
    let Some(gpu) = gpu() else { return };
    let (device, rig) = (Device::Gpu(gpu.clone()), bundled("arm.glb"));
    let settings = Settings {
        substep_degrees: 50.0,
        ..several(Method::Tracking, 1)
    };
    let courses = [[165.0, 160.0], [10.0, 14.0], [0.0, 90.0]];
    let courses = courses.map(|row| row.map(|d| bent(&rig, d)).to_vec());
    let (_, first) = alone(&device, &rig, &settings, &courses[0]);
    assert!(first[0].halved > 0, "the course has halves");
    same_bits(&device, &rig, &settings, &courses);
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn the_cpu_has_instances_too() {
    let rig = bundled("arm.glb");
    let courses = [[3.0, 30.0], [0.0, 4.0]].map(|row| row.map(|d| bent(&rig, d)).to_vec());
    for method in METHODS {
        same_bits(&Device::Cpu, &rig, &several(method, 1), &courses);
    }
}

#[test]
fn an_instance_is_reset_and_restored_alone() {
    let Some(gpu) = gpu() else { return };
    let rig = bundled("arm.glb");
    let settings = several(Method::Tracking, 3);
    let mut deformer = Deformer::new(&Device::Gpu(gpu), rig.clone(), &settings).unwrap();
    let play = |deformer: &mut Deformer, degrees: [f32; 3]| {
        deformer.advance(&degrees.map(|d| bent(&rig, d))).unwrap();
        [0, 1, 2].map(|row| deformer.instance(row).unwrap().read().unwrap())
    };
    let first = play(&mut deformer, [5.0, 20.0, 5.0]);
    let state = deformer.instance(1).unwrap().save().unwrap().unwrap();
    let second = play(&mut deformer, [9.0, 26.0, 9.0]);
    // Where another instance was, and from rest.
    deformer.instance(0).unwrap().restore(&state).unwrap();
    deformer.instance(1).unwrap().reset().unwrap();
    let third = play(&mut deformer, [26.0, 20.0, 9.0]);
    assert!(third[0] == second[1]);
    assert!(third[1] == first[1]);
    assert!(deformer.instance(2).unwrap().save().unwrap().is_some());
    // All of them from rest.
    deformer.reset().unwrap();
    assert!(play(&mut deformer, [5.0, 20.0, 5.0]) == first);
}

#[test]
fn fields_are_there_once_for_all_instances() {
    let Some(gpu) = gpu() else { return };
    let rig = bundled("arm.glb");
    let memory = |device: &Device, method, instances| -> MemoryReport {
        let settings = several(method, instances);
        Deformer::new(device, rig.clone(), &settings)
            .unwrap()
            .memory()
    };
    for (method, many) in [(Method::Implicit, 64), (Method::Tracking, 8)] {
        for device in [Device::Gpu(gpu.clone()), Device::Cpu] {
            let [one, all] = [1, many].map(|n| memory(&device, method, n));
            for class in ["fields", "operators"] {
                let of = |m: &MemoryReport| m.classes.get(class).copied().unwrap_or(0);
                assert_eq!(of(&one), of(&all), "{class}");
                assert!(of(&one) > 0, "{class}");
            }
            // What instances have for themselves is there as often as they are, and hardly more is there at all.
            let growth = all.classes["transient"] as f64 / one.classes["transient"] as f64;
            let often = f64::from(many);
            assert!((0.9 * often..=often).contains(&growth), "{growth}");
            let shared = one.classes["fields"] + one.classes["operators"];
            assert!(all.total - shared <= u64::from(many) * (one.total - shared));
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let Some(gpu) = gpu() else { return };
    let (device, rig) = (Device::Gpu(gpu.clone()), bundled("arm.glb"));
    let new =
        |instances| Deformer::new(&device, rig.clone(), &several(Method::Implicit, instances));
    let mut three = new(3).unwrap();
    let rest = Pose::rest(&rig.skeleton);
    let poses = vec![rest.clone(); 3];
    three.advance(&poses).unwrap();
    let before = three.instance(2).unwrap().read().unwrap();
    let mut broken = poses.clone();
    broken[2].matrices[0] = Mat4::ZERO;
    let texels = u64::from(gpu.limits().max_texel_buffer_elements);
    let index = u64::from(3 * crate::layout::CELLS.pow(3));
    let too_many = (texels / index * 3 + 3) as u32;
    let errors = [
        (three.advance(&rest).unwrap_err(), "1 for 3 instances"),
        (three.advance(&poses[..2]).unwrap_err(), "2 for 3 instances"),
        (three.advance(&broken).unwrap_err(), "upper"),
        (three.instance(3).err().unwrap(), "3, counted from 0, of 3"),
        (new(0).err().unwrap(), "instances"),
        (new(65_536).err().unwrap(), "instances"),
        (new(too_many).err().unwrap(), "index"),
    ];
    for (error, reason) in &errors {
        assert!(error.to_string().contains(reason), "{reason}: {error}");
    }
    let too_long = errors.last().unwrap().0.to_string();
    assert!(too_long.contains("a texel buffer has"), "{too_long}");
    assert!(
        too_long.contains(&format!("each of {too_many} instances")),
        "{too_long}"
    );
    assert!(three.instance(2).unwrap().read().unwrap() == before);
    assert_eq!(Resource::Index.label(), "index");
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}
