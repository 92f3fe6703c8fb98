//! `dermis sphere-mesh`: a captured or animated mesh as a few spheres.

mod build;
mod collide;
mod extract;
mod info;
mod rain;
mod render;
mod rig;
mod shower;
mod source;
mod tableau;

use std::path::{Path, PathBuf};

use clap::Subcommand;
use dermis::{
    Error, Result,
    sphere_mesh::{Hierarchy, Level},
};

use crate::options::ReportOptions;

/// Approximate an animated mesh by animated spheres, joined by edges and triangles along which they are interpolated.
#[derive(clap::Args)]
#[command(after_help = "\
SEQ is a folder of OBJ, PLY or OFF files, one a frame; a folder with rest.obj (faces) and frames.npy (NumPy, <f4,
[frame][vertex][3]); a GLB or glTF with a clip that moves a skin or morph targets; or a single mesh. All frames have the same faces, counter-clockwise
seen from outside.

Examples:
  dermis sphere-mesh build captured/ -o horse.dsm        all levels at once
  dermis sphere-mesh info horse.dsm --spheres 46 --json -
  dermis sphere-mesh extract horse.dsm --spheres 46 -o horse.glb
  dermis sphere-mesh extract horse.dsm --error 0.5 --frame 12 -o horse.ma
  dermis sphere-mesh collide horse.dsm --spheres 46 --segments rain.npy -o hits.npy
  dermis sphere-mesh render horse.dsm --spheres 46 -o horse.png
  dermis sphere-mesh rain horse.dsm --spheres 46 -o rain.png --moments 3
  dermis sphere-mesh rig horse.dsm captured/ --spheres 46 -o horse-rig.glb")]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Build(build::Args),
    Info(info::Args),
    Extract(extract::Args),
    Collide(collide::Args),
    Render(render::Args),
    Rain(rain::Args),
    Rig(rig::Args),
}

pub(crate) fn run(args: &Args) -> Result<()> {
    match &args.command {
        Command::Build(args) => build::run(args),
        Command::Info(args) => info::run(args),
        Command::Extract(args) => extract::run(args),
        Command::Collide(args) => collide::run(args),
        Command::Render(args) => render::run(args),
        Command::Rain(args) => rain::run(args),
        Command::Rig(args) => rig::run(args),
    }
}

/// Which level of a hierarchy.
#[derive(clap::Args, Clone, Debug)]
struct LevelOptions {
    /// Number of spheres.
    #[arg(long, value_name = "N", required_unless_present = "error")]
    spheres: Option<usize>,
    /// As few spheres as keep this error: root mean square distance of the mesh's planes to the spheres, weighted as in the
    /// build, in % of the bounding box's diagonal.
    #[arg(long, value_name = "E", conflicts_with = "spheres", value_parser = crate::parse::not_negative)]
    error: Option<f32>,
    /// How the level's spheres are joined; `collapsed` where not given, for `rig`, which joins bones, `nearest`.
    #[arg(long, value_enum)]
    connectivity: Option<Connectivity>,
}

#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
enum Connectivity {
    /// As the collapses left the regions, which is most often nearer to the mesh
    Collapsed,
    /// As regions touch once every vertex went to the nearest of its sphere and that one's neighbours
    Nearest,
}

impl LevelOptions {
    fn open(&self, hierarchy: &Hierarchy) -> Result<Level> {
        self.open_as(hierarchy, Connectivity::Collapsed)
    }

    /// Joined like this where nothing else is said.
    fn open_as(&self, hierarchy: &Hierarchy, connectivity: Connectivity) -> Result<Level> {
        let spheres = match (self.spheres, self.error) {
            (Some(spheres), _) => spheres,
            (None, Some(error)) => hierarchy.spheres_for(f64::from(error)),
            (None, None) => return Err(Error::argument("--spheres", "not given")),
        };
        let connectivity = self.connectivity.unwrap_or(connectivity);
        connectivity.open(hierarchy, spheres)
    }
}

impl Connectivity {
    /// The level with so many spheres, joined this way.
    fn open(self, hierarchy: &Hierarchy, spheres: usize) -> Result<Level> {
        let level = hierarchy.level(spheres)?;
        Ok(match self {
            Self::Collapsed => level,
            Self::Nearest => level.optimised(hierarchy),
        })
    }
}

/// Where the next file goes wrong is found before the work: the folder must exist.
fn check_folder(output: &Path) -> Result<()> {
    let folder = output.parent().filter(|f| !f.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.is_dir() => {
            let missing = std::io::ErrorKind::NotFound;
            Err(Error::file(folder, missing.into()))
        }
        _ => Ok(()),
    }
}

/// As [`check_folder`], for the output and the report; neither may replace the other, nor a file that is read.
fn check_places(output: &Path, inputs: &[&Path], report: &ReportOptions) -> Result<()> {
    check_folder(output)?;
    let json = report.json.as_deref().filter(|&f| f != Path::new("-"));
    if let Some(json) = json {
        check_folder(json)?;
        if place(json) == place(output) {
            let reason = format!("{} is the output too", json.display());
            return Err(Error::argument("--json", reason));
        }
    }
    let reads = |file: &Path| inputs.iter().any(|&input| place(input) == place(file));
    for (name, file) in [("--output", Some(output)), ("--json", json)] {
        if let Some(file) = file.filter(|&f| f.is_file() && reads(f)) {
            let reason = format!("{} is read: it would be replaced", file.display());
            return Err(Error::argument(name, reason));
        }
    }
    Ok(())
}

/// Where a file is or will be, whatever the way there.
fn place(file: &Path) -> PathBuf {
    let found = file.canonicalize().or_else(|e| match file.file_name() {
        Some(name) => {
            let folder = file.parent().filter(|f| !f.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new(".")).canonicalize()?;
            Ok(folder.join(name))
        }
        None => Err(e),
    });
    found.unwrap_or_else(|_| file.to_owned())
}

/// The frame must be one that the hierarchy has.
fn check_frame(hierarchy: &Hierarchy, frame: usize) -> Result<()> {
    if frame < hierarchy.frames {
        return Ok(());
    }
    let frames = hierarchy.frames;
    let reason = format!("{frame}, but there are {frames} frames from 0");
    Err(Error::argument("--frame", reason))
}

/// A hierarchy's file.
#[derive(clap::Args, Clone, Debug)]
struct InputFile {
    /// Sphere-mesh that `build` wrote.
    #[arg(value_name = "X.dsm")]
    file: PathBuf,
}

impl InputFile {
    fn load(&self) -> Result<Hierarchy> {
        Hierarchy::load(&self.file)
    }
}

/// Greatest memory that this process has held so far, in bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.split_ascii_whitespace().next()?.parse().ok()?;
    Some(kib * 1024)
}
