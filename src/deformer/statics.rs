//! What a deformer uploads once: a rig as the passes read it.

use std::collections::BTreeMap;

use bytemuck::{Pod, cast_slice};
use glam::Vec3;

use super::{Resource, Settings, plan::Sizes};
use crate::{
    Error, Result,
    compose::{OpeningCurve, Operator},
    layout::{CELLS, Dispatch, MAX_FIELDS, NO_FIELD, NO_SEED, SET_BLOCK, SET_SEEDS, Vertex},
    rig::Rig,
};

/// Iso-values below this belong to vertices that no field reaches.
const REACHED: f32 = 1e-4;

/// A field reaches a vertex of this iso-value.
pub(super) fn reached(iso: f32) -> bool {
    iso > REACHED
}

/// Initial words of every buffer, and how the fields are linked.
#[derive(Debug, Default)]
pub(super) struct Statics {
    pub(super) sizes: Sizes,
    pub(super) joints: usize,
    /// Initial content; buffers that are not here start as zeros of [`Statics::words`].
    pub(super) content: BTreeMap<u32, Vec<u32>>,
    /// Words of every buffer.
    pub(super) words: BTreeMap<u32, usize>,
    /// [`crate::layout::FieldPose::link`] of every field.
    pub(super) links: Vec<u32>,
    /// Greatest distance of a vertex from the origin, in rest units.
    pub(super) reach: f32,
    /// Distance in rest units by which points may miss each other and still move as one.
    pub(super) still: f32,
    /// Operators with a volume, in the order of their numbers (from 1).
    pub(super) operators: Vec<Operator>,
}

impl Statics {
    /// Everything that follows from the rig alone.
    pub(super) fn new(rig: &Rig, settings: &Settings) -> Result<Self> {
        check(rig)?;
        let mut s = Self {
            sizes: Sizes {
                vertices: rig.mesh.positions.len() as u32,
                rows: rig.rows.vertex.len() as u32,
                width: rig.weights.width as u32,
                fields: rig.fields.len() as u32,
                operators: 0,
            },
            joints: rig.skeleton.joints.len(),
            ..Self::default()
        };
        s.mesh(rig);
        s.influences(rig);
        s.composition(rig)?;
        s.sizes.operators = s.operators.len() as u32;
        let lengths = rig.mesh.positions.iter().map(|p| p.length());
        s.reach = lengths.fold(0.0, f32::max);
        let radii = rig.fields.iter().map(|f| rig.radius[f.joint as usize]);
        s.still = STILL * radii.reduce(f32::min).unwrap_or(0.0);
        s.transients(settings);
        Ok(s)
    }

    /// Words of an index cell; shaders read them in pairs.
    pub(super) fn cell_words(&self) -> u32 {
        2 * self.sizes.fields.div_ceil(64).max(1)
    }

    /// The list of vertices to project: in reach of a field and not bound to geometric skinning. Close at rest is close in
    /// the list, so that vertices that are projected together meet the same fields and the same texels.
    pub(super) fn seeds(rig: &Rig, iso: &[f32]) -> Vec<u32> {
        let movable = |v: &u32| reached(iso[*v as usize]) && !rig.geometric[*v as usize];
        let mut seeds: Vec<u32> = (0..rig.mesh.positions.len() as u32)
            .filter(movable)
            .collect();
        let points = || seeds.iter().map(|v| rig.mesh.positions[*v as usize]);
        let low = points().reduce(Vec3::min).unwrap_or(Vec3::ZERO);
        let high = points().reduce(Vec3::max).unwrap_or(Vec3::ONE);
        let cells = MORTON_CELLS / (high - low).max_element().max(f32::MIN_POSITIVE);
        seeds.sort_by_cached_key(|v| morton((rig.mesh.positions[*v as usize] - low) * cells));
        seeds
    }

    /// Row of every vertex in the list of seeds.
    pub(super) fn seed_ranks(vertices: usize, seeds: &[u32]) -> Vec<u32> {
        let mut ranks = vec![NO_SEED; vertices];
        for (rank, &v) in seeds.iter().enumerate() {
            ranks[v as usize] = rank as u32;
        }
        ranks
    }

    /// Heads of the work lists as a frame begins: the seeds, the rest empty.
    pub(super) fn dispatches(settings: &Settings, seeds: usize) -> Vec<Dispatch> {
        let mut heads = vec![Dispatch::of(0); super::plan::dispatch_rows(settings) as usize];
        heads[0] = Dispatch::of(seeds);
        heads
    }

    fn put<T: Pod>(&mut self, resource: Resource, content: &[T]) {
        let words: Vec<u32> = cast_slice(content).to_vec();
        // No buffer is empty.
        self.words.insert(resource as u32, words.len().max(4));
        self.content.insert(resource as u32, words);
    }

    fn size<T>(&mut self, resource: Resource, count: usize) {
        let words = (count.max(1) * size_of::<T>()).div_ceil(4);
        self.words.insert(resource as u32, words.max(4));
    }

    fn mesh(&mut self, rig: &Rig) {
        let mesh = &rig.mesh;
        let vertices: Vec<Vertex> = (0..mesh.positions.len())
            .map(|v| Vertex {
                position: mesh.positions[v].to_array(),
                radius: rig.radius[rig.part[v] as usize],
                normal: mesh.normals[v].to_array(),
                part: rig.part[v].into(),
            })
            .collect();
        self.put(Resource::Vertices, &vertices);
        self.put(Resource::FileRows, &rig.rows.vertex);
        self.put(Resource::FileNormals, &texels(&rig.rows.normals));
        let identity: Vec<u32> = (0..mesh.positions.len() as u32).collect();
        self.put(Resource::WeldedRows, &identity);
        self.put(Resource::WeldedNormals, &texels(&mesh.normals));
        self.put(Resource::RingOffsets, &mesh.one_ring.offsets);
        self.put(Resource::Rings, &mesh.one_ring.items);
        self.put(Resource::MeanValues, &rig.mean_value);
        self.put(Resource::NeighbourhoodOffsets, &rig.neighbourhood.offsets);
        self.put(Resource::Neighbourhoods, &rig.neighbourhood.items);
        self.put(Resource::CornerOffsets, &mesh.corners.offsets);
        self.put(Resource::Corners, &mesh.corners.items);
    }

    fn influences(&mut self, rig: &Rig) {
        let pairs = rig.weights.joints.chunks(2);
        let packed: Vec<u32> = pairs
            .map(|p| u32::from(p[0]) | u32::from(*p.get(1).unwrap_or(&0)) << 16)
            .collect();
        self.put(Resource::InfluenceJoints, &packed);
        self.put(Resource::InfluenceWeights, &rig.weights.weights);
    }

    fn composition(&mut self, rig: &Rig) -> Result<()> {
        let mut curves: Vec<&OpeningCurve> = Vec::new();
        for field in 0..rig.fields.len() {
            let c = &rig.composition;
            let (operator, parent) = (c.operator[field], c.parent[field]);
            if operator == Operator::Union || parent == u32::MAX {
                self.links.push(NO_FIELD);
                continue;
            }
            let number = row_of(&mut self.operators, operator) + 1;
            let curve = row_of(&mut curves, &c.opening[field]);
            if curve > 255 {
                return Err(Error::argument(
                    "--opening",
                    "more than 256 different opening curves",
                ));
            }
            self.links
                .push(parent | (number as u32) << 16 | (curve as u32) << 24);
        }
        let table: Vec<f32> = curves.iter().flat_map(|c| c.table()).collect();
        self.put(Resource::Opening, &table);
        Ok(())
    }

    fn transients(&mut self, settings: &Settings) {
        let (vertices, rows) = (self.sizes.vertices as usize, self.sizes.rows as usize);
        let vectors = [
            Resource::Geometric,
            Resource::Positions,
            Resource::Relaxed,
            Resource::SmoothNormals,
            Resource::Anchors,
            Resource::Gradients,
            Resource::Directions,
        ];
        for r in vectors {
            self.size::<[f32; 4]>(r, vertices);
        }
        // Both the welded vertices and the file's rows are skinned with their rotations.
        self.size::<[f32; 4]>(Resource::Rotations, vertices.max(rows));
        let words = [
            Resource::SeedList,
            Resource::SeedRanks,
            Resource::IsoValues,
            Resource::Status,
            Resource::LiveA,
            Resource::LiveB,
            Resource::ContactList,
            Resource::RegionList,
            Resource::BetaA,
            Resource::BetaB,
        ];
        for r in words {
            self.size::<u32>(r, vertices);
        }
        for r in [Resource::SkinPositions, Resource::SkinNormals] {
            self.size::<[f32; 4]>(r, rows);
        }
        let blocks = vertices.div_ceil(SET_SEEDS);
        for r in [Resource::LiveSet, Resource::ContactSet, Resource::RegionSet] {
            self.size::<u32>(r, blocks * SET_BLOCK);
        }
        let heads = super::plan::dispatch_rows(settings) as usize;
        for r in [Resource::SeedDispatches, Resource::Dispatches] {
            self.size::<Dispatch>(r, heads);
        }
        self.size::<u32>(
            Resource::Index,
            (CELLS * CELLS * CELLS * self.cell_words()) as usize,
        );
    }
}

/// Share of the least radius; times the slope of a field, at most 1/r, a third of the tolerance of iso-values.
const STILL: f32 = 3e-5;

/// Cells of the Morton code along the longest axis; two thousandths of a character are close enough.
const MORTON_CELLS: f32 = 511.0;

/// Morton code of a cell: its three numbers, bit by bit in turn.
fn morton(cell: Vec3) -> u32 {
    let spread = |x: u32| (0..9).fold(0, |code, bit| code | (x >> bit & 1) << (3 * bit));
    let [x, y, z] = cell.to_array().map(|x| spread(x as u32));
    x | y << 1 | z << 2
}

/// A texel a vector.
fn texels(vectors: &[Vec3]) -> Vec<[f32; 4]> {
    vectors.iter().map(|v| v.extend(0.0).to_array()).collect()
}

/// Row of `item` in `list`, appended where it is not there yet.
fn row_of<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    list.iter()
        .position(|known| *known == item)
        .unwrap_or_else(|| {
            list.push(item);
            list.len() - 1
        })
}

fn check(rig: &Rig) -> Result<()> {
    if rig.fields.len() > MAX_FIELDS {
        let reason = format!("{} fields; at most {MAX_FIELDS} fit", rig.fields.len());
        return Err(Error::argument(rig.name.clone(), reason));
    }
    if rig.mesh.positions.is_empty() || rig.skeleton.joints.is_empty() {
        return Err(Error::argument(
            rig.name.clone(),
            "no vertices or no joints",
        ));
    }
    Ok(())
}
