//! `dermis sphere-mesh info`: a level's counts and its distances to the mesh.

use std::{path::PathBuf, time::Instant};

use dermis::{
    Error, Result,
    asset::Sequence,
    report,
    sphere_mesh::{self, Distances, Hierarchy, Level, Options, Sheets},
};
use serde::Serialize;

use super::{
    InputFile, LevelOptions, peak_memory,
    source::{self, ClipOptions},
};
use crate::{
    console::{self, Console},
    options::ReportOptions,
    progress::Progress,
    table::{Table, count},
};

/// Count a level's spheres, edges and triangles, and measure how far it is from the mesh.
#[derive(clap::Args)]
#[command(after_help = "\
Distances are in % of the bounding box's diagonal, means over the frames: H is the greatest in either direction, M12 the
mean from the mesh to the level, M21 from the level to the mesh. They are measured between outer surfaces: what of either
cannot be seen from outside does not count. With --against, the sequence that the file was built of, the classic quadric error
metric (QEM) summed over the frames is built and measured at the same count, weighted by area alone and by curvature as well,
which is how the spheres are built by default.

Examples:
  dermis sphere-mesh info horse.dsm --spheres 46
  dermis sphere-mesh info horse.dsm --error 0.5 --frames 3
  dermis sphere-mesh info horse.dsm --spheres 46 --against captured/ --json -")]
pub(crate) struct Args {
    #[command(flatten)]
    input: InputFile,
    #[command(flatten)]
    level: LevelOptions,
    /// Sequence that the file was built of, for a comparison with QEM.
    #[arg(long, value_name = "SEQ")]
    against: Option<PathBuf>,
    #[command(flatten)]
    clip: ClipOptions,
    /// Frames to measure, evenly spread; 0 for none. All where not given.
    #[arg(long, value_name = "N")]
    frames: Option<usize>,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(Serialize)]
struct Info {
    file: String,
    rows: usize,
    vertices: usize,
    frames: usize,
    /// Spheres, wire edges and triangles of the level.
    #[serde(flatten)]
    counts: Counts,
    least_spheres: usize,
    /// Root mean square distance of the planes, % of the diagonal.
    error: f64,
    frames_measured: usize,
    #[serde(flatten)]
    distances: Option<Measured>,
    qem: Option<Compared>,
    qem_curvature: Option<Compared>,
    seconds: Seconds,
    peak_memory: Option<u64>,
}

#[derive(Serialize)]
struct Counts {
    spheres: usize,
    edges: usize,
    triangles: usize,
}

#[derive(Clone, Copy, Serialize)]
struct Measured {
    #[serde(rename = "H")]
    h: f64,
    #[serde(rename = "M12")]
    m12: f64,
    #[serde(rename = "M21")]
    m21: f64,
}

#[derive(Serialize)]
struct Compared {
    #[serde(flatten)]
    counts: Counts,
    #[serde(flatten)]
    distances: Option<Measured>,
}

#[derive(Serialize)]
struct Seconds {
    open: f64,
    measure: f64,
    compare: f64,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let begin = Instant::now();
    let hierarchy = args.input.load()?;
    let level = args.level.open(&hierarchy)?;
    let open = begin.elapsed().as_secs_f64();
    let against = args.against.as_deref().map(|path| {
        let sequence = source::load(path, &args.clip)?;
        check_same(&hierarchy, &sequence)?;
        Ok::<_, Error>(sequence)
    });
    let against = against.transpose()?;
    let progress = Progress::new(&console);
    let frames = chosen(hierarchy.frames, args.frames);
    let begin = Instant::now();
    let distances = measure(&hierarchy, &level, Sheets::Outer, &frames, &progress);
    let measured = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let (mut qem, mut qem_curvature) = (None, None);
    if let Some(sequence) = &against {
        let spheres = level.nodes.len();
        let compare = |curvature| {
            let options = Options {
                curvature,
                ..Options::classic()
            };
            compare(sequence, &options, spheres, &frames, &progress)
        };
        qem = Some(compare(0.0)?);
        qem_curvature = Some(compare(Options::default().curvature)?);
    }
    let compared = begin.elapsed().as_secs_f64();
    progress.finish();
    let info = Info {
        file: args.input.file.display().to_string(),
        rows: hierarchy.vertex.len(),
        vertices: hierarchy.vertices,
        frames: hierarchy.frames,
        counts: counts(&level),
        least_spheres: hierarchy.range().start,
        error: hierarchy.error(level.nodes.len()),
        frames_measured: frames.len(),
        distances,
        qem,
        qem_curvature,
        seconds: Seconds {
            open,
            measure: measured,
            compare: compared,
        },
        peak_memory: peak_memory(),
    };
    print(&console, &info)?;
    console::json(&args.report, &info)
}

/// Frames to measure, evenly spread from the first to the last.
fn chosen(frames: usize, wanted: Option<usize>) -> Vec<usize> {
    let count = wanted.unwrap_or(frames).min(frames);
    let last = frames - 1;
    let at = |k: usize| {
        if count > 1 {
            (k * last + (count - 1) / 2) / (count - 1)
        } else {
            0
        }
    };
    (0..count).map(at).collect()
}

fn check_same(hierarchy: &Hierarchy, sequence: &Sequence) -> Result<()> {
    let rows = sequence.frames.first().map_or(0, Vec::len);
    let (theirs, ours) = (
        (rows, sequence.frames.len()),
        (hierarchy.vertex.len(), hierarchy.frames),
    );
    if theirs == ours {
        return Ok(());
    }
    let reason = format!(
        "{} vertices in {} frames, but the file was built of {} in {}",
        theirs.0, theirs.1, ours.0, ours.1
    );
    Err(Error::argument("--against", reason))
}

fn counts(level: &Level) -> Counts {
    Counts {
        spheres: level.nodes.len(),
        edges: level.edges.len(),
        triangles: level.triangles.len(),
    }
}

fn measure(
    hierarchy: &Hierarchy,
    level: &Level,
    sheets: Sheets,
    frames: &[usize],
    progress: &Progress,
) -> Option<Measured> {
    let one = |(done, &frame): (usize, &usize)| {
        progress.show(report::Progress {
            stage: "measuring frames",
            done,
            total: frames.len(),
        });
        sphere_mesh::distances(hierarchy, level, sheets, frame)
    };
    let all: Vec<Distances> = frames.iter().enumerate().map(one).collect();
    let mean = Distances::mean(&all);
    (!all.is_empty()).then_some(Measured {
        h: mean.hausdorff,
        m12: mean.m12,
        m21: mean.m21,
    })
}

fn compare(
    sequence: &Sequence,
    options: &Options,
    spheres: usize,
    frames: &[usize],
    progress: &Progress,
) -> Result<Compared> {
    let hierarchy = sphere_mesh::build(sequence, options, &|p| progress.show(p))?;
    let level = hierarchy.level(spheres)?;
    Ok(Compared {
        counts: counts(&level),
        distances: measure(&hierarchy, &level, Sheets::Flat, frames, progress),
    })
}

fn print(console: &Console, info: &Info) -> Result<()> {
    console.text(format_args!(
        "{}: {} vertices, {} frames, {} to {} spheres; error {:.3} %",
        info.file,
        count(info.vertices),
        info.frames,
        info.least_spheres,
        count(info.vertices),
        info.error
    ))?;
    let mut table = Table::new(1, ["", "spheres", "edges", "triangles", "H", "M12", "M21"]);
    let mut row = |name: &str, counts: &Counts, distances: Option<Measured>| {
        let cell =
            |x: fn(Measured) -> f64| distances.map_or("-".into(), |d| format!("{:.2}", x(d)));
        table.row([
            name.into(),
            count(counts.spheres),
            count(counts.edges),
            count(counts.triangles),
            cell(|d| d.h),
            cell(|d| d.m12),
            cell(|d| d.m21),
        ]);
    };
    row("sphere-mesh", &info.counts, info.distances);
    for (name, other) in [
        ("QEM, area", &info.qem),
        ("QEM, curvature", &info.qem_curvature),
    ] {
        if let Some(other) = other {
            row(name, &other.counts, other.distances);
        }
    }
    console.text(table)
}
