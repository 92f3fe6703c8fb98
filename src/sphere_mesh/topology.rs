//! Connectivity of a sphere-mesh while its edges collapse.

use super::rows::Rows;
use crate::mesh::Mesh;

/// Regions by slot, their neighbours and the triangles between them. A slot that lost its region is empty.
#[derive(Debug)]
pub(super) struct Topology {
    /// Neighbouring slots, ascending.
    near: Rows<u32>,
    /// Corners as slots; a triangle that lost one is dead.
    corners: Vec<[u32; 3]>,
    /// Live triangles of a slot, and dead ones that nobody has swept away yet.
    fans: Rows<u32>,
}

/// Neighbours of a slot and its live triangles.
#[derive(Debug, Default)]
pub(super) struct Surroundings {
    /// Ascending.
    pub(super) near: Vec<u32>,
    fan: Vec<u32>,
    /// Corners of the fan's triangles, the least first.
    corners: Vec<([u32; 3], u32)>,
}

impl Topology {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let count = mesh.positions.len();
        let mut near = Rows::with_capacity(count, mesh.one_ring.items.len());
        let mut row = Vec::new();
        for v in 0..count {
            row.clear();
            row.extend_from_slice(mesh.one_ring.row(v));
            row.sort_unstable();
            row.dedup();
            near.push(row.iter().copied());
        }
        Self {
            near,
            corners: mesh.triangles.clone(),
            fans: fans(mesh),
        }
    }

    pub(super) fn near(&self, slot: u32) -> &[u32] {
        self.near.row(slot as usize)
    }

    /// What the surroundings of two neighbours become when the two are `u`.
    pub(super) fn unite(&self, u: u32, v: u32, new: &mut Surroundings) {
        let both = self.near(u).iter().chain(self.near(v)).copied();
        new.near.clear();
        new.near.extend(both.filter(|&k| k != u && k != v));
        new.near.sort_unstable();
        new.near.dedup();
        new.corners.clear();
        for &t in self.fan(u).iter().chain(self.fan(v)) {
            let [a, b, c] = self.corners[t as usize];
            let renamed = |k: u32| if k == v { u } else { k };
            let (a, b, c) = (renamed(a), renamed(b), renamed(c));
            let turned = match a.min(b).min(c) {
                least if least == a => [a, b, c],
                least if least == b => [b, c, a],
                _ => [c, a, b],
            };
            if a != b && b != c && c != a {
                new.corners.push((turned, t));
            }
        }
        // Triangles with the same corners and the same side are one.
        new.corners.sort_unstable();
        new.corners.dedup_by_key(|(corners, _)| *corners);
        new.fan.clear();
        new.fan.extend(new.corners.iter().map(|(_, t)| t));
    }

    fn fan(&self, slot: u32) -> &[u32] {
        self.fans.row(slot as usize)
    }

    /// Triangles that would change if `u` and `v` became one, and that would stay: the corner that moves and the two others.
    pub(super) fn moved(&self, u: u32, v: u32) -> impl Iterator<Item = [u32; 3]> {
        let of = move |slot: u32, other: u32| {
            self.fan(slot).iter().filter_map(move |&t| {
                let [a, b, c] = self.corners[t as usize];
                let turned = match slot {
                    s if s == a => [a, b, c],
                    s if s == b => [b, c, a],
                    s if s == c => [c, a, b],
                    _ => return None,
                };
                let dead = turned[1] == turned[2] || turned[1] == slot || turned[2] == slot;
                (!dead && turned[1] != other && turned[2] != other).then_some(turned)
            })
        };
        of(u, v).chain(of(v, u))
    }

    /// `u` takes over what `v` had: the surroundings that [`Topology::unite`] found.
    pub(super) fn collapse(&mut self, u: u32, v: u32, new: &Surroundings) {
        for i in 0..self.near.len(v as usize) {
            let k = self.near(v)[i];
            if k != u {
                self.rename(k, v, u);
            }
        }
        for &t in self.fans.row(v as usize) {
            for corner in &mut self.corners[t as usize] {
                *corner = if *corner == v { u } else { *corner };
            }
        }
        self.near.replace(u as usize, &new.near);
        self.fans.replace(u as usize, &new.fan);
        self.near.clear(v as usize);
        self.fans.clear(v as usize);
    }

    /// Among the neighbours of `k`, `v` becomes `u`.
    fn rename(&mut self, k: u32, v: u32, u: u32) {
        let row = self.near.row_mut(k as usize);
        let (Ok(from), to) = (row.binary_search(&v), row.binary_search(&u)) else {
            return;
        };
        match to {
            Ok(_) => self.near.remove(k as usize, from),
            Err(to) if to > from => {
                row[from..to].rotate_left(1);
                row[to - 1] = u;
            }
            Err(to) => {
                row[to..=from].rotate_right(1);
                row[to] = u;
            }
        }
    }
}

/// Triangles of each vertex, ascending.
fn fans(mesh: &Mesh) -> Rows<u32> {
    let mut left = vec![0; mesh.positions.len()];
    for &v in mesh.triangles.as_flattened() {
        left[v as usize] += 1;
    }
    let mut fans = Rows::with_capacity(left.len(), 3 * mesh.triangles.len());
    for &degree in &left {
        fans.push(std::iter::repeat_n(0, degree));
    }
    for (row, t) in mesh.triangles.iter().enumerate().rev() {
        for v in t.map(|v| v as usize) {
            left[v] -= 1;
            fans.row_mut(v)[left[v]] = row as u32;
        }
    }
    fans
}
