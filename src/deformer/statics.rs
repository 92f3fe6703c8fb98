//! What a deformer uploads once: a rig as the passes read it.

mod flesh;

use std::collections::BTreeMap;

use bytemuck::{Pod, cast_slice};
use glam::{Mat4, Vec3};

use super::{
    Kind, Method, Resource, Settings,
    heads::{self, Heads},
    plan::{Sizes, dispatch_rows},
};
use crate::{
    Error, Result,
    compose::{Fold, Operator, TABLE},
    layout::{
        CELLS, FieldPose, FieldsHead, JointPose, MAX_FIELDS, NO_FIELD, NO_SEED, SET_BLOCK,
        SET_SEEDS, Vertex, composition,
    },
    mesh::cotangent,
    rig::Rig,
};

/// Iso-values below this belong to vertices that no field reaches.
const REACHED: f32 = 1e-4;

/// A field reaches a vertex of this iso-value.
pub(super) fn reached(iso: f32) -> bool {
    iso > REACHED
}

/// How a field follows a pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    pub(super) joint: u32,
    /// Box coordinates → rest space.
    pub(super) to_rest: Mat4,
}

/// Initial words of every buffer, and how the fields are linked.
#[derive(Debug, Default)]
pub(super) struct Statics {
    pub(super) sizes: Sizes,
    /// Initial content; buffers that are not here start as zeros of [`Statics::words`].
    pub(super) content: BTreeMap<u32, Vec<u32>>,
    /// Words of every buffer, with the parts of all instances.
    pub(super) words: BTreeMap<u32, usize>,
    /// Words of an instance's part of the buffers that have parts.
    parts: BTreeMap<u32, usize>,
    /// Row of the rig's field of every posed field.
    pub(super) order: Vec<u32>,
    /// The rig's fields, a row each: a rig has far more of them than poses need.
    pub(super) carried: Vec<Carried>,
    /// [`crate::layout::FieldPose::link`] of every posed field.
    pub(super) links: Vec<u32>,
    /// Greatest distance of a vertex from the origin, in rest units.
    pub(super) reach: f32,
    /// Distance in rest units by which points may miss each other and still move as one.
    pub(super) still: f32,
    /// Operators with a volume, in the order of their numbers (from 1).
    pub(super) operators: Vec<Operator>,
}

fn carried(rig: &Rig) -> Vec<Carried> {
    let fields = rig.fields.iter().map(|field| Carried {
        joint: u32::from(field.joint),
        to_rest: field.bounds.to_rest(),
    });
    fields.collect()
}

impl Statics {
    /// Everything that follows from the rig alone.
    pub(super) fn new(rig: &Rig, settings: &Settings) -> Result<Self> {
        check(rig)?;
        let mut s = Self {
            sizes: Sizes {
                vertices: rig.mesh.positions.len() as u32,
                rows: rig.rows.vertex.len() as u32,
                joints: rig.skeleton.joints.len() as u32,
                width: rig.weights.width as u32,
                fields: rig.fields.len() as u32,
                fleshed: 0,
                composition: composition::UNIONS,
                instances: settings.instances,
            },
            ..Self::default()
        };
        s.carried = carried(rig);
        s.mesh(rig);
        s.influences(rig);
        s.flesh(rig);
        match settings.method {
            Method::Tracking => {
                s.tracking_composition(rig)?;
                s.ring_weights(rig, settings);
            }
            _ => s.composition(rig, settings.method)?,
        }
        let lengths = rig.mesh.positions.iter().map(|p| p.length());
        s.reach = lengths.fold(0.0, f32::max);
        let radii = rig.fields.iter().map(|f| rig.radius[f.joint as usize]);
        s.still = STILL * radii.reduce(f32::min).unwrap_or(0.0);
        s.transients(settings);
        Ok(s)
    }

    /// Words of an instance's part of a buffer; of a buffer without parts, all of them.
    pub(super) fn part(&self, resource: Resource) -> usize {
        let row = resource as u32;
        let words = self.parts.get(&row).or_else(|| self.words.get(&row));
        words.copied().unwrap_or(0)
    }

    /// Bytes of the posed fields of an instance.
    pub(super) fn fields_bytes(&self) -> usize {
        size_of::<FieldsHead>() + self.sizes.field_room() as usize * size_of::<FieldPose>()
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
    pub(super) fn heads(&self, settings: &Settings, seeds: usize) -> Heads {
        let rows = dispatch_rows(settings) as usize;
        let mut heads = Heads::empty(rows, self.sizes.instances as usize);
        heads.set(0, seeds);
        heads
    }

    fn put<T: Pod>(&mut self, resource: Resource, content: &[T]) {
        let words: Vec<u32> = cast_slice(content).to_vec();
        // No buffer is empty.
        self.words.insert(resource as u32, words.len().max(4));
        self.content.insert(resource as u32, words);
    }

    /// So many elements for every instance, where instances have one each.
    fn size<T>(&mut self, resource: Resource, count: usize) {
        let words = (count.max(1) * size_of::<T>()).div_ceil(4);
        let mut all = words;
        if resource.kind() == Kind::Transient {
            self.parts.insert(resource as u32, words);
            all *= self.sizes.instances as usize;
        }
        self.words.insert(resource as u32, all.max(4));
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

    fn composition(&mut self, rig: &Rig, method: Method) -> Result<()> {
        self.order = (0..self.sizes.fields).collect();
        let mut curves: Vec<[f32; TABLE]> = Vec::new();
        for field in 0..rig.fields.len() {
            let c = &rig.composition;
            let operator = c.operator[field].unwrap_or_default();
            if matches!(operator, Operator::Contact | Operator::Profile)
                && method == Method::Implicit
            {
                return Err(misplaced(rig, field, operator, "tracking"));
            }
            let parent = c.parent[field];
            if operator == Operator::Union || parent == u32::MAX {
                self.links.push(NO_FIELD);
                continue;
            }
            let number = row_of(&mut self.operators, operator) + 1;
            let opening = c.opening[field].unwrap_or_else(|| operator.default_opening());
            let curve = curve_of(&mut curves, opening.table())?;
            self.links
                .push(parent | (number as u32) << 16 | curve << 24);
        }
        if !self.operators.is_empty() {
            self.sizes.composition = composition::OPERATORS;
        }
        self.put(Resource::Opening, &curves.concat());
        Ok(())
    }

    /// The walk over the composition tree: the contact's volume is the first.
    fn tracking_composition(&mut self, rig: &Rig) -> Result<()> {
        let fold = Fold::new(&rig.composition);
        self.sizes.composition = if fold.has_groups() {
            composition::GROUPS
        } else {
            composition::CONTACTS
        };
        self.operators.push(Operator::Contact);
        let mut curves: Vec<[f32; TABLE]> = Vec::new();
        for leaf in &fold.leaves {
            let against = curve_of(&mut curves, leaf.group_controller.table())?;
            let inside = curve_of(&mut curves, leaf.controller.table())?;
            let number = match leaf.operator {
                Operator::Blend => {
                    return Err(misplaced(
                        rig,
                        leaf.field as usize,
                        leaf.operator,
                        "implicit",
                    ));
                }
                Operator::Union | Operator::Contact => 1,
                other => row_of(&mut self.operators, other) as u32 + 1,
            };
            self.order.push(leaf.field);
            self.links
                .push(leaf.group | against << 8 | number << 16 | inside << 24);
        }
        self.put(Resource::Opening, &curves.concat());
        Ok(())
    }

    /// Cotangent weights of the one-rings, with sum 1 less the tie of a vertex; none is negative, so that the Jacobi
    /// iteration converges.
    fn ring_weights(&mut self, rig: &Rig, settings: &Settings) {
        let mut weights = cotangent(&rig.mesh);
        let loose = loose_components(rig);
        for (v, row) in rig.mesh.one_ring.offsets.windows(2).enumerate() {
            let row = &mut weights[row[0] as usize..row[1] as usize];
            for w in row.iter_mut() {
                *w = w.clamp(LEAST_WEIGHT, MOST_WEIGHT);
            }
            let sum: f32 = row.iter().sum();
            let loose = loose[rig.mesh.components[v] as usize];
            let tie = if loose {
                settings.loose_tie
            } else {
                settings.tie
            };
            for w in row {
                *w *= (1.0 - tie) / sum;
            }
        }
        self.put(Resource::RingWeights, &weights);
    }

    /// What tracking knows of every vertex: iso-value, radius, freedom to slide (none where it is rigid), rank of its seed or -1.
    pub(super) fn bodies(rig: &Rig, iso: &[f32], ranks: &[u32]) -> Vec<[f32; 4]> {
        let rank = |v: usize| {
            if ranks[v] == NO_SEED {
                -1.0
            } else {
                ranks[v] as f32
            }
        };
        let free = |v: usize| match rig.mesh.one_ring.row(v) {
            [] => 0.0,
            _ => 1.0 - rig.rigid[v],
        };
        let body = |v: usize| [iso[v], rig.radius[rig.part[v] as usize], free(v), rank(v)];
        (0..iso.len()).map(body).collect()
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
            Resource::Bodies,
            Resource::Tracked,
            Resource::TrackedBefore,
            Resource::TrackedSlopes,
            Resource::Corrections,
            Resource::TrackA,
            Resource::TrackB,
            Resource::TrackC,
            Resource::SlopesA,
            Resource::SlopesB,
            Resource::Goals,
        ];
        for r in vectors {
            self.size::<[f32; 4]>(r, vertices);
        }
        let skinned = if settings.method == Method::Dqs {
            rows
        } else {
            vertices
        };
        self.size::<[f32; 4]>(Resource::Rotations, skinned);
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
            Resource::Around,
        ];
        for r in words {
            self.size::<u32>(r, vertices);
        }
        self.size::<[f32; 2]>(Resource::Stirs, vertices);
        for r in [Resource::SkinPositions, Resource::SkinNormals] {
            self.size::<[f32; 4]>(r, rows);
        }
        let blocks = vertices.div_ceil(SET_SEEDS);
        for r in [Resource::LiveSet, Resource::ContactSet, Resource::RegionSet] {
            self.size::<u32>(r, blocks * SET_BLOCK);
        }
        let rows = dispatch_rows(settings) as usize;
        let heads = heads::words(rows, self.sizes.instances as usize);
        for (r, copies) in [
            (Resource::SeedDispatches, 1),
            (Resource::Dispatches, 1),
            (Resource::History, settings.max_rounds() as usize),
        ] {
            self.words.insert(r as u32, heads * copies);
        }
        self.size::<u32>(Resource::Faults, 1);
        self.size::<JointPose>(Resource::Palette, self.sizes.joints as usize);
        self.size::<u8>(Resource::Fields, self.fields_bytes());
        self.size::<u32>(
            Resource::Index,
            (CELLS * CELLS * CELLS * self.cell_words()) as usize,
        );
    }
}

/// Components that nothing holds on the surface they lie on: open ones, and shells on a single part.
fn loose_components(rig: &Rig) -> Vec<bool> {
    let mesh = &rig.mesh;
    let count = mesh.components.iter().max().map_or(0, |c| *c as usize + 1);
    let (mut open, mut part, mut several) =
        (vec![false; count], vec![None; count], vec![false; count]);
    for (v, &component) in mesh.components.iter().enumerate() {
        let c = component as usize;
        open[c] |= mesh.boundary[v];
        several[c] |= *part[c].get_or_insert(rig.part[v]) != rig.part[v];
    }
    open.iter().zip(&several).map(|(o, s)| *o || !s).collect()
}

/// Bounds of a cotangent weight: a sliver must neither let its neighbours go nor drown them.
const LEAST_WEIGHT: f32 = 1e-3;
const MOST_WEIGHT: f32 = 20.0;

/// An operator that another method has.
fn misplaced(rig: &Rig, field: usize, operator: Operator, method: &str) -> Error {
    let joint = rig.fields[field].joint as usize;
    Error::Joint {
        joint: rig.skeleton.joints[joint].name.clone(),
        reason: format!("the operator {} is for --method {method}", operator.name()),
    }
}

/// Number of a curve's table.
fn curve_of(curves: &mut Vec<[f32; TABLE]>, table: [f32; TABLE]) -> Result<u32> {
    match row_of(curves, table) {
        row @ ..=255 => Ok(row as u32),
        _ => Err(Error::argument(
            "--opening",
            "more than 256 different curves",
        )),
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
