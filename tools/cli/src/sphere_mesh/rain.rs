//! `dermis sphere-mesh rain`: particles fall on a level that moves, and bounce off.

use std::{path::PathBuf, time::Instant};

use dermis::{
    Result,
    gpu::{Gpu, Profile},
    particles::{Particle, Settings},
    render::{Background, Bounds, Camera, Picture, Projection, Renderer, Scene, Spheres, View},
    report::Progress as Step,
    sphere_mesh::{Ball, Shape},
};
use glam::{Quat, Vec3};
use serde::Serialize;

use super::{
    InputFile, LevelOptions, check_places,
    render::up,
    shower::{Shower, Stage, Weather},
};
use crate::{
    console::{self, Console},
    options::{DeviceOptions, ReportOptions},
    parse,
    progress::Progress,
    render::Gallery,
    session::{check_validation, device_report, drawing_device, open_device},
    table::count,
};

/// Let particles rain on a level while it moves, bounce off its spheres, capsules and thick triangles, and draw that.
#[derive(clap::Args)]
#[command(after_help = "\
Particles are spheres that fall on the device, one invocation each; what touches is found in closed form, so that nothing
tunnels through, however fast. Those that have fallen past the level begin again above it. Grey ones have not touched
anything yet.

A folder gets frame_0000.png …, a PNG the last picture, or with --moments a labelled sheet of several, evenly spaced.

Examples:
  dermis sphere-mesh rain horse.dsm --spheres 46 -o rain.png
  dermis sphere-mesh rain horse.dsm --spheres 46 -o rain.png --moments 3 --seconds 2 --view side
  dermis sphere-mesh rain horse.dsm --spheres 46 -o rain --particles 20000 --loop --restitution 0.8
  dermis sphere-mesh rain horse.dsm --error 1 -o rain.png --up z --json -")]
pub(crate) struct Args {
    #[command(flatten)]
    input: InputFile,
    #[command(flatten)]
    level: LevelOptions,
    /// A .png file, or a folder for frame_0000.png ….
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Write into a folder that is not empty, replacing the frames of an earlier run; other files stay.
    #[arg(long)]
    force: bool,
    /// Number of particles.
    #[arg(long, value_name = "N", default_value_t = 4000, value_parser = clap::value_parser!(u32).range(1..=4_000_000))]
    particles: u32,
    /// Seconds of rain, up to an hour.
    #[arg(long, value_name = "S", default_value_t = 2.0, value_parser = seconds)]
    seconds: f32,
    /// Frames a second, of the pictures as of the sequence, up to 1000.
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = rate)]
    fps: f32,
    /// Begin the sequence again where it ends, instead of staying there.
    #[arg(long)]
    r#loop: bool,
    /// Pictures in a sheet.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    moments: u32,
    /// Steps of the particles a picture.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=1000))]
    steps: u32,
    /// Radius of the particles, in % of the sequence's diagonal.
    #[arg(long, value_name = "R", default_value_t = 0.5, value_parser = parse::positive)]
    radius: f32,
    /// Gravity, in diagonals of the sequence a second squared; the default is that of the earth for a diagonal of 2 metres.
    #[arg(long, value_name = "G", default_value_t = 4.9, value_parser = parse::not_negative)]
    gravity: f32,
    /// Share of the normal speed that a bounce leaves, 0 to 1.
    #[arg(long, value_name = "E", default_value_t = 0.5, value_parser = parse::not_negative)]
    restitution: f32,
    /// Coulomb's coefficient of friction.
    #[arg(long, value_name = "F", default_value_t = 0.2, value_parser = parse::not_negative)]
    friction: f32,
    /// Of the random places: the same seed gives the same rain.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Where from: front, side, top or three-quarter.
    #[arg(long, default_value = "three-quarter", value_name = "VIEW")]
    view: View,
    /// Axis of the sequence that is up.
    #[arg(long, default_value = "y", value_name = "x|y|z|-x|-y|-z", value_parser = up, allow_hyphen_values = true)]
    up: Vec3,
    /// Size of each picture in pixels.
    #[arg(long, default_value = "720x720", value_name = "WxH", value_parser = parse::size)]
    size: (u32, u32),
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    report: ReportOptions,
}

fn seconds(text: &str) -> Result<f32, String> {
    let seconds = parse::positive(text)?;
    if seconds <= 3600.0 {
        return Ok(seconds);
    }
    Err("up to 3600 seconds".into())
}

fn rate(text: &str) -> Result<f32, String> {
    let rate = parse::positive(text)?;
    if (0.01..=1000.0).contains(&rate) {
        return Ok(rate);
    }
    Err("from 0.01 to 1000 a second".into())
}

/// Most pictures in a row of a sheet.
const COLUMNS: u32 = 6;

/// Linear colours: of the level, of particles before and after their first contact.
const BODY: Vec3 = Vec3::new(0.30, 0.34, 0.42);
const FALLING: Vec3 = Vec3::new(0.45, 0.5, 0.55);
const BOUNCED: Vec3 = Vec3::new(0.85, 0.22, 0.03);

#[derive(Serialize)]
struct Report {
    file: String,
    output: String,
    device: String,
    spheres: usize,
    primitives: usize,
    particles: u32,
    frames: usize,
    contacts: u64,
    /// Means a frame: all steps with reading the particles, and a picture.
    simulate_ms: f64,
    draw_ms: f64,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    // Made before the work, so that an unwritable place is found at once.
    let gallery = Gallery::open(&args.output, args.force)?;
    check_places(&args.output, &[&args.input.file], &args.report)?;
    let mut gallery = gallery.with_rows(args.moments.div_ceil(COLUMNS) as usize);
    let hierarchy = args.input.load()?;
    let level = args.level.open(&hierarchy)?;
    let stage = Stage {
        hierarchy: &hierarchy,
        level: &level,
        upright: Quat::from_rotation_arc(args.up, Vec3::Y),
        fps: f64::from(args.fps),
        again: args.r#loop,
    };
    let frames = (args.seconds * args.fps).round().max(1.0) as usize;
    let at = |frame: f64| stage.at(frame / f64::from(args.fps));
    // Of a long rain the sequence's own frames are enough.
    let shapes: Vec<Shape> = (0..=frames.min(hierarchy.frames))
        .map(|f| at(f as f64))
        .collect();
    let device = open_device(&args.device, Profile::Off, &console)?;
    let gpu = drawing_device(&device, args.device.validation)?;
    let mut shower = Shower::new(&device, &shapes, &weather(args, hierarchy.diagonal))?;
    let mut painter = Painter::new(&gpu, args, &shapes, hierarchy.diagonal)?;
    let progress = Progress::new(&console);
    let steps = f64::from(args.steps);
    let (mut simulate, mut draw, mut pictures) = (0.0, 0.0, 0);
    let mut sheet = Vec::new();
    for frame in 0..frames {
        progress.show(Step {
            stage: "rain",
            done: frame,
            total: frames,
        });
        let begin = Instant::now();
        for step in 1..=args.steps {
            let shape = at(frame as f64 + f64::from(step) / steps);
            shower.advance(&shape, 1.0 / (args.fps * args.steps as f32))?;
        }
        shower.renew(1.0 / args.fps)?;
        simulate += begin.elapsed().as_secs_f64();
        if gallery.is_folder() || is_moment(frame + 1, frames, args.moments as usize) {
            let begin = Instant::now();
            let picture = painter.draw(&at(frame as f64 + 1.0), &shower.rows)?;
            let seconds = (frame + 1) as f32 / args.fps;
            sheet.push((format!("{seconds:.2} s"), picture));
            if gallery.is_folder() {
                gallery.add(std::mem::take(&mut sheet))?;
            }
            draw += begin.elapsed().as_secs_f64();
            pictures += 1;
        }
    }
    progress.finish();
    check_validation(&device)?;
    check_validation(&dermis::deformer::Device::Gpu(gpu))?;
    if !gallery.is_folder() {
        gallery.add(sheet)?;
    }
    gallery.close()?;
    let report = Report {
        file: args.input.file.display().to_string(),
        output: args.output.display().to_string(),
        device: device_report(&device).name,
        spheres: level.nodes.len(),
        primitives: shower.particles.primitives(),
        particles: args.particles,
        frames,
        contacts: shower.contacts(),
        simulate_ms: 1e3 * simulate / frames as f64,
        draw_ms: 1e3 * draw / f64::from(pictures.max(1)),
    };
    console.text(format_args!(
        "{}: {} particles against {} primitives, {} contacts in {} frames on {}; {:.2} ms a frame, {:.1} ms a picture",
        report.output,
        count(report.particles as usize),
        count(report.primitives),
        count(report.contacts as usize),
        count(report.frames),
        report.device,
        report.simulate_ms,
        report.draw_ms,
    ))?;
    console::json(&args.report, &report)
}

/// Whether this of `frames`, counted from 1, is one of so many moments, the last of which is the last.
fn is_moment(frame: usize, frames: usize, moments: usize) -> bool {
    frame * moments / frames > (frame - 1) * moments / frames
}

fn weather(args: &Args, diagonal: f64) -> Weather {
    let diagonal = diagonal as f32;
    Weather {
        count: args.particles as usize,
        radius: 0.01 * args.radius * diagonal,
        settings: Settings {
            gravity: Vec3::NEG_Y * args.gravity * diagonal,
            restitution: args.restitution,
            friction: args.friction,
            ..Settings::default()
        },
        seed: args.seed,
    }
}

/// Draws level and particles, always from the same place.
struct Painter {
    renderer: Renderer,
    camera: Camera,
}

impl Painter {
    /// With a camera that sees the level in all shapes, and some air.
    fn new(gpu: &Gpu, args: &Args, shapes: &[Shape], diagonal: f64) -> Result<Self> {
        let renderer = Renderer::new(gpu, args.size.0, args.size.1)?;
        let air = 0.06 * diagonal as f32;
        let balls = shapes.iter().flat_map(|s| &s.balls);
        let balls = balls.map(|b| (b.centre.as_vec3(), b.radius as f32 + air));
        let bounds = Bounds::of_balls(balls);
        let projection = Projection::default();
        Ok(Self {
            camera: Camera::framing(&bounds, args.view, projection, renderer.aspect()),
            renderer,
        })
    }

    fn draw(&mut self, shape: &Shape, particles: &[Particle]) -> Result<Picture> {
        let mut spheres = Spheres::default();
        spheres.surface(shape, &vec![BODY; shape.balls.len()])?;
        let ball = |p: &Particle| Ball {
            centre: p.position.as_dvec3(),
            radius: f64::from(p.radius),
        };
        let colour = |p: &Particle| match p.contacts {
            0 => FALLING,
            _ => BOUNCED,
        };
        let balls: Vec<Ball> = particles.iter().map(ball).collect();
        let colours: Vec<Vec3> = particles.iter().map(colour).collect();
        spheres.loose(&balls, &colours)?;
        let scene = Scene {
            positions: &[],
            normals: &[],
            colours: &[],
            triangles: &[],
            camera: self.camera,
            wireframe: false,
            background: Background::default(),
        };
        self.renderer.draw_with(&scene, &spheres)
    }
}
