//! Skinning decomposition (2016, section 6.2): a captured sequence as a rest pose, rigid bones that are the spheres of a
//! level, and smooth weights.

mod border;
mod choose;
mod filter;
mod input;
mod islands;
mod model;
mod motion;
mod rest;
mod simplex;
mod skin;
mod start;
#[cfg(test)]
mod tests;
mod transforms;
mod tree;
mod weights;

use glam::{DMat3, DVec3, Vec3};

use self::{filter::Filter, input::Frames, skin::State, transforms::Bones};
use super::{hierarchy::Hierarchy, level::Level};
use crate::{Error, Result, asset::Sequence, mesh::Mesh, report::Progress};

/// Iterations over which the error is watched; after the second of each such round bones are chosen anew.
const ROUND: usize = 5;
/// Rounds after which no bone is chosen anew.
const CHOICES: usize = 4;
/// Iterations before the rest pose is fitted: it would take up what bones and weights explain once they have been chosen.
const REST_FROM: usize = 2 * ROUND;
/// Rings of spheres around a vertex's own that it may follow.
const RINGS: usize = 2;

/// What weights are made from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// From geometry where that reproduces the animation, from the animation elsewhere: parts that moved together can still
    /// be posed one by one.
    Mixed,
    /// From the animation alone.
    Animation,
}

/// Settings of a decomposition.
#[derive(Clone, Debug)]
pub struct Decomposing {
    /// Most bones a vertex follows.
    pub influences: usize,
    /// Most iterations.
    pub iterations: usize,
    /// Stops where an iteration lowers the error by less than this share of it.
    pub tolerance: f64,
    /// What weights are made from.
    pub weighting: Weighting,
    /// How strongly adjacent spheres hold together where their regions meet, against fitting the animation: at 0 they are free,
    /// from about 1 on they turn about joints.
    pub joints: f64,
}

impl Default for Decomposing {
    fn default() -> Self {
        Self {
            influences: 4,
            iterations: 60,
            tolerance: 4e-3,
            weighting: Weighting::Mixed,
            joints: 0.0,
        }
    }
}

/// A decomposed sequence.
#[derive(Clone, Debug)]
pub struct Decomposition {
    /// Rest pose of the welded vertices, in the sequence's units.
    pub rest: Vec<Vec3>,
    /// Sphere and weight, greatest first, sum 1, of each welded vertex.
    pub influences: Vec<Vec<(u32, f32)>>,
    /// Centres of the spheres at rest.
    pub centres: Vec<DVec3>,
    /// Rotation and translation from rest, `[clip][frame][sphere]`.
    pub motions: Vec<Vec<Vec<(DMat3, DVec3)>>>,
    /// 2000 |A - A'| / (diagonal √(3 F N)): the root mean square error of a coordinate, in 1/2000 of the diagonal.
    pub e_rms: f64,
    /// Eq. 13 in every frame of each clip: mean square distance by area, over the diagonal's square.
    pub mse: Vec<Vec<f64>>,
    /// Iterations made.
    pub iterations: usize,
    /// Whether the tolerance ended them.
    pub converged: bool,
}

fn check(options: &Decomposing, hierarchy: &Hierarchy, level: &Level) -> Result<()> {
    if !level.is_of(hierarchy) {
        return Err(Error::argument("level", "made from another sphere-mesh"));
    }
    if !(1..=simplex::MOST).contains(&options.influences) {
        let reason = format!("{}, not from 1 to {}", options.influences, simplex::MOST);
        return Err(Error::argument("influences", reason));
    }
    if !(options.tolerance >= 0.0 && options.tolerance < 1.0) {
        return Err(Error::argument("tolerance", "a share from 0 up to 1"));
    }
    if !(options.joints >= 0.0 && options.joints <= 1e6) {
        return Err(Error::argument("joints", "a weight is from 0 to 1e6"));
    }
    if level.nodes.len() > usize::from(u16::MAX) {
        let reason = format!("{}, but a skin has at most 65535 joints", level.nodes.len());
        return Err(Error::argument("spheres", reason));
    }
    Ok(())
}

/// Decomposes clips of the mesh that `hierarchy` was built from; they share one rest pose, and weights.
///
/// # Errors
/// [`Error::Argument`] for options out of range and a level of another sphere-mesh; [`Error::Asset`] naming clip and frame,
/// vertex or triangle where a clip is not of that mesh or has a position that is not finite.
pub fn decompose(
    hierarchy: &Hierarchy,
    level: &Level,
    clips: &[Sequence],
    options: &Decomposing,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Decomposition> {
    check(options, hierarchy, level)?;
    // On a thread of the pool: others join in sooner than when they are asked from outside.
    rayon::scope(|_| {
        let (work, mut state) = Work::new(hierarchy, level, clips, options)?;
        let ended = work.iterate(&mut state, options, progress);
        Ok(work.finish(hierarchy, &state, ended))
    })
}

/// What stays as it is from iteration to iteration.
struct Work<'a> {
    frames: Frames,
    level: &'a Level,
    centres: Vec<DVec3>,
    mesh: Mesh,
    filter: Filter,
    /// Where each bone meets others: the other, the place at rest and how much it counts.
    joints: Vec<Vec<(usize, DVec3, f64)>>,
    /// Spheres that a vertex of each sphere may follow.
    around: Vec<Vec<u32>>,
}

impl<'a> Work<'a> {
    /// With the state that the iterations begin at.
    fn new(
        hierarchy: &Hierarchy,
        level: &'a Level,
        clips: &[Sequence],
        options: &Decomposing,
    ) -> Result<(Self, State)> {
        let frames = Frames::new(hierarchy, clips)?;
        let unit = |p: Vec3| (p.as_dvec3() - hierarchy.origin) / hierarchy.diagonal;
        let centre = |&node: &u32| unit(hierarchy.centre(node as usize, 0));
        let centres: Vec<DVec3> = level.nodes.iter().map(centre).collect();
        let rest: Vec<DVec3> = (0..frames.vertices).map(|v| frames.first(v)).collect();
        let points = rest.iter().map(|p| p.as_vec3()).collect();
        let mesh = Mesh::new(points, hierarchy.triangles.clone());
        let lists = start::heat(&mesh, level, &centres);
        let mut state = State {
            skin: start::keep(&lists, options.influences),
            rest,
            motions: Vec::new(),
        };
        let mut joints = vec![Vec::new(); centres.len()];
        if options.joints > 0.0 {
            for border in border::borders(&hierarchy.triangles, &level.labels, &state.rest) {
                let [a, b] = border.spheres;
                let count = options.joints * border.size;
                joints[a].push((b, border.middle, count));
                joints[b].push((a, border.middle, count));
            }
        }
        let work = Self {
            joints,
            filter: Filter::new(&mesh, &frames.weight),
            around: choose::around(&level.near, RINGS),
            frames,
            level,
            centres,
            mesh,
        };
        state.motions = transforms::start(&work.frames, &state, &work.bones(&state));
        Ok((work, state))
    }

    /// Motions, weights and, later, rest pose in turn; returns how often, and whether the tolerance ended it.
    fn iterate(
        &self,
        state: &mut State,
        options: &Decomposing,
        progress: &(dyn Fn(Progress) + Sync),
    ) -> (usize, bool) {
        let (mut errors, mut done, mut converged) = (Vec::new(), 0, false);
        while done < options.iterations && !converged {
            errors.push(self.motions(state).sqrt());
            let smooth = match options.weighting {
                Weighting::Mixed => self.filter.apply(&state.skin, self.centres.len()),
                Weighting::Animation => state.skin.weights.clone(),
            };
            weights::improve(&self.frames, state, &smooth, options.weighting);
            done += 1;
            if done % ROUND == 2 && done < CHOICES * ROUND {
                self.choose(state);
            }
            if done >= REST_FROM {
                rest::improve(&self.frames, state);
            }
            converged = settled(&errors, options.tolerance);
            progress(Progress {
                stage: "decomposition",
                done,
                total: options.iterations,
            });
        }
        self.join(state);
        self.motions(state);
        (done, converged)
    }

    fn motions(&self, state: &mut State) -> f64 {
        let bones = self.bones(state);
        transforms::improve(&self.frames, state, &bones)
    }

    fn bones(&self, state: &State) -> Bones<'_> {
        Bones {
            vertices: state.skin.by_bone(self.centres.len()),
            near: &self.level.near,
            joints: &self.joints,
            centres: &self.centres,
        }
    }

    fn choose(&self, state: &mut State) {
        let (frames, labels) = (&self.frames, &self.level.labels);
        choose::choose(frames, state, &self.filter, &self.around, labels);
        self.join(state);
    }

    /// No bone's skin in pieces.
    fn join(&self, state: &mut State) {
        while islands::remove(&mut state.skin, &self.mesh.one_ring, self.centres.len()) {}
    }

    fn finish(
        &self,
        hierarchy: &Hierarchy,
        state: &State,
        (iterations, converged): (usize, bool),
    ) -> Decomposition {
        let frames = &self.frames;
        let (origin, unit) = (hierarchy.origin, hierarchy.diagonal);
        let errors = state.errors(frames);
        let sum: f64 = errors.iter().map(|e| e.0).sum();
        let count = (3 * frames.frames() * frames.vertices) as f64;
        let mut mse = errors.iter().map(|e| e.1 / frames.diagonal.powi(2));
        let mse = frames.clips.iter().map(|&n| mse.by_ref().take(n).collect());
        let mse = mse.collect();
        // x -> R (x - o) + o + T in the sequence's units.
        let motion = |(r, t): (DMat3, DVec3)| (r, origin - r * origin + unit * t);
        let mut all = frames
            .chunks
            .iter()
            .zip(&state.motions)
            .flat_map(|(chunk, motions)| {
                let frame = |lane| motions.iter().map(|m| motion(m.lane(lane))).collect();
                (0..chunk.frames).map(frame).collect::<Vec<Vec<_>>>()
            });
        let motions = frames.clips.iter().map(|&n| all.by_ref().take(n).collect());
        let motions = motions.collect();
        let influences = |v: usize| {
            let mut list: Vec<(u32, f32)> =
                state.skin.pairs(v).map(|(b, w)| (b, w as f32)).collect();
            list.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            list
        };
        Decomposition {
            rest: state
                .rest
                .iter()
                .map(|p| (origin + *p * unit).as_vec3())
                .collect(),
            influences: (0..frames.vertices).map(influences).collect(),
            centres: self.centres.iter().map(|c| origin + *c * unit).collect(),
            motions,
            e_rms: 2000.0 * (sum / count).sqrt() / frames.diagonal,
            mse,
            iterations,
            converged,
        }
    }
}

/// Whether the least error fell in the last round of iterations by less than the tolerance for each. A single one may raise
/// it: mixed weights do not follow the error alone, and islands cost something where bones are chosen anew.
fn settled(errors: &[f64], tolerance: f64) -> bool {
    let before = errors.len().saturating_sub(ROUND);
    let least = |errors: &[f64]| errors.iter().copied().fold(f64::INFINITY, f64::min);
    let (before, last) = (least(&errors[..before]), least(&errors[before..]));
    before.is_finite() && before - last <= ROUND as f64 * tolerance * before
}
