//! `dermis sphere-mesh collide`: where moving spheres first touch a level.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use dermis::{
    Error, Result,
    asset::{load_rows, write_rows},
    sphere_mesh::{Collider, Shape, Sweep},
};
use serde::Serialize;

use super::{InputFile, LevelOptions, check_frame, check_places};
use crate::{
    console::{self, Console},
    options::ReportOptions,
    table::count,
};

/// Say where spheres that move along segments first touch a level: its spheres, the capsules along its edges and its thick
/// triangles.
#[derive(clap::Args)]
#[command(after_help = "\
S.npy is a NumPy array [n][7], <f4 or <f8: where a sphere begins (x, y, z), where it ends (x, y, z), its radius (0 for a
point), in the units of the sequence. hits.npy is [n][7], <f8, a row for each:
  0      time of the first touch, 0 at the beginning to 1 at the end; inf where there is none
  1 … 3  centre of the sphere then; where there is none, the end of its segment
  4 … 6  outward normal of the sphere-mesh, of length 1; where there is none, 0
What is touched is at centre - radius * normal. A sphere that begins inside has time 0 and is pushed out: its centre is
where it just touches from outside.

Examples:
  dermis sphere-mesh collide horse.dsm --spheres 46 --segments rain.npy -o hits.npy
  dermis sphere-mesh collide horse.dsm --spheres 46 --frame 12 --segments rain.npy -o hits.npy --json -")]
pub(crate) struct Args {
    #[command(flatten)]
    input: InputFile,
    #[command(flatten)]
    level: LevelOptions,
    /// Frame, from 0.
    #[arg(long, value_name = "K", default_value_t = 0)]
    frame: usize,
    /// Segments with radii.
    #[arg(long, value_name = "S.npy")]
    segments: PathBuf,
    /// Where they touch.
    #[arg(long, short, value_name = "hits.npy")]
    output: PathBuf,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(Serialize)]
struct Report {
    file: String,
    output: String,
    spheres: usize,
    primitives: usize,
    segments: usize,
    hits: usize,
    pushed_out: usize,
    seconds: f64,
    tests_per_second: f64,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let inputs = [args.input.file.as_path(), &args.segments];
    check_places(&args.output, &inputs, &args.report)?;
    let sweeps: Vec<Sweep> = load_rows(&args.segments)?
        .iter()
        .map(Sweep::of_row)
        .collect();
    let hierarchy = args.input.load()?;
    check_frame(&hierarchy, args.frame)?;
    let level = args.level.open(&hierarchy)?;
    let collider = Collider::new(&Shape::new(&hierarchy, &level, args.frame))?;
    let begin = Instant::now();
    let hits = collider
        .first_of_each(&sweeps)
        .map_err(|e| in_file(e, &args.segments))?;
    let seconds = begin.elapsed().as_secs_f64();
    let pairs = sweeps.iter().zip(&hits);
    let rows: Vec<[f64; 7]> = pairs
        .map(|(sweep, hit)| sweep.row_of(hit.as_ref()))
        .collect();
    write_rows(&args.output, &rows)?;
    let tests = sweeps.len() as f64 * collider.primitives() as f64;
    let report = Report {
        file: args.input.file.display().to_string(),
        output: args.output.display().to_string(),
        spheres: level.nodes.len(),
        primitives: collider.primitives(),
        segments: sweeps.len(),
        hits: hits.iter().flatten().count(),
        pushed_out: hits.iter().flatten().filter(|h| h.pushed).count(),
        seconds,
        tests_per_second: tests / seconds.max(f64::MIN_POSITIVE),
    };
    console.text(format_args!(
        "{}: {} segments against {} primitives: {} hits, {} of them pushed out, in {:.3} s",
        report.output,
        count(report.segments),
        count(report.primitives),
        count(report.hits),
        count(report.pushed_out),
        report.seconds,
    ))?;
    console::json(&args.report, &report)
}

/// An argument's error, which names a row, as one of the file that has it.
fn in_file(error: Error, path: &Path) -> Error {
    match error {
        Error::Argument { argument, reason } => Error::asset(path, argument, reason),
        other => other,
    }
}
