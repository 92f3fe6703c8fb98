//! A frame of implicit skinning (2013).

use super::{Resource, Settings, Sizes, Step, steps::*};
use crate::pass;

pub(super) fn frame(sizes: &Sizes, settings: &Settings) -> Vec<Step> {
    let mut steps = clear_skin().to_vec();
    steps.extend([
        Step::Copy(Resource::SeedDispatches, Resource::Dispatches),
        skin_welded(sizes),
        Step::Copy(Resource::Geometric, Resource::Positions),
    ]);
    steps.extend(index(sizes));
    march(&mut steps, sizes, settings);
    smooth_contacts(&mut steps, sizes, settings);
    steps.push(normals(sizes));
    steps.push(scatter(sizes));
    steps.extend(flesh(sizes));
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
        let flags = fresh | limit;
        steps.push(project(
            sizes,
            settings,
            from,
            round + 1,
            start,
            count,
            flags,
        ));
        if !last {
            let to = lists[round as usize % 2];
            steps.push(compact(sizes, Resource::LiveSet, to, round + 2));
            steps.push(relax(sizes, to, round + 2));
            from = to;
        }
    }
}

/// Contacts near the discontinuity, smoothed, and back onto the iso-values.
fn smooth_contacts(steps: &mut Vec<Step>, sizes: &Sizes, settings: &Settings) {
    let (contacts, region) = (settings.rounds + 1, settings.rounds + 2);
    let list = Resource::RegionList;
    steps.push(compact(
        sizes,
        Resource::ContactSet,
        Resource::ContactList,
        contacts,
    ));
    steps.push(touch(sizes, settings, contacts));
    smooth_region(steps, sizes, settings, [contacts, region]);
    let flags = pass::project::FRESH | pass::project::LAST | pass::project::HOLD;
    let (start, count) = (Resource::Relaxed, settings.settling_steps);
    steps.push(project(sizes, settings, list, region, start, count, flags));
}
