//! `dermis sphere-mesh extract`: a level as files that other programs read.

use std::path::{Path, PathBuf};

use dermis::{
    Error, Result,
    asset::{self, SphereAnimation, SpherePath, SurfaceMesh},
    report,
    sphere_mesh::{self, Hierarchy, Level, Shape},
};
use serde::Serialize;

use super::{InputFile, LevelOptions, check_frame, check_places};
use crate::{
    console::{self, Console},
    options::ReportOptions,
    output::{Partial, frame_name},
    parse,
    progress::Progress,
    table::count,
};

/// Write a level: its outer surface as PLY, its spheres with their animation and that surface as GLB, or the sphere-mesh
/// itself as .ma.
#[derive(clap::Args)]
#[command(after_help = "\
A folder gets a PLY a frame. A GLB has a node a sphere with an animated translation and the surface of --frame. A .ma file
holds the counts of vertices, edges and faces, then lines v x y z r, e a b and f a b c.

The surface is one closed mesh on a grid; sheets thinner than 1.2 cells are thickened to that, and pockets that cannot
be reached from outside are filled.

Examples:
  dermis sphere-mesh extract horse.dsm --spheres 46 -o horse.ply --frame 12
  dermis sphere-mesh extract horse.dsm --spheres 46 -o horse.glb --fps 24
  dermis sphere-mesh extract horse.dsm --spheres 46 -o frames --cells 200
  dermis sphere-mesh extract horse.dsm --error 0.5 -o horse.ma")]
pub(crate) struct Args {
    #[command(flatten)]
    input: InputFile,
    #[command(flatten)]
    level: LevelOptions,
    /// A .ply, .glb or .ma file, or a folder for frame_0000.ply …
    #[arg(long, short, value_name = "OUT")]
    output: PathBuf,
    /// Frame, from 0: of a .ply or .ma, and of the surface in a .glb.
    #[arg(long, value_name = "K", default_value_t = 0)]
    frame: usize,
    /// Cells of the grid along the longest side.
    #[arg(long, value_name = "N", default_value_t = 128)]
    cells: usize,
    /// Frames a second of the animation in a .glb.
    #[arg(long, value_name = "N", default_value_t = 30.0, value_parser = parse::positive)]
    fps: f32,
    /// Write into a folder that is not empty, replacing the frames there; other files stay.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Ply,
    Glb,
    Ma,
    Folder,
}

#[derive(Serialize)]
struct Report {
    file: String,
    output: String,
    spheres: usize,
    edges: usize,
    triangles: usize,
    frames: usize,
    surface_vertices: usize,
    surface_triangles: usize,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let format = format(&args.output)?;
    check_places(&args.output, &[&args.input.file], &args.report)?;
    let hierarchy = args.input.load()?;
    check_frame(&hierarchy, args.frame)?;
    let level = args.level.open(&hierarchy)?;
    let mut report = Report {
        file: args.input.file.display().to_string(),
        output: args.output.display().to_string(),
        spheres: level.nodes.len(),
        edges: level.edges.len(),
        triangles: level.triangles.len(),
        frames: 1,
        surface_vertices: 0,
        surface_triangles: 0,
    };
    let shape = Shape::new(&hierarchy, &level, args.frame);
    match format {
        Format::Ma => sphere_mesh::write_ma(&args.output, &shape)?,
        Format::Folder => folder(args, &hierarchy, &level, &mut report, &console)?,
        Format::Ply | Format::Glb => {
            let skin = sphere_mesh::extract(&shape, args.cells)?;
            report.surface_vertices = skin.positions.len();
            report.surface_triangles = skin.triangles.len();
            if format == Format::Ply {
                skin.write_ply(&args.output, args.frame)?;
            } else {
                report.frames = hierarchy.frames;
                glb(args, &hierarchy, &level, &skin)?;
            }
        }
    }
    console.text(format_args!(
        "{}: {} spheres, {} edges, {} triangles, {} frames",
        report.output,
        count(report.spheres),
        count(report.edges),
        count(report.triangles),
        report.frames
    ))?;
    console::json(&args.report, &report)
}

fn format(output: &Path) -> Result<Format> {
    let extension = output.extension().and_then(|e| e.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("ply") => Ok(Format::Ply),
        Some("glb") => Ok(Format::Glb),
        Some("ma") => Ok(Format::Ma),
        None => Ok(Format::Folder),
        Some(_) if output.is_dir() => Ok(Format::Folder),
        Some(other) => {
            let reason = format!(".{other}; give a .ply, .glb or .ma file, or a folder");
            Err(Error::argument("--output", reason))
        }
    }
}

fn folder(
    args: &Args,
    hierarchy: &Hierarchy,
    level: &Level,
    report: &mut Report,
    console: &Console,
) -> Result<()> {
    let folder = Partial::folder(&args.output, args.force)?;
    let progress = Progress::new(console);
    for frame in 0..hierarchy.frames {
        progress.show(report::Progress {
            stage: "meshing frames",
            done: frame,
            total: hierarchy.frames,
        });
        let shape = Shape::new(hierarchy, level, frame);
        let skin = sphere_mesh::extract(&shape, args.cells)?;
        let path = folder.path().join(frame_name(frame, "ply"));
        skin.write_ply(&path, frame).map_err(|e| folder.blame(e))?;
        report.surface_vertices += skin.positions.len();
        report.surface_triangles += skin.triangles.len();
    }
    progress.finish();
    report.frames = hierarchy.frames;
    folder.keep()
}

fn glb(args: &Args, hierarchy: &Hierarchy, level: &Level, skin: &sphere_mesh::Skin) -> Result<()> {
    let frames = 0..hierarchy.frames;
    let times: Vec<f32> = frames.clone().map(|k| k as f32 / args.fps).collect();
    let path = |&node: &u32| SpherePath {
        radius: hierarchy.radius(node as usize),
        centres: frames
            .clone()
            .map(|k| hierarchy.centre(node as usize, k))
            .collect(),
    };
    let spheres: Vec<SpherePath> = level.nodes.iter().map(path).collect();
    let mesh = skin.mesh();
    let animation = SphereAnimation {
        times: &times,
        spheres: &spheres,
        surface: Some(SurfaceMesh {
            positions: &mesh.positions,
            normals: &mesh.normals,
            triangles: &mesh.triangles,
        }),
    };
    asset::write_glb_spheres(&args.output, &animation)
}
