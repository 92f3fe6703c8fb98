//! Neighbourhoods of several rings.

use rayon::prelude::*;

use super::{Csr, Mesh};

/// Vertices within `n` edges of each vertex, itself included, ascending.
pub fn rings(mesh: &Mesh, n: usize) -> Csr {
    let rows: Vec<Vec<u32>> = (0..mesh.positions.len() as u32)
        .into_par_iter()
        .map(|v| grow(mesh, v, n))
        .collect();
    Csr::from_rows(&rows)
}

fn grow(mesh: &Mesh, v: u32, n: usize) -> Vec<u32> {
    let mut known = vec![v];
    let mut front = vec![v];
    for _ in 0..n {
        let mut next: Vec<u32> = front
            .iter()
            .flat_map(|&u| mesh.one_ring.row(u as usize))
            .copied()
            .filter(|u| known.binary_search(u).is_err())
            .collect();
        next.sort_unstable();
        next.dedup();
        known.extend(&next);
        known.sort_unstable();
        front = next;
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn rings_of_a_strip_are_intervals() {
        let n = 20;
        let p = (0..n).map(|i| Vec3::new((i / 2) as f32, (i % 2) as f32, 0.0));
        let mesh = Mesh::new(p.collect(), (0..n - 2).map(|i| [i, i + 1, i + 2]).collect());
        let two = rings(&mesh, 2);
        assert_eq!(two.row(10), (6..=14).collect::<Vec<_>>());
        assert_eq!(two.row(0), (0..=4).collect::<Vec<_>>());
        assert_eq!(rings(&mesh, 0).row(7), [7]);
    }
}
