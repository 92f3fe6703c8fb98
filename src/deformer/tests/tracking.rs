//! Tracking as a whole: its way back to rest, its state, what it refuses.

use glam::Vec3;

use super::{gpu, rig};
use crate::{
    deformer::{Deformer, Device, Method, Settings, statics::Statics},
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
    assert_eq!(state.pose(), &Pose::rest(&rig.skeleton));
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
