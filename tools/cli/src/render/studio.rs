//! Camera, light and colours: what all pictures of a run share.

use dermis::{
    Result,
    deformer::{Device, Method, Skin},
    render::{
        self, Attributes, Background, Bounds, Camera, Picture, Projection, Renderer, Scene, Shading,
    },
};
use glam::{Quat, Vec3};

use super::{Args, Shot};
use crate::session::{Session, check_validation, drawing_device};

/// Draws skins, all from the same distance.
pub(super) struct Studio {
    device: Device,
    renderer: Renderer,
    camera: Camera,
    shading: Shading,
    wireframe: bool,
    /// Stands the skins up.
    upright: Quat,
}

impl Studio {
    /// A studio with a camera that sees the character, turned `upright`, in every shot.
    pub(super) fn open(
        args: &Args,
        session: &Session,
        shots: &[Shot],
        upright: Quat,
    ) -> Result<Self> {
        let gpu = drawing_device(&session.device, args.device.validation)?;
        let renderer = Renderer::new(&gpu, args.size.0, args.size.1)?;
        let bounds = match &args.focus {
            Some(joint) => close_up(session, shots, upright, joint)?,
            None => bounds(session, shots, upright)?,
        };
        let bounds = match args.turntable {
            Some(_) => bounds.turned(),
            None => bounds,
        };
        Ok(Self {
            camera: camera(args, &bounds, renderer.aspect())?,
            device: Device::Gpu(gpu),
            renderer,
            shading: args.shade,
            wireframe: args.wireframe,
            upright,
        })
    }

    /// A picture of `skin` from `orbit` degrees around.
    pub(super) fn draw(
        &mut self,
        skin: &Skin,
        triangles: &[[u32; 3]],
        orbit: f32,
    ) -> Result<Picture> {
        let positions = turned(&skin.positions, self.upright);
        let normals = turned(&skin.normals, self.upright);
        let attributes = Attributes {
            normals: &normals,
            field: &skin.field,
            iso: &skin.iso,
            state: &skin.state,
            bone: &skin.bone,
        };
        let colours = render::colours(self.shading, &attributes)?;
        let mut picture = self.renderer.draw(&Scene {
            positions: &positions,
            normals: &normals,
            colours: &colours,
            triangles,
            camera: self.camera.orbit(orbit),
            wireframe: self.wireframe,
            background: Background::default(),
        })?;
        render::legend(&mut picture, self.shading);
        Ok(picture)
    }

    /// The last word: fails if the validation layer had something to say.
    pub(super) fn finish(&self) -> Result<()> {
        check_validation(&self.device)
    }
}

fn camera(args: &Args, bounds: &Bounds, aspect: f32) -> Result<Camera> {
    if let (Some(eye), Some(target)) = (args.eye, args.target) {
        return Camera::standing(eye, target, bounds);
    }
    let projection = match args.orthographic {
        true => Projection::Orthographic { height: 0.0 },
        false => Projection::default(),
    };
    Ok(Camera::framing(bounds, args.view, projection, aspect))
}

/// How far the character reaches in all shots, by the geometric methods, which are cheap: the others stay between or
/// close to these.
fn bounds(session: &Session, shots: &[Shot], upright: Quat) -> Result<Bounds> {
    let mut all = Vec::new();
    for method in [Method::Lbs, Method::Dqs] {
        let mut deformer = session.deformer(method)?;
        let mut last = None;
        for shot in shots {
            // A turntable shows one frame from many sides.
            if last.replace(shot.frame.number) != Some(shot.frame.number) {
                deformer.advance(&shot.frame.pose)?;
                all.push(Bounds::of(&turned(&deformer.read()?.positions, upright)));
            }
        }
    }
    let union = all.into_iter().reduce(|a, b| a.union(&b));
    Ok(union.unwrap_or_else(|| Bounds::of(&session.model.positions)))
}

/// A joint's surroundings in all shots: a ball of twice the radius of its part of the skin.
fn close_up(session: &Session, shots: &[Shot], upright: Quat, name: &str) -> Result<Bounds> {
    let rig = &session.rig;
    let joint = rig.skeleton.find(name)?;
    let origin = rig.skeleton.origin(joint);
    let posed = |shot: &Shot| shot.frame.pose.matrices[joint].transform_point3(origin);
    let centres: Vec<Vec3> = shots.iter().map(posed).collect();
    let balls = balls(&turned(&centres, upright), 2.0 * rig.radius[joint]);
    Ok(Bounds::of(&balls))
}

/// The ends of each ball's axes.
fn balls(centres: &[Vec3], radius: f32) -> Vec<Vec3> {
    let ends = |c: &Vec3| Vec3::AXES.map(|axis| [*c + axis * radius, *c - axis * radius]);
    centres.iter().flat_map(ends).flatten().collect()
}

fn turned(vectors: &[Vec3], turn: Quat) -> Vec<Vec3> {
    vectors.iter().map(|&v| turn * v).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_reach_their_radius_on_all_sides_of_every_centre() {
        let centres = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-4.0, 0.0, 0.5)];
        let points = balls(&centres, 0.5);
        assert_eq!(points.len(), 12);
        for (of, centre) in points.chunks(6).zip(centres) {
            let low = of.iter().copied().reduce(Vec3::min);
            let high = of.iter().copied().reduce(Vec3::max);
            assert_eq!(
                (low, high),
                (Some(centre - 0.5), Some(centre + 0.5)),
                "{of:?}"
            );
        }
    }
}
