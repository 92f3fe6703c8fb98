//! Tracking as a whole: its way back to rest, its state, what it refuses.

use glam::Vec3;

use glam::Mat4;

use super::{bundled, gpu, rig, turned};
use crate::{
    deformer::{Deformer, Device, Method, Settings, Skin, statics::Statics},
    layout::{NO_SEED, state},
    mesh::Mesh,
    rig::{Pose, Rig},
};

fn bent(rig: &Rig, degrees: f32) -> Pose {
    Pose::random(&rig.skeleton, degrees, 3).unwrap()
}

#[test]
fn tracking_comes_back_to_rest_and_goes_on_from_a_saved_state() {
    let (Some(gpu), Some(rig)) = (gpu(), rig("khronos/CesiumMan.glb", &[])) else {
        return;
    };
    let settings = Settings {
        method: Method::Tracking,
        ..Settings::default()
    };
    let mut deformer = Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &settings).unwrap();
    let mut play = |degrees: &[f32]| {
        for d in degrees {
            deformer.advance(&bent(&rig, *d)).unwrap();
        }
        let skin = deformer.read().unwrap();
        (skin, deformer.save().unwrap().unwrap())
    };
    let (_, half_way) = play(&[5.0, 10.0, 15.0]);
    let (first, _) = play(&[20.0, 10.0]);
    assert!(first.state.contains(&(state::ON_ISO as u8)));
    let (rest, _) = play(&[0.0, 0.0, 0.0]);
    let away = rig.rows.vertex.iter().zip(&rest.positions).map(|(v, p)| {
        let v = *v as usize;
        let radius = rig.radius[rig.part[v] as usize];
        ((*p - rig.mesh.positions[v]).length() / radius).powi(2)
    });
    let rms = (away.sum::<f32>() / rest.positions.len() as f32).sqrt();
    assert!(rms < 5e-3, "{rms}");
    // The same bits from a saved state, and from rest after a reset, whatever came between.
    deformer.restore(&half_way).unwrap();
    for d in [20.0, 10.0] {
        deformer.advance(&bent(&rig, d)).unwrap();
    }
    assert!(deformer.read().unwrap() == first);
    let cuts = [0, 1].map(|_| {
        deformer.reset().unwrap();
        deformer.advance(&bent(&rig, 40.0)).unwrap();
        assert!(deformer.iterations().unwrap().substeps > 1);
        deformer.read().unwrap()
    });
    assert!(cuts[0] == cuts[1]);
    // A saved rest is as good as a reset.
    deformer.reset().unwrap();
    let at_rest = deformer.save().unwrap().unwrap();
    deformer.advance(&bent(&rig, 10.0)).unwrap();
    deformer.restore(&at_rest).unwrap();
    deformer.advance(&bent(&rig, 40.0)).unwrap();
    assert!(deformer.read().unwrap() == cuts[0]);
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn operators_of_one_method_are_refused_in_the_other() {
    use crate::compose::Operator::{Blend, Contact};
    let pairs = [(Blend, Method::Tracking), (Contact, Method::Implicit)];
    for (operator, method) in pairs {
        let Some(rig) = rig("khronos/CesiumMan.glb", &[("joint_8", operator)]) else {
            return;
        };
        let settings = Settings {
            method,
            ..Settings::default()
        };
        let error = Deformer::new(&Device::Cpu, rig, &settings).err().unwrap();
        assert!(error.to_string().contains("joint_8"), "{error}");
    }
}

#[test]
fn only_tracking_has_a_state() {
    let Some(rig) = rig("khronos/CesiumMan.glb", &[]) else {
        return;
    };
    let [mut tracking, mut implicit] = [Method::Tracking, Method::Implicit].map(|method| {
        let settings = Settings {
            method,
            ..Settings::default()
        };
        Deformer::new(&Device::Cpu, rig.clone(), &settings).unwrap()
    });
    let state = tracking.save().unwrap().unwrap();
    assert_eq!(state.pose(), None);
    assert!(implicit.save().unwrap().is_none());
    assert!(implicit.restore(&state).is_err());
    assert!(tracking.restore(&state).is_ok());
}

#[test]
fn the_freedom_to_slide_ends_where_the_skin_is_rigid() {
    let corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let rig = Rig {
        // The last vertex has no neighbours.
        mesh: Mesh::new(corners, vec![[0, 1, 2]]),
        part: vec![0; 4],
        radius: vec![0.5],
        rigid: vec![0.0, 0.25, 1.0, 0.0],
        ..Rig::default()
    };
    let bodies = Statics::bodies(&rig, &[0.5; 4], &[0, 1, 2, NO_SEED]);
    assert_eq!(bodies[1], [0.5, 0.5, 0.75, 1.0]);
    assert_eq!([0, 2, 3].map(|v| bodies[v][2]), [1.0, 0.0, 0.0]);
}

/// The longest edge over its length at rest: skin of the far side has longer ones than any other.
fn longest(rig: &Rig, skin: &Skin) -> f32 {
    let triangles = rig.rows.triangles.iter();
    let edges = triangles.flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    let stretch = edges.map(|[a, b]| {
        let at = |row: u32| skin.positions[row as usize];
        let rest = |row: u32| rig.mesh.positions[rig.rows.vertex[row as usize] as usize];
        at(a).distance(at(b)) / rest(a).distance(rest(b))
    });
    stretch.fold(0.0, f32::max)
}

#[test]
fn a_step_that_leads_through_another_part_is_done_again_in_halves() {
    let Some(gpu) = gpu() else { return };
    let rig = bundled("arm.glb");
    let bent = turned(&rig, "lower", Mat4::from_rotation_z(165f32.to_radians()));
    let mut settings = Settings {
        method: Method::Tracking,
        substep_degrees: 60.0,
        ..Settings::default()
    };
    let mut play = |halving_degrees: f32| {
        settings.halving_degrees = halving_degrees;
        let mut deformer =
            Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &settings).unwrap();
        deformer.advance(&bent).unwrap();
        let iterations = deformer.iterations().unwrap();
        assert_eq!(iterations.substeps, 3);
        (deformer.read().unwrap(), iterations)
    };
    let ((whole, plain), (halves, redone)) = (play(180.0), play(6.0));
    assert_eq!(plain.halved, 0);
    assert!(redone.halved > 0 && redone.evaluations > plain.evaluations);
    let (whole, halves) = (longest(&rig, &whole), longest(&rig, &halves));
    assert!(halves < 0.7 * whole, "{halves} {whole}");
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

#[test]
fn the_knee_of_the_mannequin_stays_closed_at_150_degrees() {
    let Some(gpu) = gpu() else { return };
    let turn = Mat4::from_rotation_x(150f32.to_radians());
    let rig = bundled("mannequin.glb");
    let bent = turned(&rig, "left_shin", turn);
    let settings = Settings {
        method: Method::Tracking,
        ..Settings::default()
    };
    let mut deformer = Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &settings).unwrap();
    deformer.advance(&bent).unwrap();
    let stretch = longest(&rig, &deformer.read().unwrap());
    assert!(stretch < 3.0, "{stretch}");
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}

/// How far the skins of the upper and the lower arm, bent by 150°, lie behind the plane that halves the bend: by how much a
/// vertex in contact does on average.
fn mixed(rig: &Rig, skin: &Skin) -> f32 {
    let lower = rig.skeleton.find("lower").unwrap();
    let half = 165f32.to_radians();
    let across = Vec3::new(-half.sin(), half.cos(), 0.0);
    let rows = rig.rows.vertex.iter().zip(&skin.positions);
    let in_contact = rows
        .zip(&skin.state)
        .filter(|(_, s)| **s == state::CONTACT as u8);
    let depths = in_contact.map(|((v, p), _)| {
        let side = if rig.part[*v as usize] as usize == lower {
            1.0
        } else {
            -1.0
        };
        (side * p.dot(across)).max(0.0)
    });
    let depths: Vec<f32> = depths.collect();
    assert!(depths.len() > 500, "{}", depths.len());
    depths.iter().sum::<f32>() / depths.len() as f32
}

#[test]
fn skins_in_contact_keep_their_sides() {
    let Some(gpu) = gpu() else { return };
    let rig = bundled("arm.glb");
    let settings = Settings {
        method: Method::Tracking,
        ..Settings::default()
    };
    let mut deformer = Deformer::new(&Device::Gpu(gpu.clone()), rig.clone(), &settings).unwrap();
    for tenth in 1..=10 {
        let turn = Mat4::from_rotation_z((15.0 * tenth as f32).to_radians());
        deformer.advance(&turned(&rig, "lower", turn)).unwrap();
    }
    let depth = mixed(&rig, &deformer.read().unwrap());
    // Half a percent of the radius; .0004 where nothing brings them back.
    assert!(depth < 2.5e-4, "{depth}");
    assert_eq!(gpu.validation_messages(), Vec::<String>::new());
}
