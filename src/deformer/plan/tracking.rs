//! A frame of iso-surface tracking (2014, section 5).

use super::{Extent, Plan, Resource, Settings, Sizes, Step, steps::*};

const TRACKS: [Resource; 3] = [Resource::TrackA, Resource::TrackB, Resource::TrackC];
const SLOPES: [Resource; 2] = [Resource::SlopesA, Resource::SlopesB];

/// Iterations of a round; the tracks take turns in threes, the slopes in twos.
pub(in crate::deformer) const ROUND: u32 = 6;
/// Iterations from one evaluation of the field to the next.
pub(in crate::deformer) const STRIDE: u32 = 3;

/// Rows of [`Resource::Dispatches`].
pub(in crate::deformer) mod rows {
    pub(in crate::deformer) const SEEDS: u32 = 0;
    /// What a round iterates on.
    pub(in crate::deformer) const LIVE: u32 = 1;
    pub(in crate::deformer) const CONTACTS: u32 = 2;
    /// Around the contacts.
    pub(in crate::deformer) const REGION: u32 = 3;
    /// What begins the halves of a sub-step: no workgroups and no items where there are no faults. Of the seeds' heads, its
    /// number of items is that of the faults at rest.
    pub(in crate::deformer) const REDO: u32 = 4;
    pub(in crate::deformer) const COUNT: u32 = 5;
}

/// The frame: sub-steps of rounds, then the skin of their end.
pub(super) fn frame(sizes: &Sizes, settings: &Settings) -> Plan {
    let sections = [
        [&clear_skin()[..], &[Step::Clear(Resource::Stirs)]].concat(),
        begin(sizes, settings),
        round(sizes, settings, false),
        round(sizes, settings, true),
        judged(sizes, settings),
        halved(sizes, settings),
        vec![
            Step::Copy(TRACKS[0], Resource::Tracked),
            Step::Copy(TRACKS[2], Resource::TrackedBefore),
            Step::Copy(SLOPES[0], Resource::TrackedSlopes),
        ],
        skin(sizes, settings),
    ];
    Plan::of(sections)
}

/// Begins a sub-step.
fn begin(sizes: &Sizes, settings: &Settings) -> Vec<Step> {
    let mut steps = vec![
        take_palette(),
        take_fields(),
        Step::Copy(Resource::SeedDispatches, Resource::Dispatches),
    ];
    steps.extend(carried(sizes, settings, Extent::Items(sizes.vertices)));
    steps
}

/// Carries the skin on to the pose that was taken.
fn carried(sizes: &Sizes, settings: &Settings, extent: Extent) -> Vec<Step> {
    let mut steps = vec![skin_welded(sizes)];
    steps.extend(index(sizes));
    steps.push(Step::Clear(Resource::LiveSet));
    steps.push(advance(sizes, settings, extent));
    steps.push(goals(sizes));
    steps
}

/// Looks for faults.
fn judged(sizes: &Sizes, settings: &Settings) -> Vec<Step> {
    vec![
        Step::Clear(Resource::Faults),
        judge(sizes, TRACKS[0], SLOPES[0]),
        redo(sizes, settings),
    ]
}

/// As a sub-step begins, but the skin is only carried on, from where it was, if there were faults. Without them, nothing lives
/// in the rounds that follow.
fn halved(sizes: &Sizes, settings: &Settings) -> Vec<Step> {
    let mut steps = vec![take_palette(), take_fields()];
    steps.extend(carried(sizes, settings, Extent::Indirect(rows::REDO)));
    steps
}

/// Iterates on what moves against its joint; finds what still does, unless this is the last round.
fn round(sizes: &Sizes, settings: &Settings, last: bool) -> Vec<Step> {
    // The lists of several instances make their common head by a maximum.
    let mut steps = match sizes.instances {
        1 => vec![],
        _ => vec![Step::Empty(rows::LIVE)],
    };
    // A skin without others has all rounds of the frame, and needs no number of them.
    let compact = match settings.instances {
        1 => compact,
        _ => compact_round,
    };
    steps.extend([
        compact(sizes, Resource::LiveSet, Resource::LiveA, rows::LIVE),
        Step::Clear(Resource::LiveSet),
    ]);
    for k in 0..ROUND as usize {
        let evaluations = k / STRIDE as usize;
        let iteration = Iteration {
            list: Resource::LiveA,
            head: rows::LIVE,
            starts: TRACKS[k % 3],
            befores: TRACKS[(k + 2) % 3],
            tracks: TRACKS[(k + 1) % 3],
            slopes: [SLOPES[evaluations % 2], SLOPES[(evaluations + 1) % 2]],
            omega: omega(settings.spectral_radius),
            enter: k + 1 == ROUND as usize && !last,
        };
        steps.push(if (k as u32 + 1).is_multiple_of(STRIDE) {
            track(sizes, settings, &iteration)
        } else {
            slide(sizes, &iteration)
        });
    }
    steps.push(Step::Keep(Resource::Dispatches, Resource::History));
    steps
}

/// ω of the second-order semi-iteration, to which Chebyshev's tends: 2 / (1 + √(1 − ρ²)) (Golub and Varga 1961). A skin in
/// motion never begins anew, so that the iteration is taken on from pose to pose.
fn omega(spectral_radius: f32) -> f32 {
    2.0 / (1.0 + (1.0 - spectral_radius * spectral_radius).sqrt())
}

/// Puts the tracked skin onto its iso-values, smooths it at contacts, eases it there, and gives the file its rows.
fn skin(sizes: &Sizes, settings: &Settings) -> Vec<Step> {
    let seeds = (Resource::SeedList, rows::SEEDS);
    let mut steps = vec![
        Step::Copy(Resource::Tracked, Resource::Positions),
        settle(sizes, settings, seeds, Resource::Tracked, false),
        compact(
            sizes,
            Resource::ContactSet,
            Resource::ContactList,
            rows::CONTACTS,
        ),
    ];
    smooth_region(&mut steps, sizes, settings, [rows::CONTACTS, rows::REGION]);
    let region = (Resource::RegionList, rows::REGION);
    steps.push(settle(sizes, settings, region, Resource::Relaxed, true));
    steps.push(ease(sizes, settings));
    steps.push(normals(sizes));
    steps.push(scatter(sizes));
    steps.extend(flesh(sizes));
    steps
}
