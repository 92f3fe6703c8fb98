//! Connectivity of a sphere-mesh while its edges collapse.

use crate::mesh::Mesh;

/// Regions by slot, their neighbours and the triangles between them. A slot that lost its region is empty.
#[derive(Debug)]
pub(super) struct Topology {
    /// Neighbouring slots, ascending.
    near: Vec<Vec<u32>>,
    /// Corners as slots; a triangle that lost one is dead.
    corners: Vec<[u32; 3]>,
    /// Live triangles of a slot, and dead ones that nobody has swept away yet.
    fans: Vec<Vec<u32>>,
}

/// Neighbours of a slot and its live triangles.
#[derive(Debug)]
pub(super) struct Surroundings {
    /// Ascending.
    pub(super) near: Vec<u32>,
    fan: Vec<u32>,
}

impl Topology {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let count = mesh.positions.len();
        let mut near = Vec::with_capacity(count);
        for v in 0..count {
            let mut row = mesh.one_ring.row(v).to_vec();
            row.sort_unstable();
            row.dedup();
            near.push(row);
        }
        let mut fans = vec![Vec::new(); count];
        for (row, t) in mesh.triangles.iter().enumerate() {
            for &v in t {
                fans[v as usize].push(row as u32);
            }
        }
        Self {
            near,
            corners: mesh.triangles.clone(),
            fans,
        }
    }

    pub(super) fn near(&self, slot: u32) -> &[u32] {
        &self.near[slot as usize]
    }

    /// What the surroundings of two neighbours become when the two are `u`.
    pub(super) fn united(&self, u: u32, v: u32) -> Surroundings {
        let both = self.near(u).iter().chain(self.near(v)).copied();
        let mut near: Vec<u32> = both.filter(|&k| k != u && k != v).collect();
        near.sort_unstable();
        near.dedup();
        let fans = self.fans[u as usize].iter().chain(&self.fans[v as usize]);
        let live = fans.filter_map(|&t| {
            let [a, b, c] = self.corners[t as usize].map(|k| if k == v { u } else { k });
            let turned = match a.min(b).min(c) {
                least if least == a => [a, b, c],
                least if least == b => [b, c, a],
                _ => [c, a, b],
            };
            (a != b && b != c && c != a).then_some((turned, t))
        });
        let mut fan: Vec<([u32; 3], u32)> = live.collect();
        // Triangles with the same corners and the same side are one.
        fan.sort_unstable();
        fan.dedup_by_key(|(corners, _)| *corners);
        let fan = fan.into_iter().map(|(_, t)| t).collect();
        Surroundings { near, fan }
    }

    /// Triangles that would change if `u` and `v` became one, and that would stay: the corner that moves and the two others.
    pub(super) fn moved(&self, u: u32, v: u32) -> impl Iterator<Item = [u32; 3]> {
        let of = move |slot: u32, other: u32| {
            let live = self.fans[slot as usize].iter();
            live.filter_map(move |&t| {
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

    /// `u` takes over what `v` had: their [`Topology::united`] surroundings.
    pub(super) fn collapse(&mut self, u: u32, v: u32, new: Surroundings) {
        for k in std::mem::take(&mut self.near[v as usize]) {
            let row = &mut self.near[k as usize];
            if let Ok(at) = row.binary_search(&v) {
                row.remove(at);
            }
            if let Err(at) = row.binary_search(&u)
                && k != u
            {
                row.insert(at, u);
            }
        }
        for t in std::mem::take(&mut self.fans[v as usize]) {
            for corner in &mut self.corners[t as usize] {
                *corner = if *corner == v { u } else { *corner };
            }
        }
        self.near[u as usize] = new.near;
        self.fans[u as usize] = new.fan;
    }
}
