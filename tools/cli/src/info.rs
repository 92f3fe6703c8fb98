//! `dermis info`: what a file holds and what dermis makes of it.

use std::path::PathBuf;

use dermis::{
    Result, asset,
    asset::Model,
    mesh,
    rig::{self, Rig, Skeleton},
};
use serde::Serialize;

use crate::{
    console::{self, Console},
    options::ReportOptions,
    progress::Progress,
    session::primitives,
    table::{Table, count},
};

/// Say what a character file holds: vertices, joints, clips, and what was mended.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  dermis info CesiumMan.glb
  dermis info CesiumMan.glb --fields       prepare it, too: fields, and vertices that follow geometric skinning
  dermis info arm.glb --primitives biceps.json
  dermis info CesiumMan.glb --json - | jq .joints")]
pub(crate) struct Args {
    /// glTF or GLB file.
    file: PathBuf,
    /// Prepare the character as bake would, and report its fields and what the preparation left out.
    #[arg(long)]
    fields: bool,
    /// List the extra primitives of a JSON file, such as muscles, and check them against the character.
    #[arg(long, value_name = "FILE")]
    primitives: Option<PathBuf>,
    #[command(flatten)]
    report: ReportOptions,
}

#[derive(Serialize)]
struct Info {
    file: String,
    vertices: usize,
    welded_vertices: usize,
    triangles: usize,
    components: usize,
    rigid_vertices: usize,
    joints: Vec<Joint>,
    clips: Vec<Clip>,
    extensions: Vec<String>,
    spines: Vec<Spine>,
    primitives: Vec<Primitive>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct Primitive {
    name: String,
    joint: String,
    driver: String,
}

#[derive(Serialize)]
struct Spine {
    root: String,
    tip: String,
    map: String,
}

#[derive(Serialize)]
struct Joint {
    name: String,
    parent: Option<String>,
    vertices: usize,
}

#[derive(Serialize)]
struct Clip {
    name: String,
    seconds: f32,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let console = Console::new(&args.report);
    let model = asset::load(&args.file)?;
    let list = match &args.primitives {
        Some(file) => primitives(Some(file), &Skeleton::from_model(&model)?)?,
        None => Vec::new(),
    };
    let mut info = describe(&model, &list);
    let rig = if args.fields {
        Some(prepare(&model, args, list, &console)?)
    } else {
        None
    };
    if let Some(rig) = &rig {
        let new = rig
            .warnings
            .iter()
            .filter(|w| !model.warnings.contains(w))
            .cloned();
        info.warnings.extend(new);
    }
    console.text(text(&info, rig.as_ref()).trim_end())?;
    console::json(&args.report, &info)
}

fn prepare(
    model: &Model,
    args: &Args,
    primitives: Vec<rig::Primitive>,
    console: &Console,
) -> Result<Rig> {
    let progress = Progress::new(console);
    let options = rig::Options {
        primitives,
        ..rig::Options::default()
    };
    let rig = Rig::prepare(model, &options, &|p| progress.show(p));
    progress.finish();
    rig.map_err(|e| match &args.primitives {
        Some(file) => e.in_file(file),
        None => e,
    })
}

fn describe(model: &Model, primitives: &[rig::Primitive]) -> Info {
    let welded = mesh::weld(&model.positions, &model.triangles).mesh;
    let mut owned = vec![0; model.joints.len()];
    for first in model.influences.iter().filter_map(|list| list.first()) {
        owned[usize::from(first.joint)] += 1;
    }
    let joint = |(joint, vertices): (&asset::Joint, usize)| Joint {
        name: joint.name.clone(),
        parent: joint.parent.map(|p| model.joints[p].name.clone()),
        vertices,
    };
    let components = welded.components.iter().max();
    Info {
        file: model.path.display().to_string(),
        vertices: model.positions.len(),
        welded_vertices: welded.positions.len(),
        triangles: model.triangles.len(),
        components: components.map_or(0, |&last| last as usize + 1),
        rigid_vertices: model.rigid.iter().filter(|&&rigid| rigid > 0.0).count(),
        joints: model.joints.iter().zip(owned).map(joint).collect(),
        clips: model.clips.iter().map(clip).collect(),
        extensions: model.extensions.clone(),
        spines: model.spines.iter().map(spine).collect(),
        primitives: primitives.iter().map(primitive).collect(),
        warnings: model.warnings.clone(),
    }
}

fn primitive(primitive: &rig::Primitive) -> Primitive {
    Primitive {
        name: primitive.name.clone(),
        joint: primitive.joint.clone(),
        driver: primitive.driver.clone(),
    }
}

fn spine(spine: &asset::Spine) -> Spine {
    Spine {
        root: spine.root.clone(),
        tip: spine.tip.clone(),
        map: spine.map.clone(),
    }
}

fn clip(clip: &asset::Clip) -> Clip {
    Clip {
        name: clip.name.clone(),
        seconds: clip.seconds,
    }
}

fn text(info: &Info, rig: Option<&Rig>) -> String {
    let mut lines = vec![
        info.file.clone(),
        format!(
            "{} vertices ({} welded), {} triangles, {} components",
            count(info.vertices),
            count(info.welded_vertices),
            count(info.triangles),
            count(info.components)
        ),
    ];
    if info.rigid_vertices > 0 {
        let rigid = count(info.rigid_vertices);
        lines.push(format!("{rigid} vertices are painted rigid (_RIGID)"));
    }
    if !info.extensions.is_empty() {
        lines.push(format!("extensions: {}", info.extensions.join(", ")));
    }
    for clip in &info.clips {
        lines.push(format!("clip {:?}: {:.3} s", clip.name, clip.seconds));
    }
    lines.extend(info.spines.iter().map(|s| {
        format!(
            "spine from {:?} to {:?}, {} map (dermis_spine)",
            s.root, s.tip, s.map
        )
    }));
    lines.extend(info.primitives.iter().map(|p| {
        format!(
            "primitive {:?}: on {:?}, swells with {:?}",
            p.name, p.joint, p.driver
        )
    }));
    if let Some(rig) = rig {
        lines.push(fields(rig));
    }
    lines.push(String::new());
    lines.push(joints(info, rig));
    lines.extend(info.warnings.iter().map(|w| format!("warning: {w}")));
    lines.join("\n")
}

fn fields(rig: &Rig) -> String {
    let geometric = rig.geometric.iter().filter(|&&g| g).count();
    let primitives = match rig.primitives.len() {
        0 => String::new(),
        1 => ", 1 of them a primitive's".into(),
        n => format!(", {n} of them primitives'"),
    };
    format!(
        "{} fields{primitives}; {} of {} welded vertices follow geometric skinning only",
        rig.fields.len(),
        count(geometric),
        count(rig.geometric.len())
    )
}

/// A row a joint, indented by its depth.
fn joints(info: &Info, rig: Option<&Rig>) -> String {
    let field = |row: usize| {
        rig.map_or(String::new(), |rig| {
            let field = rig.fields.iter().find(|f| usize::from(f.joint) == row);
            field.map_or("none".into(), |f| format!("{:.4}", f.radius))
        })
    };
    let title = if rig.is_some() { "field radius" } else { "" };
    let mut table = Table::new(
        1,
        [&format!("{} joints", info.joints.len()), "vertices", title],
    );
    let mut depths: Vec<usize> = Vec::new();
    for (row, joint) in info.joints.iter().enumerate() {
        let parent = joint.parent.as_ref();
        let parent =
            parent.and_then(|name| info.joints[..row].iter().position(|j| j.name == *name));
        let depth = parent.map_or(0, |p| depths[p] + 1);
        depths.push(depth);
        let name = format!("{}{}", "  ".repeat(depth), joint.name);
        table.row([name, count(joint.vertices), field(row)]);
    }
    table.to_string()
}
