//! `dermis render`: pictures of a deformed character, methods side by side.

mod gallery;
mod studio;

use std::path::PathBuf;

pub(crate) use gallery::{Gallery, Tile};

use dermis::{
    Error, Result,
    deformer::{Deformer, Method, Skin},
    gpu::Profile,
    render::{Shading, View},
    report::Progress as Step,
    rig::Pose,
};
use glam::Vec3;
use serde::Serialize;

use crate::{
    console::{self, Console},
    options::{DeviceOptions, MethodName, PoseOptions, ReportOptions, RigOptions},
    parse,
    poses::{Fallback, Frame, Frames},
    progress::Progress,
    render::studio::Studio,
    session::{Character, Session},
};

/// Draw a character offscreen: one picture, methods side by side, a turntable or the frames of an animation.
#[derive(clap::Args)]
#[command(after_help = "\
Without --time, --frames or --turntable the first frame is drawn. One picture goes to a PNG as it is; several go to a
PNG as one labelled sheet, or to a folder as frame_0000.png … Back sides are magenta, so that inverted skin stands out.
The character stands as in the file's scene, whatever the poses' source.
Tracking goes on from frame to frame, the first of which it reaches from rest; random poses are all reached from rest. A
turntable of one frame deforms it once.

Examples:
  dermis render CesiumMan.glb -o man.png --time 0.5
  dermis render arm.glb -o compare.png --pose bent.json --compare lbs,dqs,implicit --view front
  dermis render arm.glb -o biceps.png --pose bent.json --compare implicit,tracking --primitives biceps.json
  dermis render arm.glb -o error.png --pose bent.json --shade error --wireframe
  dermis render hand.glb -o knuckle.png --clip fist --time 0.5 --view side --focus index_2
  dermis render mannequin.glb -o table --turntable 36
  dermis render mannequin.glb -o walk --clip walk --frames 0..30 --compare lbs,implicit")]
pub(crate) struct Args {
    /// glTF or GLB file.
    file: PathBuf,
    /// A .png file, or a folder for frame_0000.png ….
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Write into a folder that is not empty, replacing the frames of an earlier run; other files stay.
    #[arg(long)]
    force: bool,
    /// How to deform.
    #[arg(
        long,
        value_enum,
        default_value = "implicit",
        conflicts_with = "compare"
    )]
    method: MethodName,
    /// Several methods, a labelled picture each.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "METHOD,…")]
    compare: Vec<MethodName>,
    /// Where from: front, side, top or three-quarter.
    #[arg(long, default_value = "three-quarter", value_name = "VIEW")]
    view: View,
    /// Draw close up what lies around this joint, rather than the whole character.
    #[arg(long, value_name = "JOINT")]
    focus: Option<String>,
    /// Stand here, in model units, instead of where the whole character is just seen.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::place, allow_hyphen_values = true, requires = "target",
        conflicts_with_all = ["view", "focus", "orthographic"])]
    eye: Option<Vec3>,
    /// Look here from --eye.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::place, allow_hyphen_values = true, requires = "eye")]
    target: Option<Vec3>,
    /// Parallel rays instead of a lens.
    #[arg(long)]
    orthographic: bool,
    /// Size of each picture in pixels.
    #[arg(long, default_value = "720x720", value_name = "WxH", value_parser = parse::size)]
    size: (u32, u32),
    /// What colours mean: skin (nothing), state, error, bone or normals.
    #[arg(long, default_value = "skin", value_name = "SHADING")]
    shade: Shading,
    /// Draw the triangles' edges too.
    #[arg(long)]
    wireframe: bool,
    /// This many pictures all around the character.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=3600))]
    turntable: Option<u32>,
    /// The frame nearest to this time.
    #[arg(long, value_name = "SECONDS", value_parser = parse::not_negative, conflicts_with = "frames")]
    time: Option<f32>,
    #[command(flatten)]
    poses: PoseOptions,
    #[command(flatten)]
    rig: RigOptions,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(Serialize)]
struct Report {
    file: String,
    output: String,
    methods: Vec<&'static str>,
    device: String,
    source: String,
    size: (u32, u32),
    pictures: Vec<PictureReport>,
}

#[derive(Serialize)]
struct PictureReport {
    frame: usize,
    seconds: f32,
    orbit_degrees: f32,
}

/// One moment seen from one side.
struct Shot<'a> {
    frame: &'a Frame,
    orbit: f32,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let methods = methods(args);
    // Made before the work, so that an unwritable place is found at once.
    let mut gallery = Gallery::open(&args.output, args.force)?;
    let character = Character::load(&args.file)?;
    if let Some(joint) = &args.focus {
        character.skeleton.find(joint)?;
    }
    let frames = Frames::choose(&args.poses, &character, Fallback::Rest, 90.0, &console)?;
    let shots = shots(args, &frames)?;
    let session = Session::open(character, &args.rig, &args.device, Profile::Off, &console)?;
    let studio = Studio::open(args, &session, &shots, frames.upright)?;
    let mut stage = Stage::new(&session, methods, studio, frames.independent)?;
    let progress = Progress::new(&console);
    for (done, shot) in shots.iter().enumerate() {
        progress.show(Step {
            stage: "draw",
            done,
            total: shots.len(),
        });
        gallery.add(stage.draw(shot, shots.len())?)?;
    }
    progress.finish();
    session.finish()?;
    stage.studio.finish()?;
    gallery.close()?;
    let report = report(args, &session, &frames, &stage, &shots);
    console.text(summary(&report))?;
    console::json(&args.report, &report)
}

fn methods(args: &Args) -> Vec<(MethodName, Method)> {
    let names = match args.compare.as_slice() {
        [] => std::slice::from_ref(&args.method),
        names => names,
    };
    names.iter().map(|&n| (n, n.method())).collect()
}

/// The pictures to take: of every frame that the user asked for, or of one frame from every side.
fn shots<'a>(args: &Args, frames: &'a Frames) -> Result<Vec<Shot<'a>>> {
    let all = &frames.frames;
    let chosen: Vec<&Frame> = match (args.time, &args.poses.frames) {
        (Some(time), _) => vec![nearest(all, time, frames.fps)?],
        (None, Some(_)) => all.iter().collect(),
        (None, None) => all.iter().take(1).collect(),
    };
    let count = args.turntable.map_or(chosen.len(), |n| n as usize);
    let step = args.turntable.map_or(0.0, |n| 360.0 / n as f32);
    let shot = |i: usize| Shot {
        frame: chosen[i % chosen.len()],
        orbit: i as f32 * step,
    };
    match chosen.len() {
        0 => Err(Error::argument("--frames", "there is no frame to draw")),
        _ => Ok((0..count).map(shot).collect()),
    }
}

fn nearest(frames: &[Frame], time: f32, fps: f32) -> Result<&Frame> {
    let distance = |f: &&Frame| (f.seconds - time).abs();
    let best = frames
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    // A clip may end within a frame of its last key.
    best.filter(|f| distance(f) <= 1.0 / fps).ok_or_else(|| {
        let end = frames.last().map_or(0.0, |f| f.seconds);
        Error::argument("--time", format!("{time} s passes the end, {end} s"))
    })
}

/// One method's character.
struct Cast {
    name: MethodName,
    deformer: Deformer,
    /// The skin in the frame that was shown last.
    skin: Skin,
}

impl Cast {
    fn play(&mut self, pose: &Pose, from_rest: bool) -> Result<()> {
        if from_rest {
            self.deformer.reset()?;
        }
        self.deformer.advance(pose)?;
        self.skin = self.deformer.read()?;
        Ok(())
    }
}

/// A cast a method, and the studio in which they are drawn.
struct Stage<'a> {
    session: &'a Session,
    casts: Vec<Cast>,
    studio: Studio,
    /// Whether no frame follows from the one before.
    independent: bool,
    /// Number of the frame that was shown last.
    shown: Option<usize>,
}

impl<'a> Stage<'a> {
    fn new(
        session: &'a Session,
        methods: Vec<(MethodName, Method)>,
        studio: Studio,
        independent: bool,
    ) -> Result<Self> {
        let cast = |(name, method)| {
            let deformer = session.deformer(method)?;
            Ok(Cast {
                name,
                deformer,
                skin: Skin::default(),
            })
        };
        Ok(Self {
            casts: methods.into_iter().map(cast).collect::<Result<_>>()?,
            session,
            studio,
            independent,
            shown: None,
        })
    }

    /// A labelled picture of the shot by each method.
    fn draw(&mut self, shot: &Shot, shots: usize) -> Result<Vec<Tile>> {
        let triangles = &self.session.rig.rows.triangles;
        let mut tiles = Vec::with_capacity(self.casts.len());
        // A turntable shows one frame from many sides: a tracked skin must not go on in between.
        let next = self.shown.replace(shot.frame.number) != Some(shot.frame.number);
        for cast in &mut self.casts {
            if next {
                cast.play(&shot.frame.pose, self.independent)?;
            }
            let picture = self.studio.draw(&cast.skin, triangles, shot.orbit)?;
            tiles.push((label(cast.name, shot, shots), picture));
        }
        Ok(tiles)
    }
}

fn label(method: MethodName, shot: &Shot, shots: usize) -> String {
    let name = match method {
        MethodName::Lbs => "linear blend",
        MethodName::Dqs => "dual quaternion",
        MethodName::Implicit => "implicit",
        MethodName::Tracking => "tracking",
    };
    match shots {
        1 => name.into(),
        _ if shot.orbit != 0.0 => format!("{name}, {:.0} deg", shot.orbit),
        _ => format!("{name}, {:.2} s", shot.frame.seconds),
    }
}

fn report(
    args: &Args,
    session: &Session,
    frames: &Frames,
    stage: &Stage,
    shots: &[Shot],
) -> Report {
    let picture = |s: &Shot| PictureReport {
        frame: s.frame.number,
        seconds: s.frame.seconds,
        orbit_degrees: s.orbit,
    };
    Report {
        file: args.file.display().to_string(),
        output: args.output.display().to_string(),
        methods: stage.casts.iter().map(|c| c.name.name()).collect(),
        device: session.device_report().name,
        source: frames.source.clone(),
        size: args.size,
        pictures: shots.iter().map(picture).collect(),
    }
}

fn summary(report: &Report) -> String {
    format!(
        "{}: {} × {} of {} ({}) on {}",
        report.output,
        report.pictures.len(),
        report.methods.join(", "),
        report.file,
        report.source,
        report.device
    )
}
