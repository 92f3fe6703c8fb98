//! What the bundled characters promise.

use std::sync::OnceLock;

use super::*;

/// All characters, made once.
fn models() -> &'static [Model] {
    static MODELS: OnceLock<Vec<Model>> = OnceLock::new();
    MODELS.get_or_init(make_all)
}

fn make_all() -> Vec<Model> {
    CHARACTERS
        .iter()
        .map(|(name, make)| make().unwrap_or_else(|e| panic!("{name}: {e}")))
        .collect()
}

#[test]
fn characters_have_the_size_they_promise() {
    let promised = [
        ("arm", 6_500..7_500, 2),
        ("hand", 6_000..10_000, 16),
        ("mannequin", 14_000..16_000, 20),
        ("tail", 6_500..7_500, 9),
    ];
    for (model, (name, vertices, joints)) in models().iter().zip(promised) {
        let count = model.positions.len();
        assert!(vertices.contains(&count), "{name}: {count} vertices");
        assert!(
            model.joints.len() >= joints,
            "{name}: {} joints",
            model.joints.len()
        );
    }
}

#[test]
fn skins_close_face_outwards_and_have_no_slivers() {
    for model in models() {
        let name = model.path.display();
        let check = surface::check_closed(&model.triangles, model.positions.len());
        assert_eq!(check, Ok(()), "{name}");
        let mut volume = 0.0;
        for triangle in &model.triangles {
            let [a, b, c] = triangle.map(|row| model.positions[row as usize].as_dvec3());
            volume += a.dot(b.cross(c)) / 6.0;
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let height = (b - a).cross(c - a).length() / longest;
            assert!(
                height > 0.15 * longest,
                "{name}: a triangle {longest} long and {height} high"
            );
        }
        assert!(volume > 0.0, "{name}: inside out");
    }
}

#[test]
fn normals_point_outwards() {
    for model in models() {
        let positions: Vec<_> = model.positions.iter().map(|p| p.as_dvec3()).collect();
        let faces = surface::normals(&positions, &model.triangles);
        let agreement = model
            .normals
            .iter()
            .zip(&faces)
            .map(|(n, face)| n.dot(face.as_vec3()));
        let worst = agreement.fold(1.0, f32::min);
        assert!(worst > 0.98, "{}: {worst}", model.path.display());
    }
}

#[test]
fn every_joint_has_skin_of_its_own() {
    for model in models() {
        for (row, joint) in model.joints.iter().enumerate() {
            let own = model
                .influences
                .iter()
                .filter(|list| list[0].joint as usize == row)
                .count();
            assert!(
                own >= 30,
                "{}: {} leads {own} vertices",
                model.path.display(),
                joint.name
            );
        }
    }
}

#[test]
fn characters_are_the_same_every_time() {
    for (first, second) in models().iter().zip(make_all()) {
        assert!(first.positions == second.positions && first.triangles == second.triangles);
        assert!(first.influences == second.influences);
    }
}
