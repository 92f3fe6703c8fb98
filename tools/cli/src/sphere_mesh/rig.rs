//! `dermis sphere-mesh rig`: sequences to a skinned, animated character whose bones are the spheres of a level.

use std::{
    path::{Path, PathBuf},
    time::Instant,
};

use dermis::{
    Error, Result,
    asset::{self, Model, Sequence},
    sphere_mesh::{self, Decomposing, Decomposition, Weighting},
};
use serde::Serialize;

use super::{
    Connectivity, InputFile, LevelOptions, check_places,
    source::{self, ClipOptions},
};
use crate::{
    console::{self, Console},
    options::ReportOptions,
    progress::Progress,
    table::count,
};

/// Make a character of captured sequences: a rest pose, rigid bones that are the spheres of a level, smooth weights, and an
/// animation a sequence (skinning decomposition).
#[derive(clap::Args)]
#[command(after_help = "\
All sequences are of the mesh that X.dsm was built from: the same vertices and faces. They share rest pose and weights.
The rest pose begins as the first frame of the first. Joints are named sphere_0 … as in `extract`, and turn where they meet
their parents. A clip's frames are --fps a second in its animation, those of meshes too.

Examples:
  dermis sphere-mesh rig horse.dsm captured/ --spheres 46 -o horse.glb
  dermis sphere-mesh rig horse.dsm gallop/ collapse/ --spheres 46 -o horse.glb      two animations
  dermis sphere-mesh rig horse.dsm captured/ --spheres 46 --weights animation -o horse.glb --json -
  dermis sphere-mesh rig horse.dsm captured/ --spheres 46 --joints 0.1 -o horse.glb     bones for implicit skinning
  dermis bake horse.glb --method tracking --pose leg.json -o posed.glb             then, as any character")]
pub(crate) struct Args {
    #[command(flatten)]
    input: InputFile,
    /// Sequences: folders of meshes, folders with rest.obj and frames.npy, skinned or morphed GLB or glTF, or meshes.
    #[arg(value_name = "SEQ", required = true)]
    sequences: Vec<PathBuf>,
    #[command(flatten)]
    clip: ClipOptions,
    #[command(flatten)]
    level: LevelOptions,
    /// Character.
    #[arg(long, short, value_name = "R.glb")]
    output: PathBuf,
    /// Most spheres that a vertex follows, 1 to 24.
    #[arg(long, value_name = "K", default_value_t = Decomposing::default().influences)]
    max_influences: usize,
    /// What weights are made from.
    #[arg(long, value_enum, default_value = "mixed")]
    weights: Weights,
    /// Most iterations.
    #[arg(long, value_name = "N", default_value_t = Decomposing::default().iterations)]
    iterations: usize,
    /// Stop where iterations lower the error by less than this share of it each; at 0 all are made that lower it.
    #[arg(long, value_name = "X", default_value_t = Decomposing::default().tolerance)]
    tolerance: f64,
    /// How strongly adjacent spheres hold together where they meet, against fitting the animation: at 0 they are free, which
    /// has the least error; 0.1 keeps bones that implicit skinning can join also while the clips play; from 1 on they turn about joints.
    #[arg(long, value_name = "X", default_value_t = Decomposing::default().joints)]
    joints: f64,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Weights {
    /// From geometry where it reproduces the animation, else from that: what moved as one can be posed apart
    Mixed,
    /// From the animation alone: the least error
    Animation,
}

impl From<Weights> for Weighting {
    fn from(weights: Weights) -> Self {
        match weights {
            Weights::Mixed => Self::Mixed,
            Weights::Animation => Self::Animation,
        }
    }
}

#[derive(Serialize)]
struct Report {
    file: String,
    output: String,
    spheres: usize,
    vertices: usize,
    frames: usize,
    e_rms: f64,
    mse: f64,
    iterations: usize,
    converged: bool,
    seconds: Seconds,
    clips: Vec<Clip>,
    joints: Vec<Joint>,
}

#[derive(Serialize)]
struct Seconds {
    read: f64,
    decompose: f64,
    write: f64,
}

#[derive(Serialize)]
struct Clip {
    name: String,
    mse: Vec<f64>,
}

#[derive(Serialize)]
struct Joint {
    name: String,
    parent: Option<String>,
    /// Where it turns, at rest.
    origin: [f32; 3],
    /// Rows of the file that follow it most.
    vertices: usize,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let sequences = args.sequences.iter().map(PathBuf::as_path);
    let inputs: Vec<&Path> = sequences.chain([args.input.file.as_path()]).collect();
    check_places(&args.output, &inputs, &args.report)?;
    check_output(&args.output)?;
    let begin = Instant::now();
    let hierarchy = args.input.load()?;
    let level = args.level.open_as(&hierarchy, Connectivity::Nearest)?;
    let load = |path: &PathBuf| source::load(path, &args.clip);
    let clips: Result<Vec<Sequence>> = args.sequences.iter().map(load).collect();
    let clips = clips?;
    let read = begin.elapsed().as_secs_f64();
    let options = Decomposing {
        influences: args.max_influences,
        iterations: args.iterations,
        tolerance: args.tolerance,
        weighting: args.weights.into(),
        joints: args.joints,
    };
    let begin = Instant::now();
    let progress = Progress::new(&console);
    let show = |p| progress.show(p);
    let result = sphere_mesh::decompose(&hierarchy, &level, &clips, &options, &show);
    progress.finish();
    let result = result?;
    let decompose = begin.elapsed().as_secs_f64();
    let begin = Instant::now();
    let model = result.model(&hierarchy, &level, &clips, args.clip.fps())?;
    asset::write_glb_skinned(&args.output, &model)?;
    let write = begin.elapsed().as_secs_f64();
    let seconds = Seconds {
        read,
        decompose,
        write,
    };
    let report = report(args, &result, &model, seconds);
    console.text(format_args!(
        "{}: {} spheres move {} vertices; E_RMS {:.3}, MSE {:.2e} over {} frames, after {} iterations{} in {:.2} s",
        report.output,
        count(report.spheres),
        count(report.vertices),
        report.e_rms,
        report.mse,
        count(report.frames),
        report.iterations,
        if report.converged { "" } else { " (the most that were allowed)" },
        report.seconds.decompose,
    ))?;
    console::json(&args.report, &report)
}

fn check_output(path: &Path) -> Result<()> {
    let extension = path.extension().and_then(|e| e.to_str());
    if extension.is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
        return Ok(());
    }
    let reason = format!("{} is no .glb file", path.display());
    Err(Error::argument("--output", reason))
}

fn report(args: &Args, result: &Decomposition, model: &Model, seconds: Seconds) -> Report {
    let all: Vec<f64> = result.mse.iter().flatten().copied().collect();
    let named = model.clips.iter().zip(&result.mse);
    let clips = named.map(|(clip, mse)| Clip {
        name: clip.name.clone(),
        mse: mse.clone(),
    });
    Report {
        file: args.input.file.display().to_string(),
        output: args.output.display().to_string(),
        spheres: model.joints.len(),
        vertices: result.rest.len(),
        frames: all.len(),
        e_rms: result.e_rms,
        mse: all.iter().sum::<f64>() / all.len() as f64,
        iterations: result.iterations,
        converged: result.converged,
        seconds,
        clips: clips.collect(),
        joints: joints(model),
    }
}

fn joints(model: &Model) -> Vec<Joint> {
    let mut vertices = vec![0; model.joints.len()];
    let most = model.influences.iter().filter_map(|list| list.first());
    most.for_each(|influence| vertices[usize::from(influence.joint)] += 1);
    let rows = model.joints.iter().zip(vertices);
    let joint = |(joint, vertices): (&asset::Joint, usize)| Joint {
        name: joint.name.clone(),
        parent: joint.parent.map(|p| model.joints[p].name.clone()),
        origin: (-joint.inverse_bind.w_axis.truncate()).to_array(),
        vertices,
    };
    rows.map(joint).collect()
}
