//! `dermis flesh`: a mesh bent along a spine, every piece of it keeping its volume.

mod bender;
mod measures;
mod output;
mod picture;
mod shape;
mod summary;

use std::{ops::RangeInclusive, path::PathBuf};

use clap::ValueEnum;
use dermis::{Error, Result, flesh::Map, render::View};

use crate::{
    console::{self, Console},
    flesh::{
        bender::{Bender, Way},
        output::Output,
        picture::Pictures,
        shape::Shape,
        summary::Report,
    },
    options::ReportOptions,
    output::Partial,
    parse,
};

/// Bend a mesh with a spine, without skeleton or weights; every piece of it keeps its volume.
#[derive(clap::Args)]
#[command(after_help = "\
A spine is a JSON object: {\"kind\": \"polynomial\"|\"bspline\"|\"polyline\", \"points\": [[x,y,z], …]} through its points, or
{\"kind\": \"arc\"|\"helix\", \"start\", \"tangent\", \"normal\", \"radius\", \"length\"(, \"pitch\")}, in units of the mesh; all may have
\"up\": [x,y,z], where the frame points at the start, and \"twist_degrees\": W, its turn about the spine, or [[share, W], …]
along it. Without \"up\" the bent spine's frame starts as the rest spine's does, turned the shortest way. A last point that
repeats the first closes a bspline or polyline.

Arc length is kept: what sticks out of a shorter spine goes on past its end, where the curvature eases to zero within an
eighth of the length and the rest is moved rigidly. --stretch fits the length instead, and keeps volume as well.

Past its limit (at the centre of curvature; half way for the flat normal map) a map goes on without keeping volume. A PLY tells
for each vertex limit, the distance to it in units of the mesh, negative past it, and flags: 1 past it at the rest spine, 2 at
the bent one, 4 another part of the rest spine is as near, 8 beyond its ends (which is fine).

Several pairs of --rest and --bent are applied one after the other, or, with a --mask each, at once.

Examples:
  dermis flesh bunny.off --rest line.json --bent arc.json --map normal -o bent.ply --report
  dermis flesh dolphin.obj --rest line.json --bent path.json --slide 0..1 --frames 60 -o swim.glb
  dermis flesh man.glb --rest a.json --bent b.json --mask neck,head -o out.obj --picture out.png")]
pub(crate) struct Args {
    /// OBJ, PLY or OFF mesh, or a rigged GLB or glTF in its rest pose.
    mesh: PathBuf,
    /// Spine within the mesh as it is (repeatable, one a --bent).
    #[arg(long, value_name = "SPINE.json", required = true)]
    rest: Vec<PathBuf>,
    /// The same spine bent.
    #[arg(long, value_name = "SPINE.json", required = true)]
    bent: Vec<PathBuf>,
    /// Where flesh gives way: away from the spine, in the plane of the bend, or across it.
    #[arg(long, value_enum, default_value = "radial")]
    map: MapName,
    /// An .obj, .ply, .off or .glb file; for several frames a .glb or a folder for frame_0000.ply ….
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// How far along a longer bent spine, from 0, starts aligned, to 1, ends aligned; A..B with --frames is a movement.
    #[arg(long, default_value = "0", value_name = "X|A..B", value_parser = slide)]
    slide: RangeInclusive<f64>,
    /// Frames of a movement, 30 a second.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=3600))]
    frames: Option<u32>,
    /// From 0, plain skinning along the spine, to 1.
    #[arg(long, default_value_t = 1.0, value_name = "X", value_parser = parse::share)]
    strength: f64,
    /// Fit the rest spine's length to the bent one's.
    #[arg(long)]
    stretch: bool,
    /// Move only what these joints of a rigged file carry, by their weights (repeatable: one a pair of spines).
    #[arg(long, value_name = "JOINT,…")]
    mask: Vec<String>,
    /// Measure volumes: of the mesh, of tetrahedra along its surface, and of clouds of cubes, against plain skinning.
    #[arg(long)]
    report: bool,
    /// Draw the mesh before, bent by plain skinning, and bent by each map, side by side.
    #[arg(long, value_name = "PNG")]
    picture: Option<PathBuf>,
    /// Where --picture sees it from: front, side, top or three-quarter.
    #[arg(
        long,
        default_value = "three-quarter",
        value_name = "VIEW",
        requires = "picture"
    )]
    view: View,
    /// Size of each part of --picture in pixels.
    #[arg(long, default_value = "400x400", value_name = "WxH", value_parser = parse::size, requires = "picture")]
    size: (u32, u32),
    /// Write into a folder that is not empty, replacing the frames of an earlier run; other files stay.
    #[arg(long)]
    force: bool,
    /// Draw under Vulkan's validation layer; any message makes the command fail.
    #[arg(long, requires = "picture")]
    validation: bool,
    #[command(flatten)]
    reports: ReportOptions,
}

#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum MapName {
    /// From and to the spine
    Radial,
    /// In the plane of the bend
    Normal,
    /// Across the plane of the bend
    Binormal,
}

impl MapName {
    fn map(self) -> Map {
        match self {
            Self::Radial => Map::Radial,
            Self::Normal => Map::Normal,
            Self::Binormal => Map::Binormal,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Radial => "radial",
            Self::Normal => "normal",
            Self::Binormal => "binormal",
        }
    }
}

/// `X` or `A..B`, each from 0 to 1.
fn slide(text: &str) -> std::result::Result<RangeInclusive<f64>, String> {
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    Ok(parse::share(from)?..=parse::share(to)?)
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.reports);
    let slides = slides(args)?;
    // Made before the work, so that an unwritable place is found at once.
    let output = Output::create(&args.output, slides.len(), args.force)?;
    let drawing = args.picture.as_deref().map(Partial::file).transpose()?;
    let shape = Shape::load(&args.mesh)?;
    let bender = Bender::load(args, &shape)?;
    let way = Way {
        map: args.map.map(),
        slide: *args.slide.start(),
        strength: args.strength,
    };
    let mut report = Report::new(args, &shape, &bender);
    let mut frames = Vec::with_capacity(slides.len());
    for (row, &slide) in slides.iter().enumerate() {
        let bent = bender.bend(&shape, &Way { slide, ..way })?;
        report.add(&shape, slide, &bent);
        frames.push((row as f32 / 30.0, bent));
    }
    if args.report {
        report.measure(&shape, &bender, &way)?;
    }
    if let (Some(path), Some(partial)) = (&args.picture, drawing) {
        let ways = [(0.0, MapName::Radial)].into_iter();
        let maps = MapName::value_variants()
            .iter()
            .map(|map| (args.strength, *map));
        let bent = ways.chain(maps).map(|(strength, name)| {
            let label = if strength == 0.0 {
                "plain"
            } else {
                name.name()
            };
            let map = name.map();
            let way = Way {
                map,
                strength,
                ..way
            };
            Ok((label, bender.bend(&shape, &way)?))
        });
        let bent = bent.collect::<Result<Vec<_>>>()?;
        Pictures::open(args)?.draw(path, &partial, &shape, &bent)?;
        partial.keep()?;
    }
    output.write(
        &shape,
        &frames,
        &format!("dermis flesh map={}", args.map.name()),
    )?;
    report.warn(&console)?;
    console.text(report.text(args.report).trim_end())?;
    console::json(&args.reports, &report)
}

/// Where along the bent spine each frame is.
fn slides(args: &Args) -> Result<Vec<f64>> {
    let (from, to) = (*args.slide.start(), *args.slide.end());
    match args.frames {
        None if from == to => Ok(vec![from]),
        None => Err(Error::argument("--slide", "a movement needs --frames")),
        Some(_) if from == to => Err(Error::argument("--frames", "they need --slide A..B")),
        Some(count) => {
            let share = |row: u32| f64::from(row) / f64::from(count - 1);
            Ok((0..count)
                .map(|row| from + share(row) * (to - from))
                .collect())
        }
    }
}
