//! The steps that only tracking has.

use super::{composed, dispatch, with_field};
use crate::{
    deformer::{
        Kind,
        plan::{Extent, Pass, Resource, Settings, Sizes, Step, rows},
    },
    pass, twin,
};

/// One iteration of tracking.
pub(in crate::deformer::plan) struct Iteration {
    pub(in crate::deformer::plan) list: Resource,
    pub(in crate::deformer::plan) head: u32,
    pub(in crate::deformer::plan) starts: Resource,
    pub(in crate::deformer::plan) befores: Resource,
    pub(in crate::deformer::plan) tracks: Resource,
    /// Gradients of the last evaluation, and of this one.
    pub(in crate::deformer::plan) slopes: [Resource; 2],
    pub(in crate::deformer::plan) omega: f32,
    /// Those that still move enter [`Resource::LiveSet`].
    pub(in crate::deformer::plan) enter: bool,
}

pub(in crate::deformer::plan) fn track(sizes: &Sizes, settings: &Settings, i: &Iteration) -> Step {
    let constants = pass::track::Constants {
        dispatch: i.head,
        vertices: sizes.vertices,
        fields: sizes.field_room(),
        enter: i.enter.into(),
        omega: i.omega,
        sigma: settings.sigma,
        stillness: settings.stillness,
    };
    let front = with_field(&[
        i.list,
        Resource::Dispatches,
        Resource::RingOffsets,
        Resource::Rings,
        Resource::RingWeights,
        Resource::Bodies,
        Resource::Goals,
        i.starts,
        i.befores,
        i.slopes[0],
        i.tracks,
        i.slopes[1],
    ]);
    let bind = [&front[..], &[Resource::LiveSet]].concat();
    let extent = Extent::Indirect(i.head);
    composed(dispatch(pass!(track), &bind, &constants, extent), sizes)
}

/// An iteration without its Newton step.
pub(in crate::deformer::plan) fn slide(sizes: &Sizes, i: &Iteration) -> Step {
    let constants = pass::slide::Constants {
        dispatch: i.head,
        vertices: sizes.vertices,
        fields: sizes.field_room(),
        omega: i.omega,
    };
    let bind = [
        i.list,
        Resource::Dispatches,
        Resource::RingOffsets,
        Resource::Rings,
        Resource::RingWeights,
        Resource::Bodies,
        Resource::Goals,
        i.starts,
        i.befores,
        i.slopes[0],
        Resource::Fields,
        i.tracks,
    ];
    dispatch(pass!(slide), &bind, &constants, Extent::Indirect(i.head))
}

pub(in crate::deformer::plan) fn advance(
    sizes: &Sizes,
    settings: &Settings,
    extent: Extent,
) -> Step {
    let constants = pass::advance::Constants {
        vertices: sizes.vertices,
        width: sizes.width,
        stillness: settings.stillness,
        joints: sizes.joints,
        fields: sizes.field_room(),
        redo: match extent {
            Extent::Indirect(row) => row,
            _ => pass::advance::NO_ROW,
        },
    };
    let bind = [
        Resource::Tracked,
        Resource::TrackedBefore,
        Resource::TrackedSlopes,
        Resource::Geometric,
        Resource::Vertices,
        Resource::Bodies,
        Resource::InfluenceJoints,
        Resource::InfluenceWeights,
        Resource::Palette,
        Resource::Directions,
        Resource::TrackA,
        Resource::TrackB,
        Resource::TrackC,
        Resource::SlopesA,
        Resource::SlopesB,
        Resource::Around,
        Resource::Stirs,
        Resource::LiveSet,
        Resource::Dispatches,
        Resource::Fields,
        Resource::Fields,
        Resource::Index,
    ];
    dispatch(pass!(advance), &bind, &constants, extent)
}

pub(in crate::deformer::plan) fn goals(sizes: &Sizes) -> Step {
    let constants = pass::goals::Constants {
        vertices: sizes.vertices,
        fields: sizes.field_room(),
    };
    let bind = [
        Resource::RingOffsets,
        Resource::Rings,
        Resource::RingWeights,
        Resource::Vertices,
        Resource::Rotations,
        Resource::Fields,
        Resource::Geometric,
        Resource::Stirs,
        Resource::Goals,
    ];
    let extent = Extent::Items(sizes.vertices);
    dispatch(pass!(goals), &bind, &constants, extent)
}

/// Settles a list from `starts`; `hold` keeps contacts where they are.
pub(in crate::deformer::plan) fn settle(
    sizes: &Sizes,
    settings: &Settings,
    (list, head): (Resource, u32),
    starts: Resource,
    hold: bool,
) -> Step {
    let constants = pass::settle::Constants {
        dispatch: head,
        vertices: sizes.vertices,
        fields: sizes.field_room(),
        listed: match list.kind() {
            Kind::Static => 0,
            _ => sizes.vertices,
        },
        steps: settings.settling_steps,
        hold: hold.into(),
        sigma: settings.sigma,
        tolerance: settings.tolerance,
        cos_contact: settings.contact_degrees.to_radians().cos(),
    };
    let bind = with_field(&[
        list,
        Resource::Dispatches,
        starts,
        Resource::Bodies,
        Resource::SeedRanks,
        Resource::Positions,
        Resource::Status,
        Resource::ContactSet,
    ]);
    let extent = Extent::Indirect(head);
    composed(dispatch(pass!(settle), &bind, &constants, extent), sizes)
}

/// Lets the settled skin follow the tracked one at its pace.
pub(in crate::deformer::plan) fn ease(sizes: &Sizes, settings: &Settings) -> Step {
    let constants = pass::ease::Constants {
        dispatch: rows::SEEDS,
        vertices: sizes.vertices,
        joints: sizes.joints,
        fields: sizes.field_room(),
        tolerance: settings.tolerance,
    };
    let bind = with_field(&[
        Resource::SeedList,
        Resource::Dispatches,
        Resource::Tracked,
        Resource::Stirs,
        Resource::Bodies,
        Resource::Vertices,
        Resource::Palette,
        Resource::Corrections,
        Resource::Positions,
        Resource::Status,
    ]);
    let extent = Extent::Indirect(rows::SEEDS);
    composed(dispatch(pass!(ease), &bind, &constants, extent), sizes)
}

/// Counts the faults of a track.
pub(in crate::deformer::plan) fn judge(sizes: &Sizes, tracks: Resource, slopes: Resource) -> Step {
    let constants = pass::judge::Constants {
        dispatch: rows::SEEDS,
        vertices: sizes.vertices,
        joints: sizes.joints,
        fields: sizes.field_room(),
    };
    let bind = [
        Resource::SeedList,
        Resource::Dispatches,
        Resource::CornerOffsets,
        Resource::Corners,
        Resource::Bodies,
        tracks,
        slopes,
        Resource::Fields,
        Resource::Tracked,
        Resource::Vertices,
        Resource::Palette,
        Resource::Faults,
    ];
    let extent = Extent::Indirect(rows::SEEDS);
    dispatch(pass!(judge), &bind, &constants, extent)
}

/// Decides whether the sub-step is done again.
pub(in crate::deformer::plan) fn redo(sizes: &Sizes, settings: &Settings) -> Step {
    let constants = pass::redo::Constants {
        redo: rows::REDO,
        vertices: sizes.vertices,
        allowed: settings.allowed_faults,
    };
    let bind = [
        Resource::Faults,
        Resource::SeedDispatches,
        Resource::Dispatches,
    ];
    dispatch(pass!(redo), &bind, &constants, Extent::Groups([1, 1, 1]))
}
