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

    /// Neighbours of two neighbours.
    pub(super) fn around(&self, u: u32, v: u32) -> Vec<u32> {
        let (first, second) = (self.near(u), self.near(v));
        let more = second.iter().filter(|k| first.binary_search(k).is_err());
        let all = first.iter().chain(more).copied();
        all.filter(|&k| k != u && k != v).collect()
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

    /// `u` takes over what `v` had.
    pub(super) fn collapse(&mut self, u: u32, v: u32) {
        let theirs = std::mem::take(&mut self.near[v as usize]);
        for &k in theirs.iter().filter(|&&k| k != u) {
            let row = &mut self.near[k as usize];
            if let Ok(at) = row.binary_search(&v) {
                row.remove(at);
            }
            if let Err(at) = row.binary_search(&u) {
                row.insert(at, u);
            }
        }
        let row = &mut self.near[u as usize];
        row.extend(theirs);
        row.sort_unstable();
        row.dedup();
        row.retain(|&k| k != u && k != v);
        let moved = std::mem::take(&mut self.fans[v as usize]);
        let mut fan = std::mem::take(&mut self.fans[u as usize]);
        for &t in &moved {
            for corner in &mut self.corners[t as usize] {
                *corner = if *corner == v { u } else { *corner };
            }
        }
        fan.extend(moved);
        let corners = &self.corners;
        let turned = |t: u32| {
            let [a, b, c] = corners[t as usize];
            match (a.min(b).min(c), a, b) {
                (least, first, _) if least == first => [a, b, c],
                (least, _, second) if least == second => [b, c, a],
                _ => [c, a, b],
            }
        };
        fan.retain(|&t| {
            let [a, b, c] = corners[t as usize];
            a != b && b != c && c != a
        });
        // Triangles with the same corners and the same side are one.
        fan.sort_unstable_by_key(|&t| (turned(t), t));
        fan.dedup_by_key(|t| turned(*t));
        self.fans[u as usize] = fan;
    }
}
