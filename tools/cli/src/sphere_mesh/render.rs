//! `dermis sphere-mesh render`: pictures of a level, and of the mesh that it stands for.

use std::{ops::Range, path::PathBuf, time::Instant};

use dermis::{
    Error, Result, deformer::Device, gpu::Profile, render::View, report::Progress as Step,
    sphere_mesh::Hierarchy,
};
use glam::{Quat, Vec3};
use serde::Serialize;

use super::{Connectivity, InputFile, check_frame, check_places, tableau::Tableau};
use crate::{
    console::{self, Console},
    options::{DeviceOptions, ReportOptions},
    parse,
    progress::Progress,
    render::Gallery,
    session::{check_validation, device_report, drawing_device, open_device},
};

/// Draw a level offscreen: its interpolated surface, exactly, or its skeleton, beside the mesh that it stands for.
#[derive(clap::Args)]
#[command(after_help = "\
Spheres, the cones along edges and the slabs of triangles are met by rays on the device, without any mesh of the surface.
Each sphere has a colour of its own, and so has its region of the mesh. Wires and spheres of radius 0 cannot be seen on
the surface; sheets can.

One picture goes to a PNG as it is; several go to a PNG as one labelled sheet, or to a folder as frame_0000.png …

Examples:
  dermis sphere-mesh render horse.dsm --spheres 46 -o horse.png --view side
  dermis sphere-mesh render horse.dsm --spheres 46 -o all.png --style mesh,regions,skeleton,surface
  dermis sphere-mesh render horse.dsm --compare 20,46,200 -o levels.png --style mesh,surface
  dermis sphere-mesh render horse.dsm --error 0.5 -o gallop --frames 0..48 --style mesh,surface
  dermis sphere-mesh render horse.dsm --spheres 46 -o table --turntable 36 --frame 12 --up z")]
pub(crate) struct Args {
    #[command(flatten)]
    input: InputFile,
    /// A .png file, or a folder for frame_0000.png ….
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Write into a folder that is not empty, replacing the frames of an earlier run; other files stay.
    #[arg(long)]
    force: bool,
    /// Number of spheres.
    #[arg(long, value_name = "N", required_unless_present_any = ["error", "compare"])]
    spheres: Option<usize>,
    /// As few spheres as keep this error, as `info` shows it, in % of the bounding box's diagonal.
    #[arg(long, value_name = "E", conflicts_with = "spheres", value_parser = parse::not_negative)]
    error: Option<f32>,
    /// Several numbers of spheres, a labelled picture each.
    #[arg(long, value_delimiter = ',', value_name = "N,…", conflicts_with_all = ["spheres", "error"])]
    compare: Vec<usize>,
    /// How a level's spheres are joined.
    #[arg(long, value_enum, default_value = "collapsed")]
    connectivity: Connectivity,
    /// What to draw, side by side where there are several.
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "STYLE,…",
        default_value = "surface"
    )]
    style: Vec<Style>,
    /// Frame, from 0.
    #[arg(long, value_name = "K", default_value_t = 0, conflicts_with = "frames")]
    frame: usize,
    /// Several frames: A..B without B, A..=B with it.
    #[arg(long, value_name = "A..B", value_parser = parse::frames)]
    frames: Option<Range<usize>>,
    /// This many pictures all around.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=3600))]
    turntable: Option<u32>,
    /// Where from: front, side, top or three-quarter.
    #[arg(long, default_value = "three-quarter", value_name = "VIEW")]
    view: View,
    /// Axis of the sequence that is up in the pictures.
    #[arg(long, default_value = "y", value_name = "x|y|z|-x|-y|-z", value_parser = up, allow_hyphen_values = true)]
    up: Vec3,
    /// Parallel rays instead of a lens.
    #[arg(long)]
    orthographic: bool,
    /// Size of each picture in pixels.
    #[arg(long, default_value = "720x720", value_name = "WxH", value_parser = parse::size)]
    size: (u32, u32),
    /// Cells of the grid along the longest side, for the extracted surface.
    #[arg(long, value_name = "N", default_value_t = 128)]
    cells: usize,
    #[command(flatten)]
    device: DeviceOptions,
    #[command(flatten)]
    report: ReportOptions,
}

/// What is drawn of a level.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// The mesh of the sequence
    Mesh,
    /// That mesh in the colours of its regions
    Regions,
    /// Small spheres, wires and faint triangles
    Skeleton,
    /// The surface of the spheres, interpolated
    Surface,
    /// The closed mesh that `extract` writes
    Extracted,
}

impl Style {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::Regions => "regions",
            Self::Skeleton => "skeleton",
            Self::Surface => "surface",
            Self::Extracted => "extracted",
        }
    }
}

pub(super) fn up(text: &str) -> Result<Vec3, String> {
    let (axis, sign) = match text.strip_prefix('-') {
        Some(axis) => (axis, -1.0),
        None => (text, 1.0),
    };
    match axis {
        "x" => Ok(Vec3::X * sign),
        "y" => Ok(Vec3::Y * sign),
        "z" => Ok(Vec3::Z * sign),
        _ => Err("expected x, y, z, -x, -y or -z".into()),
    }
}

#[derive(Serialize)]
struct Report {
    file: String,
    output: String,
    device: String,
    size: (u32, u32),
    styles: Vec<&'static str>,
    levels: Vec<LevelReport>,
    pictures: Vec<PictureReport>,
}

#[derive(Serialize)]
struct LevelReport {
    spheres: usize,
    edges: usize,
    triangles: usize,
}

#[derive(Serialize)]
struct PictureReport {
    frame: usize,
    orbit_degrees: f32,
    /// All styles and levels of the picture: from the shapes to pixels, without the surface's extraction.
    draw_ms: f64,
}

/// One frame seen from one side.
#[derive(Clone, Copy)]
pub(super) struct Shot {
    pub(super) frame: usize,
    pub(super) orbit: f32,
}

/// What a tableau needs to know of the options.
pub(super) struct Look {
    pub(super) styles: Vec<Style>,
    pub(super) view: View,
    pub(super) orthographic: bool,
    pub(super) turntable: bool,
    pub(super) size: (u32, u32),
    pub(super) cells: usize,
    /// Stands the sequence up.
    pub(super) upright: Quat,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    // Made before the work, so that an unwritable place is found at once.
    let gallery = Gallery::open(&args.output, args.force)?;
    check_places(&args.output, &[&args.input.file], &args.report)?;
    let hierarchy = args.input.load()?;
    let shots = shots(args, &hierarchy)?;
    let levels = counts(args, &hierarchy).into_iter();
    let levels = levels
        .map(|n| args.connectivity.open(&hierarchy, n))
        .collect::<Result<Vec<_>>>()?;
    let device = open_device(&args.device, Profile::Off, &console)?;
    let gpu = drawing_device(&device, args.device.validation)?;
    let mut tableau = Tableau::open(&gpu, &hierarchy, levels, look(args), &shots)?;
    let mut gallery = gallery.with_rows(tableau.rows());
    let progress = Progress::new(&console);
    let mut pictures = Vec::with_capacity(shots.len());
    for (done, &shot) in shots.iter().enumerate() {
        let total = shots.len();
        progress.show(Step {
            stage: "draw",
            done,
            total,
        });
        let extracted = tableau.prepare(shot.frame)?;
        let begin = Instant::now();
        let tiles = tableau.draw(shot, &extracted, total > 1)?;
        pictures.push(PictureReport {
            frame: shot.frame,
            orbit_degrees: shot.orbit,
            draw_ms: 1e3 * begin.elapsed().as_secs_f64(),
        });
        gallery.add(tiles)?;
    }
    progress.finish();
    // Nothing else works here, whatever the user has asked for.
    let device = Device::Gpu(gpu);
    check_validation(&device)?;
    gallery.close()?;
    let level = |l: &dermis::sphere_mesh::Level| LevelReport {
        spheres: l.nodes.len(),
        edges: l.edges.len(),
        triangles: l.triangles.len(),
    };
    let report = Report {
        file: args.input.file.display().to_string(),
        output: args.output.display().to_string(),
        device: device_report(&device).name,
        size: args.size,
        styles: args.style.iter().map(|s| s.name()).collect(),
        levels: tableau.levels().iter().map(level).collect(),
        pictures,
    };
    console.text(summary(&report))?;
    console::json(&args.report, &report)
}

fn look(args: &Args) -> Look {
    Look {
        styles: args.style.clone(),
        view: args.view,
        orthographic: args.orthographic,
        turntable: args.turntable.is_some(),
        size: args.size,
        cells: args.cells,
        upright: Quat::from_rotation_arc(args.up, Vec3::Y),
    }
}

/// Numbers of spheres of the levels to draw.
fn counts(args: &Args, hierarchy: &Hierarchy) -> Vec<usize> {
    match (args.spheres, args.error) {
        (Some(spheres), _) => vec![spheres],
        (None, Some(error)) => vec![hierarchy.spheres_for(f64::from(error))],
        (None, None) => args.compare.clone(),
    }
}

/// The pictures to take: of every frame that the user asked for, or of one from every side.
fn shots(args: &Args, hierarchy: &Hierarchy) -> Result<Vec<Shot>> {
    check_frame(hierarchy, args.frame)?;
    let frames = args.frames.clone();
    let frames = frames.unwrap_or(args.frame..args.frame + 1);
    if frames.end > hierarchy.frames {
        let reason = format!(
            "{}..{}, but there are {} from 0",
            frames.start, frames.end, hierarchy.frames
        );
        return Err(Error::argument("--frames", reason));
    }
    let count = args.turntable.map_or(frames.len(), |n| n as usize);
    let step = args.turntable.map_or(0.0, |n| 360.0 / n as f32);
    let shot = |i: usize| Shot {
        frame: frames.start + i % frames.len(),
        orbit: i as f32 * step,
    };
    Ok((0..count).map(shot).collect())
}

fn summary(report: &Report) -> String {
    let spheres: Vec<String> = report
        .levels
        .iter()
        .map(|l| l.spheres.to_string())
        .collect();
    let all: f64 = report.pictures.iter().map(|p| p.draw_ms).sum();
    let count = report.pictures.len();
    format!(
        "{}: {count} × {} of {} with {} spheres on {}, {:.1} ms each",
        report.output,
        report.styles.join(", "),
        report.file,
        spheres.join(", "),
        report.device,
        all / count.max(1) as f64,
    )
}
