//! Weights that spread along the skin.

use dermis::asset::Influence;

/// Influences a vertex that a file keeps.
const KEPT: usize = 4;
/// Smaller weights are left out.
const LEAST: f64 = 0.01;

/// Gives each vertex wholly to its joint, then lets the weights diffuse over the surface for some rounds.
///
/// Diffusion follows the skin, so that fingers or thighs that lie side by side share nothing.
pub(crate) fn diffused(
    joint: &[usize],
    joints: usize,
    neighbours: &[Vec<u32>],
    rounds: usize,
) -> Vec<Vec<Influence>> {
    let mut weights = vec![vec![0.0; joint.len()]; joints];
    for (vertex, joint) in joint.iter().enumerate() {
        weights[*joint][vertex] = 1.0;
    }
    for of_joint in &mut weights {
        for _ in 0..rounds {
            *of_joint = spread(of_joint, neighbours);
        }
    }
    let vertices = 0..joint.len();
    vertices
        .map(|v| strongest(weights.iter().map(|w| w[v])))
        .collect()
}

fn spread(values: &[f64], neighbours: &[Vec<u32>]) -> Vec<f64> {
    let mean =
        |list: &[u32]| list.iter().map(|n| values[*n as usize]).sum::<f64>() / list.len() as f64;
    values
        .iter()
        .zip(neighbours)
        .map(|(own, list)| 0.5 * own + 0.5 * mean(list))
        .collect()
}

/// The greatest weights first, together 1.
pub(crate) fn strongest(weights: impl Iterator<Item = f64>) -> Vec<Influence> {
    let mut kept: Vec<(usize, f64)> = weights.enumerate().filter(|(_, w)| *w >= LEAST).collect();
    kept.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    kept.truncate(KEPT);
    let sum: f64 = kept.iter().map(|(_, w)| w).sum();
    let influence = |(joint, weight)| Influence {
        joint: joint as u16,
        weight: (weight / sum) as f32,
    };
    kept.into_iter().map(influence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_fall_smoothly_and_sum_to_one() {
        // Ten vertices in a row, the first five of joint 0.
        let joint: Vec<usize> = (0..10).map(|i| i / 5).collect();
        let neighbours: Vec<Vec<u32>> = (0..10_u32)
            .map(|i| {
                [i.checked_sub(1), (i < 9).then_some(i + 1)]
                    .into_iter()
                    .flatten()
                    .collect()
            })
            .collect();
        let lists = diffused(&joint, 2, &neighbours, 6);
        let of_first =
            |list: &Vec<Influence>| list.iter().find(|i| i.joint == 0).map_or(0.0, |i| i.weight);
        let row: Vec<f32> = lists.iter().map(of_first).collect();
        assert!(
            row.is_sorted_by(|a, b| a >= b) && row[0] == 1.0 && row[9] == 0.0,
            "{row:?}"
        );
        assert!(row[4] < 0.8 && row[5] > 0.2, "{row:?}");
        for list in &lists {
            let sum: f32 = list.iter().map(|i| i.weight).sum();
            assert!((sum - 1.0).abs() < 1e-6);
        }
    }
}
