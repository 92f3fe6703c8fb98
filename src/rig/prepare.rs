//! Preparation of a character: everything that the deformers need, made once.

use std::path::Path;

use super::{
    FileRows, Fleshing, Options, Primitive, Rig, Skeleton, SpineChain,
    archive::Prepared,
    cache::{self, Entry, Key},
    program::compose,
    rigid::{stiffen, welded_rigid},
    sheets::{rigid_shells, thin_sheets, warning},
    subdivide::subdivide,
    swell,
    weights::{partition, welded_weights},
};
use crate::{
    Error, Result,
    asset::{self, Model},
    field,
    flesh::Map,
    mesh::{Mesh, Welded, mean_value, rings, weld},
    report::Progress,
};

/// Rings of the neighbourhood that contact flags spread over.
const RINGS: usize = 3;

type Report<'a> = &'a (dyn Fn(Progress) + Sync);

impl Rig {
    /// Prepares a character: subdivides, welds, completes weights, cuts the skin into parts, fits their fields and
    /// combines them. Runs on all cores; the result does not depend on their number.
    ///
    /// The rig's warnings begin with the model's.
    ///
    /// # Errors
    /// [`Error::Argument`], [`Error::Joint`] or [`Error::Primitive`] for a model that is inconsistent, or options that do not
    /// fit it.
    pub fn prepare(model: &Model, options: &Options, progress: Report) -> Result<Self> {
        let base = Base::new(model, options)?;
        let prepared = base.compute(options, progress)?;
        base.assemble(prepared, options, progress)
    }

    /// As [`Rig::prepare`], but keeps weights, parts and fields in a file of `dir`, keyed by the model's content, the
    /// options that they depend on and the version of this library.
    ///
    /// A file that is stale or damaged is made anew, one that cannot be written is left: a warning says so.
    ///
    /// # Errors
    /// As [`Rig::prepare`].
    pub fn prepare_cached(
        dir: &Path,
        model: &Model,
        options: &Options,
        progress: Report,
    ) -> Result<Self> {
        let base = Base::new(model, options)?;
        let key = base.key(options);
        let mut notes = Vec::new();
        let mut found = None;
        match cache::load(dir, &key) {
            Entry::Found(bytes) => {
                found = Prepared::from_bytes(&bytes).filter(|p| base.fits(p));
                if found.is_none() {
                    notes.push(format!("cache {}: an entry does not fit", dir.display()));
                }
            }
            Entry::Refused(reason) => notes.push(format!("{reason}; it was made anew")),
            Entry::Absent => {}
        }
        let prepared = match found {
            Some(prepared) => prepared,
            None => {
                let prepared = base.compute(options, progress)?;
                if let Err(e) = cache::store(dir, &key, &prepared.to_bytes()) {
                    notes.push(format!("the preparation is not cached: {e}"));
                }
                prepared
            }
        };
        let mut rig = base.assemble(prepared, options, progress)?;
        rig.cache = Some(dir.into());
        rig.warnings.extend(notes);
        Ok(rig)
    }
}

/// What is quick to prepare.
struct Base {
    model: Model,
    welded: Welded,
    skeleton: Skeleton,
}

impl Base {
    fn new(model: &Model, options: &Options) -> Result<Self> {
        validate(model)?;
        let skeleton = Skeleton::from_model(model)?;
        Primitive::check(&options.primitives, &skeleton)?;
        let model = subdivide(model, options.subdivide)?;
        let welded = weld(&model.positions, &model.triangles);
        Ok(Self {
            model,
            welded,
            skeleton,
        })
    }

    fn key(&self, options: &Options) -> Key {
        let model = &self.model;
        let mut key = Key::builder("rig")
            .pods(&model.positions)
            .pods(&model.triangles)
            .pods(&[
                u8::from(options.heat_weights),
                u8::from(options.part.is_some()),
            ])
            .pods(options.part.as_deref().unwrap_or_default());
        for list in &model.influences {
            let joints: Vec<u16> = list.iter().map(|i| i.joint).collect();
            let weights: Vec<f32> = list.iter().map(|i| i.weight).collect();
            key = key.pods(&joints).pods(&weights);
        }
        for joint in &self.skeleton.joints {
            let parent = joint.parent.map_or(u64::MAX, |p| p as u64);
            key = key
                .text(&joint.name)
                .pods(&[parent])
                .pods(&[joint.inverse_bind]);
        }
        key.finish()
    }

    /// Whether something read from a file has the shape of this character.
    fn fits(&self, p: &Prepared) -> bool {
        let vertices = self.welded.mesh.positions.len();
        let joints = self.skeleton.joints.len();
        p.part.len() == vertices
            && p.geometric.len() == vertices
            && p.radius.len() == joints
            && p.weights.width > 0
            && p.weights.joints.len() == vertices * p.weights.width
            && p.weights.weights.len() == p.weights.joints.len()
            && p.part
                .iter()
                .chain(&p.weights.joints)
                .all(|j| usize::from(*j) < joints)
            && p.fields.iter().all(|f| usize::from(f.joint) < joints)
    }

    fn compute(&self, options: &Options, progress: Report) -> Result<Prepared> {
        let mesh = &self.welded.mesh;
        let stages = ["weights", "fields", "thin sheets"];
        let stage = |done: usize| {
            progress(Progress {
                stage: stages[done],
                done,
                total: stages.len() + 1,
            });
        };
        stage(0);
        let (weights, mut warnings) = welded_weights(
            &self.model,
            &self.welded,
            &self.skeleton,
            options.heat_weights,
        )?;
        let part = partition(
            &self.welded,
            &weights,
            &self.skeleton,
            options.part.as_deref(),
        )?;
        stage(1);
        let shells = rigid_shells(mesh, &weights);
        let fitted = fit_body(mesh, &self.skeleton, part, &shells)?;
        stage(2);
        let mut sheets = thin_sheets(mesh, &fitted.part, &fitted.fields);
        for (sheet, shell) in sheets.iter_mut().zip(&shells) {
            *sheet &= !shell;
        }
        warnings.extend(fitted.warnings);
        warnings.extend(warning(
            "of rigid shells",
            &shells,
            &fitted.part,
            &self.skeleton,
        ));
        warnings.extend(warning(
            "of thin sheets",
            &sheets,
            &fitted.part,
            &self.skeleton,
        ));
        Ok(Prepared {
            weights,
            part: fitted.part,
            radius: fitted.radius,
            fields: fitted.fields,
            geometric: sheets.iter().zip(&shells).map(|(a, b)| *a || *b).collect(),
            warnings,
        })
    }

    fn assemble(self, p: Prepared, options: &Options, progress: Report) -> Result<Rig> {
        let mut composition = compose(&self.skeleton, &p.fields, options)?;
        let mut rigid = welded_rigid(&self.model.rigid, &self.welded);
        stiffen(&mut rigid, &p.part, &self.skeleton, &options.rigid)?;
        let mut fields = p.fields;
        let list = &options.primitives;
        let primitives = swell::add(list, &self.skeleton, &mut fields, &mut composition)?;
        let total = 4;
        progress(Progress {
            stage: "neighbourhoods",
            done: 3,
            total,
        });
        let file = self.model.path.file_name().unwrap_or_default();
        let mut warnings = self.model.warnings;
        warnings.extend(p.warnings);
        let fleshing = Fleshing::new(
            &chains(&self.model.spines, &options.spines),
            &self.skeleton,
            &self.welded.mesh,
            &p.weights,
            &p.part,
        )?;
        if fleshing.past_limit > 0 {
            let (count, reason) = (fleshing.past_limit, "past the limit of their spine at rest");
            warnings.push(format!("{count} vertices {reason} do not bend by fleshing"));
        }
        let mut geometric = p.geometric;
        for place in fleshing.places.iter().filter(|place| place.weight == 1.0) {
            geometric[place.vertex as usize] = true;
        }
        let rig = Rig {
            name: file.to_string_lossy().into_owned(),
            mean_value: mean_value(&self.welded.mesh),
            neighbourhood: rings(&self.welded.mesh, RINGS),
            mesh: self.welded.mesh,
            rows: FileRows {
                vertex: self.welded.vertex,
                normals: self.model.normals,
                triangles: self.model.triangles,
            },
            skeleton: self.skeleton,
            weights: p.weights,
            part: p.part,
            radius: p.radius,
            fields,
            primitives,
            composition,
            geometric,
            rigid,
            fleshing,
            cache: None,
            warnings,
        };
        progress(Progress {
            stage: "prepared",
            done: total,
            total,
        });
        Ok(rig)
    }
}

/// The user's spines, then the file's that begin elsewhere.
fn chains(file: &[asset::Spine], user: &[SpineChain]) -> Vec<SpineChain> {
    let own = file
        .iter()
        .filter(|s| user.iter().all(|u| u.root != s.root));
    let named = |name: &str| match name {
        "normal" => Map::Normal,
        "binormal" => Map::Binormal,
        _ => Map::Radial,
    };
    let own = own.map(|spine| SpineChain {
        root: spine.root.clone(),
        tip: spine.tip.clone(),
        map: named(&spine.map),
    });
    user.iter().cloned().chain(own).collect()
}

/// Fits the fields to the mesh without its shells: an eye's back would dent the head's field.
fn fit_body(
    mesh: &Mesh,
    skeleton: &Skeleton,
    part: Vec<u16>,
    shells: &[bool],
) -> Result<field::Fitted> {
    if !shells.contains(&true) {
        return field::fit(mesh, skeleton, part);
    }
    let body: Vec<usize> = (0..shells.len()).filter(|v| !shells[*v]).collect();
    let mut row = vec![u32::MAX; shells.len()];
    for (k, v) in body.iter().enumerate() {
        row[*v] = k as u32;
    }
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| row[v as usize]));
    let rest = Mesh::new(
        body.iter().map(|v| mesh.positions[*v]).collect(),
        triangles.filter(|t| t[0] != u32::MAX).collect(),
    );
    let own = body.iter().map(|v| part[*v]).collect();
    let mut fitted = field::fit(&rest, skeleton, own)?;
    // A shell goes with the part that its joint's other vertices went to.
    let mut carrier: Vec<u16> = (0..skeleton.joints.len() as u16).collect();
    for (v, to) in body.iter().zip(&fitted.part) {
        carrier[usize::from(part[*v])] = *to;
    }
    let mut whole: Vec<u16> = part.iter().map(|j| carrier[usize::from(*j)]).collect();
    for (v, to) in body.iter().zip(&fitted.part) {
        whole[*v] = *to;
    }
    fitted.part = whole;
    Ok(fitted)
}

/// What every later step relies on.
fn validate(model: &Model) -> Result<()> {
    let refuse = |reason: String| Err(Error::argument("character", reason));
    let rows = model.positions.len();
    if rows == 0 || model.triangles.is_empty() {
        return refuse("it has no triangles".into());
    }
    if let Some(bad) = model.positions.iter().position(|p| !p.is_finite()) {
        return refuse(format!("the position of vertex {bad} is not finite"));
    }
    if model.normals.len() != rows || !matches!(model.influences.len(), n if n == rows || n == 0) {
        return refuse("positions, normals and influences differ in number".into());
    }
    if !matches!(model.rigid.len(), n if n == rows || n == 0) {
        return refuse("positions and rigid differ in number".into());
    }
    if let Some(bad) = model.rigid.iter().position(|x| !(0.0..=1.0).contains(x)) {
        return refuse(format!("rigid of vertex {bad} is not in 0 to 1"));
    }
    if let Some(bad) = model
        .triangles
        .iter()
        .position(|t| t.iter().any(|v| *v as usize >= rows))
    {
        return refuse(format!("triangle {bad} is out of range"));
    }
    let mut next = (0, 0);
    for primitive in &model.primitives {
        if (primitive.vertices.start, primitive.triangles.start) != next {
            return refuse(format!("primitive {:?} leaves a gap", primitive.name));
        }
        next = (primitive.vertices.end, primitive.triangles.end);
    }
    if next != (rows, model.triangles.len()) {
        return refuse("primitives do not cover all vertices and triangles".into());
    }
    Ok(())
}

#[cfg(test)]
#[path = "prepare_tests.rs"]
mod tests;
