//! `dermis sphere-mesh build`: a sequence to a hierarchy of spheres.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use dermis::{
    Error, Result,
    sphere_mesh::{self, Options},
};
use serde::Serialize;

use super::{check_places, peak_memory, source::Source};
use crate::{
    console::{self, Console},
    options::ReportOptions,
    parse,
    progress::Progress,
    table::{bytes, count},
};

/// Collapse an animated mesh to spheres, step by step, and keep every step: any number of spheres opens from the file.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dermis sphere-mesh build captured/ -o horse.dsm
  dermis sphere-mesh build walk.glb --clip walk --fps 24 -o walk.dsm
  dermis sphere-mesh build captured/ -o horse.dsm --temporal 1     spheres that do not slide along the mesh
  dermis sphere-mesh build captured/ -o horse.dsm --curvature 0 --json -")]
pub(crate) struct Args {
    #[command(flatten)]
    source: Source,
    /// File of the hierarchy.
    #[arg(long, short, value_name = "X.dsm")]
    output: PathBuf,
    /// How much curved places count: the power of the paper's importance 1 + BBD² (κ₁² + κ₂²), which 1 stands for. At 0
    /// area alone counts, which loses small features sooner; towards 1 they win over all else.
    #[arg(long, value_name = "0..1", default_value_t = Options::default().curvature, value_parser = power)]
    curvature: f64,
    /// Weight of temporal coherence against the planes': at 0 spheres are where they fit best, from about 1 on they stay
    /// near the middle of their region.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = parse::not_negative)]
    temporal: f32,
    /// Let collapses turn triangles over, instead of putting them off.
    #[arg(long)]
    allow_inversion: bool,
    #[command(flatten)]
    report: ReportOptions,
}

fn power(text: &str) -> Result<f64, String> {
    let power = text.parse().ok();
    power
        .filter(|power| (0.0..=1.0).contains(power))
        .ok_or_else(|| "a number from 0 to 1".into())
}

#[derive(Serialize)]
struct Report {
    sequence: String,
    output: String,
    rows: usize,
    vertices: usize,
    triangles: usize,
    frames: usize,
    diagonal: f64,
    least_spheres: usize,
    seconds: Seconds,
    us_a_vertex_and_frame: f64,
    peak_memory: Option<u64>,
    bytes: u64,
}

#[derive(Serialize)]
struct Seconds {
    read: f64,
    build: f64,
    write: f64,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let inputs = args.source.files();
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    check_places(&args.output, &inputs, &args.report)?;
    let begin = Instant::now();
    let sequence = args.source.load()?;
    let read = begin.elapsed().as_secs_f64();
    let options = Options {
        curvature: args.curvature,
        temporal: f64::from(args.temporal),
        inversion: !args.allow_inversion,
        spheres: true,
    };
    let begin = Instant::now();
    let progress = Progress::new(&console);
    let hierarchy = sphere_mesh::build(&sequence, &options, &|p| progress.show(p));
    progress.finish();
    let hierarchy = hierarchy?;
    let build = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    hierarchy.save(&args.output)?;
    let write = begin.elapsed().as_secs_f64();
    let size = std::fs::metadata(&args.output).map_err(|e| Error::file(&args.output, e))?;
    let report = Report {
        sequence: args.source.sequence.display().to_string(),
        output: args.output.display().to_string(),
        rows: hierarchy.vertex.len(),
        vertices: hierarchy.vertices,
        triangles: hierarchy.triangles.len(),
        frames: hierarchy.frames,
        diagonal: hierarchy.diagonal,
        least_spheres: hierarchy.range().start,
        seconds: Seconds { read, build, write },
        us_a_vertex_and_frame: 1e6 * build / (hierarchy.vertices * hierarchy.frames) as f64,
        peak_memory: peak_memory(),
        bytes: size.len(),
    };
    console.text(format_args!(
        "{}: {} vertices, {} frames, {} to {} spheres; built in {build:.2} s ({:.2} us a vertex and frame), {} written",
        report.output,
        count(report.vertices),
        report.frames,
        count(report.least_spheres),
        count(report.vertices),
        report.us_a_vertex_and_frame,
        bytes(report.bytes),
    ))?;
    console::json(&args.report, &report)
}
