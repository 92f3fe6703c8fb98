//! A frame of each method as data: the steps that both the GPU and the CPU device walk.

use bytemuck::{Pod, bytes_of};

use super::{Method, Resource, Settings};
use crate::{gpu::Declaration, layout::SET_SEEDS, pass, twin};

/// A pass: its declaration for the GPU and its twin for the CPU.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// For the GPU.
    pub declaration: &'static Declaration,
    /// For the CPU.
    pub twin: fn(&mut twin::Args<'_>),
}

macro_rules! pass {
    ($name:ident) => {
        Pass {
            declaration: &pass::$name::DECLARATION,
            twin: twin::$name::run,
        }
    };
}

/// How many workgroups a step runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// One invocation an item.
    Items(u32),
    /// Workgroups.
    Groups([u32; 3]),
    /// As many as a row of [`Resource::Dispatches`] says.
    Indirect(u32),
}

/// One step of a frame.
#[derive(Clone, Debug)]
pub enum Step {
    /// A dispatch.
    Dispatch {
        /// What runs.
        pass: Pass,
        /// A resource a binding.
        bind: Vec<Resource>,
        /// Specialization constant 0.
        variant: u32,
        /// Push constants.
        constants: Vec<u8>,
        /// How often.
        extent: Extent,
    },
    /// Sets every word of a buffer to 0.
    Clear(Resource),
    /// Copies a whole buffer.
    Copy(Resource, Resource),
}

/// Sizes of a rig as a plan needs them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    /// Welded vertices.
    pub vertices: u32,
    /// Rows of the file.
    pub rows: u32,
    /// Influences a vertex.
    pub width: u32,
    /// Fields.
    pub fields: u32,
    /// Operators other than the union.
    pub operators: u32,
}

/// Rows of [`Resource::Dispatches`]: the seeds, a row a round, contacts, the region around them.
pub(super) fn dispatch_rows(settings: &Settings) -> u32 {
    settings.rounds + 3
}

/// The steps of one frame.
pub(super) fn frame(sizes: &Sizes, settings: &Settings) -> Vec<Step> {
    match settings.method {
        Method::Lbs => vec![skin_file_rows(sizes, true)],
        Method::Dqs => vec![skin_file_rows(sizes, false)],
        Method::Implicit => implicit(sizes, settings),
    }
}

/// The steps that measure the iso-values of whatever [`Resource::Positions`] holds.
pub(super) fn measure_iso(sizes: &Sizes) -> Vec<Step> {
    let constants = pass::measure::Constants {
        vertices: sizes.vertices,
    };
    let bind = with_field(&[
        Resource::Positions,
        Resource::IsoValues,
        Resource::Directions,
    ]);
    let extent = Extent::Items(sizes.vertices);
    let measure = dispatch(pass!(measure), &bind, &constants, extent);
    [&index(sizes)[..], &[composed(measure, sizes)]].concat()
}

fn implicit(sizes: &Sizes, settings: &Settings) -> Vec<Step> {
    let mut steps = vec![
        Step::Clear(Resource::Status),
        Step::Clear(Resource::ContactSet),
        Step::Clear(Resource::RegionSet),
        Step::Clear(Resource::BetaA),
        Step::Clear(Resource::BetaB),
        Step::Copy(Resource::SeedDispatches, Resource::Dispatches),
        skin_welded(sizes),
        Step::Copy(Resource::Geometric, Resource::Positions),
    ];
    steps.extend(index(sizes));
    march(&mut steps, sizes, settings);
    smooth_contacts(&mut steps, sizes, settings);
    let constants = pass::normals::Constants {
        vertices: sizes.vertices,
    };
    let bind = [
        Resource::CornerOffsets,
        Resource::Corners,
        Resource::Positions,
        Resource::SmoothNormals,
    ];
    steps.push(dispatch(
        pass!(normals),
        &bind,
        &constants,
        Extent::Items(sizes.vertices),
    ));
    steps.push(scatter(sizes));
    steps
}

/// Rounds of projection of the vertices that move against a field, compaction of the live vertices and relaxation (section 5).
fn march(steps: &mut Vec<Step>, sizes: &Sizes, settings: &Settings) {
    let lists = [Resource::LiveA, Resource::LiveB];
    let mut from = Resource::LiveB;
    steps.push(Step::Clear(Resource::LiveSet));
    steps.push(moved(sizes));
    steps.push(compact(sizes, Resource::LiveSet, from, 1));
    for round in 0..settings.rounds {
        let start = if round == 0 {
            Resource::Geometric
        } else {
            Resource::Relaxed
        };
        let last = round + 1 == settings.rounds;
        let fresh = if round == 0 { pass::project::FRESH } else { 0 };
        let limit = if last { pass::project::LAST } else { 0 };
        let count = if last {
            settings.settling_steps
        } else {
            settings.steps
        };
        if !last {
            steps.push(Step::Clear(Resource::LiveSet));
        }
        let projection = project(settings, from, round + 1, start, count, fresh | limit);
        steps.push(composed(projection, sizes));
        if !last {
            let to = lists[round as usize % 2];
            steps.push(compact(sizes, Resource::LiveSet, to, round + 2));
            steps.push(relax(to, round + 2));
            from = to;
        }
    }
}

/// β by diffusion from the contacts, Laplacian smoothing (Eq. 7), and back onto the iso-values.
fn smooth_contacts(steps: &mut Vec<Step>, sizes: &Sizes, settings: &Settings) {
    let (contacts, region) = (settings.rounds + 1, settings.rounds + 2);
    let list = Resource::RegionList;
    let (contact_set, region_set) = (Resource::ContactSet, Resource::RegionSet);
    steps.push(compact(sizes, contact_set, Resource::ContactList, contacts));
    steps.push(composed(touch(settings, contacts), sizes));
    steps.push(mark(contacts));
    steps.push(compact(sizes, region_set, list, region));
    let betas = [Resource::BetaA, Resource::BetaB];
    for k in 0..settings.diffusions as usize {
        steps.push(diffuse(region, k == 0, betas[(k + 1) % 2], betas[k % 2]));
    }
    let beta = betas[(settings.diffusions as usize + 1) % 2];
    steps.push(Step::Copy(Resource::Positions, Resource::Relaxed));
    let ends = [Resource::Positions, Resource::Relaxed];
    for k in 0..settings.smoothings as usize {
        steps.push(smooth(region, beta, ends[k % 2], ends[(k + 1) % 2]));
    }
    let flags = pass::project::FRESH | pass::project::LAST | pass::project::HOLD;
    let start = Resource::Relaxed;
    let projection = project(
        settings,
        list,
        region,
        start,
        settings.settling_steps,
        flags,
    );
    steps.push(composed(projection, sizes));
}

fn dispatch(pass: Pass, bind: &[Resource], constants: &impl Pod, extent: Extent) -> Step {
    debug_assert_eq!(
        pass.declaration.bindings.len(),
        bind.len(),
        "{}",
        pass.declaration.name
    );
    Step::Dispatch {
        pass,
        bind: bind.to_vec(),
        variant: 0,
        constants: bytes_of(constants).to_vec(),
        extent,
    }
}

/// The variant of a step that evaluates the composed field: 0 where every joint is a union.
fn composed(mut step: Step, sizes: &Sizes) -> Step {
    if let Step::Dispatch { variant, .. } = &mut step {
        *variant = u32::from(sizes.operators > 0);
    }
    step
}

fn moved(sizes: &Sizes) -> Step {
    let constants = pass::moved::Constants {
        dispatch: 0,
        width: sizes.width,
    };
    let bind = [
        Resource::SeedList,
        Resource::Dispatches,
        Resource::Geometric,
        Resource::IsoValues,
        Resource::Directions,
        Resource::InfluenceJoints,
        Resource::InfluenceWeights,
        Resource::Palette,
        Resource::SeedRanks,
        Resource::Positions,
        Resource::Status,
        Resource::LiveSet,
        Resource::Fields,
        Resource::Fields,
        Resource::Fields,
        Resource::Index,
    ];
    dispatch(pass!(moved), &bind, &constants, Extent::Indirect(0))
}

/// `bind`, and the seven bindings of the composed field.
fn with_field(bind: &[Resource]) -> Vec<Resource> {
    let field = [
        Resource::Fields,
        Resource::Fields,
        Resource::Fields,
        Resource::Index,
        Resource::Atlas,
        Resource::Operators,
        Resource::Opening,
    ];
    [bind, &field].concat()
}

/// Clears the index and enters every field: a workgroup row a field, [`SLICES`] workgroups each.
fn index(sizes: &Sizes) -> [Step; 2] {
    let enter = Step::Dispatch {
        pass: pass!(index),
        bind: [&[Resource::Fields; 3][..], &[Resource::Index]].concat(),
        variant: 0,
        constants: Vec::new(),
        extent: Extent::Groups([sizes.fields.max(1), SLICES, 1]),
    };
    [Step::Clear(Resource::Index), enter]
}

/// Workgroups that share one field's cells.
const SLICES: u32 = 4;

const INFLUENCES: [Resource; 4] = [
    Resource::Vertices,
    Resource::InfluenceJoints,
    Resource::InfluenceWeights,
    Resource::Palette,
];

fn skin_file_rows(sizes: &Sizes, linear: bool) -> Step {
    let rows = [Resource::FileRows, Resource::FileNormals];
    let out = [
        Resource::SkinPositions,
        Resource::SkinNormals,
        Resource::Rotations,
    ];
    let extent = Extent::Items(sizes.rows);
    let (rows_, width) = (sizes.rows, sizes.width);
    if linear {
        let constants = pass::skin_lbs::Constants { rows: rows_, width };
        dispatch(
            pass!(skin_lbs),
            &[&rows[..], &INFLUENCES, &out[..2]].concat(),
            &constants,
            extent,
        )
    } else {
        let constants = pass::skin_dqs::Constants { rows: rows_, width };
        dispatch(
            pass!(skin_dqs),
            &[&rows[..], &INFLUENCES, &out].concat(),
            &constants,
            extent,
        )
    }
}

fn skin_welded(sizes: &Sizes) -> Step {
    let rows = [Resource::WeldedRows, Resource::WeldedNormals];
    let out = [
        Resource::Geometric,
        Resource::SmoothNormals,
        Resource::Rotations,
    ];
    let constants = pass::skin_dqs::Constants {
        rows: sizes.vertices,
        width: sizes.width,
    };
    let bind = [&rows[..], &INFLUENCES, &out].concat();
    dispatch(
        pass!(skin_dqs),
        &bind,
        &constants,
        Extent::Items(sizes.vertices),
    )
}

fn project(
    settings: &Settings,
    list: Resource,
    head: u32,
    start: Resource,
    steps: u32,
    flags: u32,
) -> Step {
    let constants = pass::project::Constants {
        dispatch: head,
        steps,
        evaluations: steps + u32::from(flags & pass::project::LAST != 0),
        flags,
        sigma: settings.sigma,
        tolerance: settings.tolerance,
        cos_contact: settings.contact_degrees.to_radians().cos(),
    };
    let bind = with_field(&[
        list,
        Resource::Dispatches,
        start,
        Resource::Geometric,
        Resource::Vertices,
        Resource::IsoValues,
        Resource::Positions,
        Resource::Anchors,
        Resource::Gradients,
        Resource::Status,
        Resource::LiveSet,
        Resource::Directions,
        Resource::Rotations,
        Resource::ContactSet,
        Resource::SeedRanks,
    ]);
    dispatch(pass!(project), &bind, &constants, Extent::Indirect(head))
}

fn touch(settings: &Settings, head: u32) -> Step {
    let constants = pass::touch::Constants {
        dispatch: head,
        cos_contact: settings.contact_degrees.to_radians().cos(),
    };
    let bind = with_field(&[
        Resource::ContactList,
        Resource::Dispatches,
        Resource::Anchors,
        Resource::Gradients,
        Resource::IsoValues,
        Resource::Positions,
    ]);
    dispatch(pass!(touch), &bind, &constants, Extent::Indirect(head))
}

fn compact(sizes: &Sizes, set: Resource, to: Resource, result: u32) -> Step {
    let constants = pass::compact::Constants { result };
    let bind = [Resource::SeedList, set, Resource::Dispatches, to];
    let blocks = sizes.vertices.div_ceil(SET_SEEDS as u32);
    let invocations = blocks * SET_SEEDS as u32 / pass::compact::SEEDS;
    dispatch(
        pass!(compact),
        &bind,
        &constants,
        Extent::Items(invocations),
    )
}

fn relax(list: Resource, head: u32) -> Step {
    let bind = [
        list,
        Resource::Dispatches,
        Resource::RingOffsets,
        Resource::Rings,
        Resource::MeanValues,
        Resource::Positions,
        Resource::Anchors,
        Resource::Gradients,
        Resource::Relaxed,
    ];
    dispatch(
        pass!(relax),
        &bind,
        &pass::relax::Constants { dispatch: head },
        Extent::Indirect(head),
    )
}

fn mark(head: u32) -> Step {
    let bind = [
        Resource::ContactList,
        Resource::Dispatches,
        Resource::NeighbourhoodOffsets,
        Resource::Neighbourhoods,
        Resource::SeedRanks,
        Resource::RegionSet,
    ];
    dispatch(
        pass!(mark),
        &bind,
        &pass::mark::Constants { dispatch: head },
        Extent::Indirect(head),
    )
}

fn diffuse(head: u32, first: bool, from: Resource, to: Resource) -> Step {
    let constants = pass::diffuse::Constants {
        dispatch: head,
        first: first.into(),
    };
    let bind = [
        Resource::RegionList,
        Resource::Dispatches,
        Resource::RingOffsets,
        Resource::Rings,
        Resource::Status,
        from,
        to,
    ];
    dispatch(pass!(diffuse), &bind, &constants, Extent::Indirect(head))
}

fn smooth(head: u32, beta: Resource, from: Resource, to: Resource) -> Step {
    let bind = [
        Resource::RegionList,
        Resource::Dispatches,
        Resource::RingOffsets,
        Resource::Rings,
        beta,
        from,
        to,
    ];
    dispatch(
        pass!(smooth),
        &bind,
        &pass::smooth::Constants { dispatch: head },
        Extent::Indirect(head),
    )
}

fn scatter(sizes: &Sizes) -> Step {
    let bind = [
        Resource::FileRows,
        Resource::FileNormals,
        Resource::Vertices,
        Resource::Rotations,
        Resource::Positions,
        Resource::SmoothNormals,
        Resource::SkinPositions,
        Resource::SkinNormals,
    ];
    dispatch(
        pass!(scatter),
        &bind,
        &pass::scatter::Constants { rows: sizes.rows },
        Extent::Items(sizes.rows),
    )
}
