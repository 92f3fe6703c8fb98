//! Bent meshes as files.

use std::path::Path;

use dermis::{
    Error, Result,
    asset::{self, MorphAnimation, MorphFrame, SurfaceFormat, SurfaceFrame},
};
use glam::Vec3;

use super::{bender::Outcome, shape::Shape};
use crate::output::{Partial, frame_name};

/// Where frames go.
pub(super) enum Output {
    File(Partial, SurfaceFormat),
    Glb(Partial),
    Folder(Partial),
}

impl Output {
    pub(super) fn create(path: &Path, frames: usize, force: bool) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str());
        if extension.is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
            return Ok(Self::Glb(Partial::file(path)?));
        }
        match (SurfaceFormat::of(path), extension) {
            (Some(format), _) if frames == 1 => Ok(Self::File(Partial::file(path)?, format)),
            (None, None) if frames > 1 => Ok(Self::Folder(Partial::folder(path, force)?)),
            (_, _) if frames == 1 => Err(Error::argument(
                "--output",
                "ends in .obj, .ply, .off or .glb",
            )),
            _ => Err(Error::argument(
                "--output",
                "is a .glb file or a folder for several frames",
            )),
        }
    }

    /// Writes all frames, each with its time in seconds.
    pub(super) fn write(
        self,
        shape: &Shape,
        frames: &[(f32, Outcome)],
        comment: &str,
    ) -> Result<()> {
        match self {
            Self::File(partial, format) => {
                write(partial.path(), format, shape, &frames[0].1, comment)
                    .map_err(|e| partial.blame(e))?;
                partial.keep()
            }
            Self::Folder(partial) => {
                for (row, (_, outcome)) in frames.iter().enumerate() {
                    let path = partial.path().join(frame_name(row, "ply"));
                    write(&path, SurfaceFormat::Ply, shape, outcome, comment)
                        .map_err(|e| partial.blame(e))?;
                }
                partial.keep()
            }
            Self::Glb(partial) => {
                glb(partial.path(), shape, frames).map_err(|e| partial.blame(e))?;
                partial.keep()
            }
        }
    }
}

fn singles(rows: &[glam::DVec3]) -> Vec<Vec3> {
    rows.iter().map(|v| v.as_vec3()).collect()
}

fn write(
    path: &Path,
    format: SurfaceFormat,
    shape: &Shape,
    outcome: &Outcome,
    comment: &str,
) -> Result<()> {
    let bent = &outcome.bent;
    let limit: Vec<f32> = bent.distances.iter().map(|d| *d as f32).collect();
    let flags: Vec<f32> = bent.flags.iter().map(|f| *f as f32).collect();
    let frame = SurfaceFrame {
        positions: &singles(&bent.positions),
        normals: &singles(&bent.normals),
        triangles: shape.triangles(),
        comment,
        columns: &[("limit", &limit), ("flags", &flags)],
    };
    asset::write_surface(path, format, &frame)
}

fn glb(path: &Path, shape: &Shape, frames: &[(f32, Outcome)]) -> Result<()> {
    let rows: Vec<(f32, Vec<Vec3>, Vec<Vec3>)> = frames
        .iter()
        .map(|(seconds, o)| {
            (
                *seconds,
                singles(&o.bent.positions),
                singles(&o.bent.normals),
            )
        })
        .collect();
    let frames: Vec<MorphFrame<'_>> = rows
        .iter()
        .map(|(seconds, positions, normals)| MorphFrame {
            seconds: *seconds,
            positions,
            normals,
        })
        .collect();
    let animation = MorphAnimation {
        method: "flesh",
        clip: "slide",
        upright: shape.upright,
        frames: &frames,
    };
    asset::write_glb_morph(path, &shape.model, &animation)
}
