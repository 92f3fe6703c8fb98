//! The spines of a run and what they do to points.

use std::{path::PathBuf, time::Instant};

use dermis::{
    Error, Result,
    flesh::{
        BendOptions, Bent, INVALID, Layer, Map, Registration, Spine, bend, blend, register, torn,
    },
};
use glam::DVec3;

use super::{Args, shape::Shape};

/// One spine in rest and bent.
pub(super) struct Pair {
    pub(super) files: [PathBuf; 2],
    pub(super) rest: Spine,
    pub(super) bent: Spine,
    /// A weight a vertex.
    mask: Option<Vec<f64>>,
}

/// All pairs, and how they are applied.
pub(super) struct Bender {
    pub(super) pairs: Vec<Pair>,
    stretch: bool,
}

/// What varies in a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) map: Map,
    pub(super) slide: f64,
    pub(super) strength: f64,
}

/// A bent mesh, or other points.
pub(super) struct Outcome {
    pub(super) bent: Bent,
    /// Arc length of each point on the first rest spine.
    pub(super) arcs: Vec<f64>,
    /// Torn triangles.
    pub(super) torn: usize,
    /// Milliseconds of registration and of bending.
    pub(super) ms: [f64; 2],
}

impl Bender {
    pub(super) fn load(args: &Args, shape: &Shape) -> Result<Self> {
        let counts = (args.rest.len(), args.bent.len(), args.mask.len());
        if counts.0 != counts.1 {
            let reason = format!("{} given for {} --rest", counts.1, counts.0);
            return Err(Error::argument("--bent", reason));
        }
        if counts.2 != 0 && counts.2 != counts.0 {
            let reason = format!("{} given for {} pairs of spines", counts.2, counts.0);
            return Err(Error::argument("--mask", reason));
        }
        let pair = |row: usize| {
            let files = [args.rest[row].clone(), args.bent[row].clone()];
            let rest = Spine::read(&files[0], None)?;
            let bent = Spine::read(&files[1], Some(&rest))?;
            let mask = args.mask.get(row).map(|joints| shape.mask(joints));
            Ok(Pair {
                rest,
                bent,
                files,
                mask: mask.transpose()?,
            })
        };
        Ok(Self {
            pairs: (0..counts.0).map(pair).collect::<Result<_>>()?,
            stretch: args.stretch,
        })
    }

    /// Whether points other than the mesh's can be bent.
    pub(super) fn anywhere(&self) -> bool {
        self.pairs.iter().all(|pair| pair.mask.is_none())
    }

    fn options(&self, way: &Way) -> BendOptions {
        BendOptions {
            strength: way.strength,
            slide: way.slide,
            stretch: self.stretch,
        }
    }

    pub(super) fn bend(&self, shape: &Shape, way: &Way) -> Result<Outcome> {
        let (positions, normals) = (&shape.positions, &shape.normals);
        let mut outcome = match self.anywhere() {
            true => self.in_turn(positions, normals, shape.triangles(), way)?,
            false => self.at_once(shape, way)?,
        };
        self.blame(&mut outcome)?;
        Ok(outcome)
    }

    /// Any points, without normals.
    pub(super) fn bend_points(&self, points: &[DVec3], way: &Way) -> Result<Outcome> {
        self.in_turn(points, &[], &[], way)
    }

    /// One pair after the other.
    fn in_turn(
        &self,
        positions: &[DVec3],
        normals: &[DVec3],
        triangles: &[[u32; 3]],
        way: &Way,
    ) -> Result<Outcome> {
        let mut outcome = Outcome {
            bent: Bent {
                positions: positions.to_vec(),
                normals: normals.to_vec(),
                distances: vec![f64::INFINITY; positions.len()],
                flags: vec![0; positions.len()],
            },
            arcs: Vec::new(),
            torn: 0,
            ms: [0.0; 2],
        };
        for pair in &self.pairs {
            let last = &outcome.bent;
            let begin = Instant::now();
            let registered = register(&pair.rest, way.map, &last.positions, &last.normals)?;
            outcome.torn += torn(&registered, &last.positions, triangles);
            let middle = Instant::now();
            let mut next =
                bend(&registered, &pair.bent, &self.options(way)).map_err(|e| pair.named(e))?;
            let end = Instant::now();
            outcome.ms[0] += 1e3 * (middle - begin).as_secs_f64();
            outcome.ms[1] += 1e3 * (end - middle).as_secs_f64();
            if outcome.arcs.is_empty() {
                outcome.arcs = registered.anchors.iter().map(|a| a.arc).collect();
            }
            for row in 0..positions.len() {
                next.flags[row] |= last.flags[row];
                next.distances[row] = next.distances[row].min(last.distances[row]);
            }
            outcome.bent = next;
        }
        Ok(outcome)
    }

    /// All pairs, each by its mask.
    fn at_once(&self, shape: &Shape, way: &Way) -> Result<Outcome> {
        let (positions, normals) = (&shape.positions, &shape.normals);
        let begin = Instant::now();
        let registered = self
            .pairs
            .iter()
            .map(|pair| register(&pair.rest, way.map, positions, normals))
            .collect::<Result<Vec<Registration>>>()?;
        let middle = Instant::now();
        let layers: Vec<Layer<'_>> = self
            .pairs
            .iter()
            .zip(&registered)
            .map(|(pair, rest)| Layer {
                rest,
                bent: &pair.bent,
                options: self.options(way),
                weights: pair.mask.as_deref().unwrap_or_default(),
            })
            .collect();
        let bent = blend(positions, normals, &layers)?;
        let ms = [middle - begin, middle.elapsed()].map(|t| 1e3 * t.as_secs_f64());
        let moved = |pair: &Pair, t: &[u32; 3]| {
            let mask = pair.mask.as_deref().unwrap_or_default();
            t.iter().any(|row| mask[*row as usize] > 0.0)
        };
        let torn = self.pairs.iter().zip(&registered).map(|(pair, rest)| {
            let own = shape.triangles().iter().filter(|t| moved(pair, t));
            torn(rest, positions, &own.copied().collect::<Vec<_>>())
        });
        Ok(Outcome {
            torn: torn.sum(),
            arcs: registered[0].anchors.iter().map(|a| a.arc).collect(),
            bent,
            ms,
        })
    }

    /// Nothing that is not finite goes on.
    fn blame(&self, outcome: &mut Outcome) -> Result<()> {
        let rows = outcome.bent.positions.iter().zip(&outcome.bent.normals);
        let single = |v: &DVec3| v.as_vec3().is_finite();
        match rows.into_iter().position(|(p, n)| !single(p) || !single(n)) {
            Some(row) => Err(Error::argument(
                format!("vertex {row}"),
                "the result is not finite: it is too far from the spine",
            )),
            None => Ok(()),
        }
    }
}

impl Pair {
    /// An error about the bent spine, naming its file.
    fn named(&self, error: Error) -> Error {
        match error {
            Error::Argument { argument, reason } if argument == "bent" => {
                Error::asset(&self.files[1], "spine", reason)
            }
            other => other,
        }
    }
}

impl Outcome {
    /// Vertices with any of some flags.
    pub(super) fn flagged(&self, flags: u32) -> usize {
        self.bent.flags.iter().filter(|f| **f & flags != 0).count()
    }

    pub(super) fn invalid(&self) -> usize {
        self.flagged(INVALID)
    }
}
