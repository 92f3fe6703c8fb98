//! One function a step: the pass, what it binds, its constants and extent.

macro_rules! pass {
    ($name:ident) => {
        Pass {
            declaration: &pass::$name::DECLARATION,
            twin: twin::$name::run,
        }
    };
}

mod tracking;

pub(super) use tracking::*;

use bytemuck::{Pod, bytes_of};

use super::{Extent, Pass, Resource, Settings, Sizes, Step};
use crate::{layout::SET_SEEDS, pass, twin};

pub(super) fn dispatch(
    pass: Pass,
    bind: &[Resource],
    constants: &impl Pod,
    extent: Extent,
) -> Step {
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
        slice_at: None,
        extent,
    }
}

/// A step that evaluates the composed field, by the variant that composes as this rig does.
pub(super) fn composed(mut step: Step, sizes: &Sizes) -> Step {
    if let Step::Dispatch { variant, .. } = &mut step {
        *variant = sizes.composition;
    }
    step
}

pub(super) fn moved(sizes: &Sizes) -> Step {
    let constants = pass::moved::Constants {
        dispatch: 0,
        vertices: sizes.vertices,
        joints: sizes.joints,
        fields: sizes.field_room(),
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
        Resource::Index,
    ];
    dispatch(pass!(moved), &bind, &constants, Extent::Indirect(0))
}

/// `bind`, and the six bindings of the composed field.
fn with_field(bind: &[Resource]) -> Vec<Resource> {
    let field = [
        Resource::Fields,
        Resource::Fields,
        Resource::Index,
        Resource::Atlas,
        Resource::Operators,
        Resource::Opening,
    ];
    [bind, &field].concat()
}

/// Clears the index and enters every field, several workgroups each.
pub(super) fn index(sizes: &Sizes) -> [Step; 2] {
    let bind = [Resource::Fields, Resource::Fields, Resource::Index];
    let fields = sizes.field_room();
    let constants = pass::index::Constants { fields };
    let extent = Extent::Groups([fields * pass::index::SLICES, 1, 1]);
    [
        Step::Clear(Resource::Index),
        dispatch(pass!(index), &bind, &constants, extent),
    ]
}

const INFLUENCES: [Resource; 4] = [
    Resource::Vertices,
    Resource::InfluenceJoints,
    Resource::InfluenceWeights,
    Resource::Palette,
];

pub(super) fn skin_file_rows(sizes: &Sizes, linear: bool) -> Step {
    let rows = [Resource::FileRows, Resource::FileNormals];
    let out = [
        Resource::SkinPositions,
        Resource::SkinNormals,
        Resource::Rotations,
    ];
    let extent = Extent::Items(sizes.rows);
    if linear {
        let constants = pass::skin_lbs::Constants {
            rows: sizes.rows,
            width: sizes.width,
            joints: sizes.joints,
        };
        dispatch(
            pass!(skin_lbs),
            &[&rows[..], &INFLUENCES, &out[..2]].concat(),
            &constants,
            extent,
        )
    } else {
        let constants = pass::skin_dqs::Constants {
            rows: sizes.rows,
            width: sizes.width,
            joints: sizes.joints,
        };
        dispatch(
            pass!(skin_dqs),
            &[&rows[..], &INFLUENCES, &out].concat(),
            &constants,
            extent,
        )
    }
}

pub(super) fn skin_welded(sizes: &Sizes) -> Step {
    let rows = [Resource::WeldedRows, Resource::WeldedNormals];
    let out = [
        Resource::Geometric,
        Resource::SmoothNormals,
        Resource::Rotations,
    ];
    let constants = pass::skin_dqs::Constants {
        rows: sizes.vertices,
        width: sizes.width,
        joints: sizes.joints,
    };
    let bind = [&rows[..], &INFLUENCES, &out].concat();
    dispatch(
        pass!(skin_dqs),
        &bind,
        &constants,
        Extent::Items(sizes.vertices),
    )
}

pub(super) fn project(
    sizes: &Sizes,
    settings: &Settings,
    list: Resource,
    head: u32,
    start: Resource,
    steps: u32,
    flags: u32,
) -> Step {
    let constants = pass::project::Constants {
        dispatch: head,
        vertices: sizes.vertices,
        fields: sizes.field_room(),
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
    let extent = Extent::Indirect(head);
    composed(dispatch(pass!(project), &bind, &constants, extent), sizes)
}

pub(super) fn touch(sizes: &Sizes, settings: &Settings, head: u32) -> Step {
    let constants = pass::touch::Constants {
        dispatch: head,
        vertices: sizes.vertices,
        fields: sizes.field_room(),
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
    let extent = Extent::Indirect(head);
    composed(dispatch(pass!(touch), &bind, &constants, extent), sizes)
}

pub(super) fn compact(sizes: &Sizes, set: Resource, to: Resource, result: u32) -> Step {
    let constants = pass::compact::Constants {
        result,
        vertices: sizes.vertices,
        fields: sizes.field_room(),
        round: 0,
    };
    let bind = [
        Resource::SeedList,
        set,
        Resource::Dispatches,
        to,
        Resource::Fields,
    ];
    let blocks = sizes.vertices.div_ceil(SET_SEEDS as u32);
    let invocations = blocks * SET_SEEDS as u32 / pass::compact::SEEDS;
    dispatch(
        pass!(compact),
        &bind,
        &constants,
        Extent::Items(invocations),
    )
}

pub(super) fn relax(sizes: &Sizes, list: Resource, head: u32) -> Step {
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
        &pass::relax::Constants {
            dispatch: head,
            vertices: sizes.vertices,
        },
        Extent::Indirect(head),
    )
}

pub(super) fn mark(sizes: &Sizes, head: u32) -> Step {
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
        &pass::mark::Constants {
            dispatch: head,
            vertices: sizes.vertices,
        },
        Extent::Indirect(head),
    )
}

pub(super) fn diffuse(sizes: &Sizes, head: u32, first: bool, [from, to]: [Resource; 2]) -> Step {
    let constants = pass::diffuse::Constants {
        dispatch: head,
        vertices: sizes.vertices,
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

pub(super) fn smooth(sizes: &Sizes, head: u32, beta: Resource, [from, to]: [Resource; 2]) -> Step {
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
        &pass::smooth::Constants {
            dispatch: head,
            vertices: sizes.vertices,
        },
        Extent::Indirect(head),
    )
}

pub(super) fn scatter(sizes: &Sizes) -> Step {
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
        &pass::scatter::Constants {
            rows: sizes.rows,
            vertices: sizes.vertices,
        },
        Extent::Items(sizes.rows),
    )
}

/// Bends what follows a spine; the last step of every method, where anything does.
pub(super) fn flesh(sizes: &Sizes) -> Option<Step> {
    let bind = [
        Resource::FleshRows,
        Resource::FleshRows,
        Resource::SpineWeights,
        Resource::SpinePoints,
        Resource::Palette,
        Resource::SkinPositions,
        Resource::SkinNormals,
    ];
    let constants = pass::flesh::Constants {
        count: sizes.fleshed,
        rows: sizes.rows,
        joints: sizes.joints,
    };
    let step = || {
        dispatch(
            pass!(flesh),
            &bind,
            &constants,
            Extent::Items(sizes.fleshed),
        )
    };
    (sizes.fleshed > 0).then(step)
}

/// Clears what a frame says of its skin.
pub(super) fn clear_skin() -> [Step; 5] {
    [
        Resource::Status,
        Resource::ContactSet,
        Resource::RegionSet,
        Resource::BetaA,
        Resource::BetaB,
    ]
    .map(Step::Clear)
}

/// The list of a round of iterations: nothing for an instance that has had all its rounds.
pub(super) fn compact_round(sizes: &Sizes, set: Resource, to: Resource, result: u32) -> Step {
    let mut step = compact(sizes, set, to, result);
    if let Step::Dispatch { slice_at, .. } = &mut step {
        *slice_at = Some(std::mem::offset_of!(pass::compact::Constants, round));
    }
    step
}

/// The palette of the sub-step.
pub(super) fn take_palette() -> Step {
    Step::Take(Resource::PaletteRing, Resource::Palette)
}

/// The posed fields of the sub-step.
pub(super) fn take_fields() -> Step {
    Step::Take(Resource::FieldsRing, Resource::Fields)
}

pub(super) fn measure(sizes: &Sizes) -> Step {
    let constants = pass::measure::Constants {
        vertices: sizes.vertices,
        fields: sizes.field_room(),
    };
    let bind = with_field(&[
        Resource::Positions,
        Resource::IsoValues,
        Resource::Directions,
    ]);
    let extent = Extent::Items(sizes.vertices);
    composed(dispatch(pass!(measure), &bind, &constants, extent), sizes)
}

pub(super) fn normals(sizes: &Sizes) -> Step {
    let constants = pass::normals::Constants {
        vertices: sizes.vertices,
    };
    let bind = [
        Resource::CornerOffsets,
        Resource::Corners,
        Resource::Positions,
        Resource::SmoothNormals,
    ];
    let extent = Extent::Items(sizes.vertices);
    dispatch(pass!(normals), &bind, &constants, extent)
}

/// β by diffusion from the contacts, and Laplacian smoothing (2013, Eq. 7) of [`Resource::Positions`] into
/// [`Resource::Relaxed`]; the rows are those of the contacts and of the region around them.
pub(super) fn smooth_region(
    steps: &mut Vec<Step>,
    sizes: &Sizes,
    settings: &Settings,
    [contacts, region]: [u32; 2],
) {
    steps.push(mark(sizes, contacts));
    steps.push(compact(
        sizes,
        Resource::RegionSet,
        Resource::RegionList,
        region,
    ));
    let betas = [Resource::BetaA, Resource::BetaB];
    for k in 0..settings.diffusions as usize {
        steps.push(diffuse(
            sizes,
            region,
            k == 0,
            [betas[(k + 1) % 2], betas[k % 2]],
        ));
    }
    let beta = betas[(settings.diffusions as usize + 1) % 2];
    steps.push(Step::Copy(Resource::Positions, Resource::Relaxed));
    let ends = [Resource::Positions, Resource::Relaxed];
    for k in 0..settings.smoothings as usize {
        steps.push(smooth(
            sizes,
            region,
            beta,
            [ends[k % 2], ends[(k + 1) % 2]],
        ));
    }
}
