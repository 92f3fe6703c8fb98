//! Every bone moves one connected piece of skin: weights that landed apart from the rest are given up.

use rayon::prelude::*;

use super::skin::{NONE, NOTHING, Skin};
use crate::mesh::Csr;

/// Takes each bone away from all vertices but those of its greatest piece, by weight, and shares its weights out among the
/// others of the vertex; a vertex that is left with none takes over a neighbour's. Returns whether anything changed.
pub(super) fn remove(skin: &mut Skin, ring: &Csr, bones: usize) -> bool {
    let mut bare = Vec::new();
    let mut changed = false;
    let lists = skin.by_bone(bones);
    let all: Vec<Vec<usize>> = lists.par_iter().map(|list| pieces(ring, list)).collect();
    for (bone, (vertices, piece)) in lists.iter().zip(all).enumerate() {
        let count = piece.iter().max().map_or(0, |p| p + 1);
        if count < 2 {
            continue;
        }
        changed = true;
        let mut mass = vec![0.0; count];
        let pairs = piece.iter().zip(vertices);
        pairs.for_each(|(&p, (_, weight))| mass[p] += weight);
        let kept = (0..count).max_by(|&a, &b| mass[a].total_cmp(&mass[b]));
        for (p, &(v, _)) in piece.iter().zip(vertices) {
            if Some(*p) != kept && !take(skin, v as usize, bone as u32) {
                bare.push(v);
            }
        }
    }
    cover(skin, ring, bare);
    changed
}

/// Number of the connected piece that each of a bone's vertices (ascending) is in.
pub(super) fn pieces(ring: &Csr, vertices: &[(u32, f64)]) -> Vec<usize> {
    let mut piece = vec![usize::MAX; vertices.len()];
    let mut count = 0;
    for start in 0..vertices.len() {
        if piece[start] != usize::MAX {
            continue;
        }
        piece[start] = count;
        let mut open = vec![start];
        while let Some(k) = open.pop() {
            for u in ring.row(vertices[k].0 as usize) {
                if let Ok(l) = vertices.binary_search_by_key(u, |p| p.0)
                    && piece[l] == usize::MAX
                {
                    piece[l] = count;
                    open.push(l);
                }
            }
        }
        count += 1;
    }
    piece
}

/// Takes a bone from a vertex; false where nothing is left then.
fn take(skin: &mut Skin, vertex: usize, bone: u32) -> bool {
    let others = skin.bones(vertex).iter().zip(skin.weights(vertex));
    let mut rest: Vec<(u32, f64)> = others.map(|(b, w)| (*b, *w)).collect();
    rest.retain(|p| p.0 != bone);
    let sum: f64 = rest.iter().map(|p| p.1).sum();
    if sum > NOTHING {
        rest.iter_mut().for_each(|p| p.1 /= sum);
        set(skin, vertex, &rest);
        return true;
    }
    set(skin, vertex, &[]);
    false
}

fn set(skin: &mut Skin, vertex: usize, list: &[(u32, f64)]) {
    for k in 0..skin.width {
        let (bone, weight) = list.get(k).copied().unwrap_or((NONE, 0.0));
        skin.bones[vertex * skin.width + k] = bone;
        skin.weights[vertex * skin.width + k] = weight;
    }
}

/// Bare vertices take over the list of a neighbour that has one, from the edge of the hole inwards.
fn cover(skin: &mut Skin, ring: &Csr, mut bare: Vec<u32>) {
    while !bare.is_empty() {
        let found: Vec<(u32, Vec<(u32, f64)>)> = bare
            .iter()
            .filter_map(|&v| {
                let mut near = ring.row(v as usize).iter().map(|&u| u as usize);
                let u = near.find(|&u| !skin.bones(u).is_empty())?;
                Some((v, skin.pairs(u).collect()))
            })
            .collect();
        debug_assert!(!found.is_empty(), "a whole component has lost its bones");
        if found.is_empty() {
            return;
        }
        for (v, list) in &found {
            set(skin, *v as usize, list);
        }
        bare.retain(|&v| skin.bones(v as usize).is_empty());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weight_apart_is_given_up_and_a_bare_vertex_follows_its_neighbour() {
        let line: Vec<Vec<u32>> = (0..6u32)
            .map(|v| {
                [v.wrapping_sub(1), v + 1]
                    .into_iter()
                    .filter(|u| *u < 6)
                    .collect()
            })
            .collect();
        let ring = Csr::from_rows(&line);
        let lists = [
            vec![(0, 1.0)],
            vec![(0, 0.8), (1, 0.2)],
            vec![(1, 1.0)],
            vec![(1, 0.75), (2, 0.25)],
            vec![(0, 1.0)],
            vec![(1, 0.4), (0, 0.6)],
        ];
        let mut skin = Skin::new(2, &lists);
        assert!(remove(&mut skin, &ring, 3));
        let list = |v: usize| skin.pairs(v).collect::<Vec<_>>();
        assert_eq!(list(1), [(0, 0.8), (1, 0.2)]);
        // Vertex 4 had nothing but the far bone, vertex 5 the bone of the piece that it is now next to.
        assert_eq!(list(4), [(1, 0.75), (2, 0.25)]);
        for bone in skin.by_bone(3) {
            assert!(pieces(&ring, &bone).iter().all(|p| *p == 0));
        }
        assert!((0..6).all(|v| (skin.weights(v).iter().sum::<f64>() - 1.0).abs() < 1e-12));
        assert!(!remove(&mut skin, &ring, 3));
    }
}
