//! `dermis bake`: a deformed character as files that other programs read.

use std::{path::PathBuf, time::Instant};

use clap::ValueEnum;
use dermis::{
    Error, Result,
    asset::{self, Model, MorphAnimation, MorphFrame, PlyFrame},
    deformer::{Method, Skin},
    gpu::Profile,
    report::Iterations,
    rig,
};
use glam::Quat;
use serde::Serialize;

use crate::{
    console::{self, Console},
    options::{DeviceOptions, MethodName, PoseOptions, ReportOptions, RigOptions},
    output::{Partial, frame_name},
    poses::{Fallback, Frame, Frames},
    session::{Character, Session},
    settled::Settled,
    table::count,
};

/// Deform a character and write the result: PLY or OBJ frames in a folder, or a GLB that any viewer plays.
#[derive(clap::Args)]
#[command(after_help = "\
A PLY holds, a vertex in the file's order: x y z nx ny nz field iso state bone. State: 0 untouched, 1 on its iso-value,
2 stopped in contact, 3 outside every field, 4 iteration limit,
5 past the limit of a spine's map.

A pose file is {\"joint\": [x, y, z, w]} or {\"joint\": {\"axis\": [0, 0, 1], \"degrees\": 90}}, or a list of such objects;
a rotation is applied after the joint's bind rotation, in the joint's own frame.

Positions are in the space of the file's scene for a clip, and in that of the file's vertices for all other poses; a
GLB stands upright either way.

Tracking goes on from frame to frame, the first of which it reaches from rest; random poses are all reached from rest.

Examples:
  dermis bake CesiumMan.glb -o out.glb                  the first clip, as an animation
  dermis bake CesiumMan.glb -o frames --frames 0..10    ten frames as PLY
  dermis bake arm.glb -o bent --pose bent.json --method dqs --format obj
  dermis bake hand.glb -o out.glb --random 5 --degrees 60 --joint index2=bulge --opening index2=finger
  dermis bake man.glb -o out.glb --method tracking --rigid head --controller forearm=finger")]
pub(crate) struct Args {
    /// glTF or GLB file.
    file: PathBuf,
    /// A folder for frame_0000.ply …, or a .glb file.
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Format; by default glb for a name that ends in .glb, and a folder of PLY files otherwise.
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Write into a folder that is not empty, replacing the frames of an earlier bake; other files stay.
    #[arg(long)]
    force: bool,
    /// How to deform.
    #[arg(long, value_enum, default_value = "implicit")]
    method: MethodName,
    #[command(flatten)]
    poses: PoseOptions,
    #[command(flatten)]
    rig: RigOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// Folder of binary PLY files, with field values and contact states
    Ply,
    /// Folder of OBJ files
    Obj,
    /// One file with morph-target animation
    Glb,
}

#[derive(Serialize)]
struct Report {
    file: String,
    output: String,
    method: &'static str,
    device: String,
    source: String,
    clip: Option<String>,
    fps: f32,
    frames: Vec<FrameReport>,
}

#[derive(Serialize)]
struct FrameReport {
    frame: usize,
    seconds: f32,
    #[serde(flatten)]
    settled: Settled,
    settled_share: Option<f64>,
    /// Of tracking.
    #[serde(skip_serializing_if = "Option::is_none")]
    iterations: Option<Iterations>,
    ms: f64,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let method = args.method.method();
    let format = choose_format(args)?;
    // Made before the work, so that an unwritable place is found at once.
    let output = Output::create(args, format)?;
    let character = Character::load(&args.file)?;
    let frames = Frames::choose(&args.poses, &character, Fallback::Rest, 90.0, &console)?;
    let session = Session::open(character, &args.rig, &args.device, Profile::Off, &console)?;
    let mut deformer = session.deformer(method)?;
    let device = session.device_report().name;
    let mut writer = Writer {
        output,
        method: args.method.name(),
        clip: frames.clip.as_deref().unwrap_or(&frames.source),
        device: &device,
        upright: frames.upright,
        triangles: &session.rig.rows.triangles,
    };
    let mut report = Report {
        file: args.file.display().to_string(),
        output: args.output.display().to_string(),
        method: args.method.name(),
        device: device.clone(),
        source: frames.source.clone(),
        clip: frames.clip.clone(),
        fps: frames.fps,
        frames: Vec::new(),
    };
    for (row, frame) in frames.frames.iter().enumerate() {
        let begin = Instant::now();
        if frames.independent {
            deformer.reset()?;
        }
        deformer.advance(&frame.pose)?;
        let skin = deformer.read()?;
        let ms = begin.elapsed().as_secs_f64() * 1e3;
        check_finite(&skin, frame)?;
        let iterations = match method {
            Method::Tracking => Some(deformer.iterations()?),
            _ => None,
        };
        report.frames.push(describe(frame, &skin, iterations, ms));
        writer.write(row, frame, skin)?;
    }
    warn_of_cap(&report, &console)?;
    session.finish()?;
    writer.finish(&session.model, args.rig.subdivide)?;
    console.text(summary(&report))?;
    console::json(&args.report, &report)
}

fn choose_format(args: &Args) -> Result<Format> {
    let extension = args.output.extension().and_then(|e| e.to_str());
    let glb = extension.is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    match (args.format, extension) {
        (Some(Format::Glb), _) if !glb => Err(Error::argument("--output", "ends in .glb for glb")),
        (Some(Format::Ply | Format::Obj), _) if glb => Err(Error::argument(
            "--output",
            "is a folder for this --format, not a .glb file",
        )),
        (Some(format), _) => Ok(format),
        (None, _) if glb => Ok(Format::Glb),
        (None, Some("ply" | "obj" | "gltf")) => Err(Error::argument(
            "--output",
            "give a folder, which gets a file a frame, or a .glb file",
        )),
        (None, _) => Ok(Format::Ply),
    }
}

fn check_finite(skin: &Skin, frame: &Frame) -> Result<()> {
    let rows = skin.positions.iter().zip(&skin.normals);
    let mut finite = rows.map(|(p, n)| p.is_finite() && n.is_finite());
    let broken = finite.position(|finite| !finite);
    broken.map_or(Ok(()), |row| {
        Err(Error::Pose {
            element: format!("frame {}", frame.number),
            reason: format!("vertex {row} of the result is not finite"),
        })
    })
}

fn describe(frame: &Frame, skin: &Skin, iterations: Option<Iterations>, ms: f64) -> FrameReport {
    let settled = Settled::of(skin);
    FrameReport {
        frame: frame.number,
        seconds: frame.seconds,
        settled,
        settled_share: settled.share(),
        iterations,
        ms,
    }
}

/// Says where poses were too far apart for the sub-steps that a frame may have.
fn warn_of_cap(report: &Report, console: &Console) -> Result<()> {
    let capped = |f: &&FrameReport| f.iterations.is_some_and(|i| i.capped);
    let count = report.frames.iter().filter(capped).count();
    match report.frames.iter().find(capped) {
        Some(first) => console.note(format_args!(
            "warning: {count} frames, first {}, turn further than their sub-steps should: skin may pass through skin",
            first.frame
        )),
        None => Ok(()),
    }
}

fn summary(report: &Report) -> String {
    let mut all = Settled::default();
    for frame in &report.frames {
        all += frame.settled;
    }
    let frames = report.frames.len();
    let mut ms: Vec<f64> = report.frames.iter().map(|f| f.ms).collect();
    ms.sort_by(f64::total_cmp);
    let ms = ms.get(frames / 2).copied().unwrap_or(0.0);
    let vertices = report.frames.first().map_or(0, |f| f.settled.vertices);
    let quality = all.share().map_or(String::new(), |share| {
        format!(
            ", {:.2} % settled, {} in contact, {} at the iteration limit",
            100.0 * share,
            count(all.contact),
            count(all.iteration_limit)
        )
    });
    let limit = match all.past_limit {
        0 => String::new(),
        n => format!(", {} past the limit of their spine", count(n)),
    };
    format!(
        "{}: {} frames of {} ({}, {}), {} vertices{quality}{limit}, {ms:.1} ms a frame on {}",
        report.output,
        frames,
        report.file,
        report.source,
        report.method,
        count(vertices),
        report.device
    )
}

/// Where frames go.
enum Output {
    /// A file each, as they come.
    Folder(Partial, Format),
    /// All into one file at the end.
    Glb(Partial, Vec<(f32, Skin)>),
}

impl Output {
    fn create(args: &Args, format: Format) -> Result<Self> {
        if format == Format::Glb {
            return Ok(Self::Glb(Partial::file(&args.output)?, Vec::new()));
        }
        Ok(Self::Folder(
            Partial::folder(&args.output, args.force)?,
            format,
        ))
    }
}

struct Writer<'a> {
    output: Output,
    method: &'a str,
    clip: &'a str,
    device: &'a str,
    upright: Quat,
    triangles: &'a [[u32; 3]],
}

impl Writer<'_> {
    fn write(&mut self, row: usize, frame: &Frame, skin: Skin) -> Result<()> {
        match &mut self.output {
            Output::Glb(_, skins) => {
                skins.push((frame.seconds, skin));
                Ok(())
            }
            Output::Folder(..) => self.write_frame(row, frame, &skin),
        }
    }

    fn write_frame(&self, row: usize, frame: &Frame, skin: &Skin) -> Result<()> {
        let Output::Folder(folder, format) = &self.output else {
            return Ok(());
        };
        let ply = PlyFrame {
            positions: &skin.positions,
            normals: &skin.normals,
            field: &skin.field,
            iso: &skin.iso,
            state: &skin.state,
            bone: &skin.bone,
            triangles: self.triangles,
            method: self.method,
            clip: self.clip,
            time: frame.seconds,
            device: self.device,
        };
        let written = match format {
            Format::Obj => asset::write_obj(&folder.path().join(frame_name(row, "obj")), &ply),
            _ => asset::write_ply(&folder.path().join(frame_name(row, "ply")), &ply),
        };
        written.map_err(|e| folder.blame(e))
    }

    fn finish(self, model: &Model, subdivide: u32) -> Result<()> {
        match self.output {
            Output::Folder(folder, _) => folder.keep(),
            Output::Glb(file, skins) => {
                let start = skins.first().map_or(0.0, |(seconds, _)| *seconds);
                let frames: Vec<_> = skins.iter().map(|s| morph_frame(s, start)).collect();
                let animation = MorphAnimation {
                    method: self.method,
                    clip: self.clip,
                    upright: self.upright,
                    frames: &frames,
                };
                let model = rig::subdivide(model, subdivide)?;
                asset::write_glb_morph(file.path(), &model, &animation)
                    .map_err(|e| file.blame(e))?;
                file.keep()
            }
        }
    }
}

/// A key of the animation, which begins at 0.
fn morph_frame((seconds, skin): &(f32, Skin), start: f32) -> MorphFrame<'_> {
    MorphFrame {
        seconds: seconds - start,
        positions: &skin.positions,
        normals: &skin.normals,
    }
}
