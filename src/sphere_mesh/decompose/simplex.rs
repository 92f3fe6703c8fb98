//! Weights of one vertex: a convex quadratic over the simplex, solved exactly.

/// Most bones that one vertex can choose from.
pub(super) const MOST: usize = 24;

/// Minimises wᵀ (A + ridge I) w − 2 bᵀ w over w ≥ 0, Σ w = 1 by an active set; A is symmetric, with `stride` numbers a row, and
/// positive definite with the ridge.
///
/// Starts from `w`, which must be feasible. Each step solves the equality problem on the positive weights; where that leaves
/// the simplex, it stops at the boundary and drops the weight that reached 0; where it does not, it frees the weight whose
/// multiplier is most negative. The cost falls with every step, so no set comes twice.
pub(super) fn minimise(a: &[f64], stride: usize, ridge: f64, b: &[f64], w: &mut [f64]) {
    debug_assert!(w.len() <= MOST.min(stride) && b.len() == w.len());
    let a = Matrix {
        cells: a,
        stride,
        ridge,
    };
    // Most problems are small, and clearing memory for great ones would take most of the time.
    match w.len() {
        0..=4 => on_simplex::<4>(&a, b, w),
        5..=8 => on_simplex::<8>(&a, b, w),
        _ => on_simplex::<MOST>(&a, b, w),
    }
}

/// A + ridge I.
struct Matrix<'a> {
    cells: &'a [f64],
    stride: usize,
    ridge: f64,
}

impl Matrix<'_> {
    fn at(&self, row: usize, column: usize) -> f64 {
        let ridge = if row == column { self.ridge } else { 0.0 };
        self.cells[row * self.stride + column] + ridge
    }
}

/// [`minimise`] for at most `N` weights.
fn on_simplex<const N: usize>(a: &Matrix, b: &[f64], w: &mut [f64]) {
    let n = w.len();
    let scale = (0..n).map(|k| a.at(k, k)).fold(0.0, f64::max);
    let mut free = [false; N];
    for k in 0..n {
        free[k] = w[k] > 0.0;
    }
    // Far more than ever seen; a bound, should rounding make a set come twice.
    for _ in 0..8 * n {
        let Some((target, multiplier)) = on_free::<N>(a, b, &free[..n]) else {
            return;
        };
        let step = (0..n).filter(|&k| free[k] && target[k] < 0.0);
        let step = step.map(|k| (w[k] / (w[k] - target[k]), k));
        if let Some((t, gone)) = step.min_by(|x, y| x.0.total_cmp(&y.0)) {
            for k in 0..n {
                w[k] += t * (target[k] - w[k]);
            }
            free[gone] = false;
            w[gone] = 0.0;
            continue;
        }
        w.copy_from_slice(&target[..n]);
        let gradient = |k: usize| (0..n).map(|l| a.at(k, l) * w[l]).sum::<f64>() - b[k];
        let bound = (0..n).filter(|&k| !free[k]);
        let worst = bound.map(|k| (gradient(k) - multiplier, k));
        match worst.min_by(|x, y| x.0.total_cmp(&y.0)) {
            Some((slack, k)) if slack < -1e-12 * scale => free[k] = true,
            _ => return,
        }
    }
}

/// The minimum on the free weights with Σ w = 1, and the multiplier of that constraint.
///
/// With A x = b and A y = 1 it is x + s y with s = (1 − Σ x) / Σ y, and s is the multiplier.
fn on_free<const N: usize>(a: &Matrix, b: &[f64], free: &[bool]) -> Option<([f64; N], f64)> {
    let mut rows = [0; N];
    let m = chosen(free, &mut rows);
    let mut lower = [[0.0; N]; N];
    let (mut x, mut y) = ([0.0; N], [1.0; N]);
    for (x, &row) in x.iter_mut().zip(&rows[..m]) {
        *x = b[row];
    }
    let lower = &mut lower.as_flattened_mut()[..m * m];
    factor(a, &rows[..m], lower)?;
    substitute(lower, &mut x[..m]);
    substitute(lower, &mut y[..m]);
    let sum = |v: &[f64]| v[..m].iter().sum::<f64>();
    let multiplier = (1.0 - sum(&x)) / sum(&y);
    let mut target = [0.0; N];
    for i in 0..m {
        target[rows[i]] = x[i] + multiplier * y[i];
    }
    multiplier.is_finite().then_some((target, multiplier))
}

/// Rows that are free, and their number.
///
/// Not inlined, nor are the loops below: where the compiler knows the greatest size it unrolls them one in another, for
/// minutes and to no gain.
#[inline(never)]
fn chosen(free: &[bool], rows: &mut [usize]) -> usize {
    let mut m = 0;
    for k in (0..free.len()).filter(|&k| free[k]) {
        rows[m] = k;
        m += 1;
    }
    m
}

/// Cholesky's factor of some rows and columns; nothing where that is not positive definite.
#[inline(never)]
fn factor(a: &Matrix, rows: &[usize], lower: &mut [f64]) -> Option<()> {
    let m = rows.len();
    for i in 0..m {
        for j in 0..=i {
            let (row, before) = (&lower[i * m..][..j], &lower[j * m..][..j]);
            let product = |(x, y): (&f64, &f64)| x * y;
            let sum = a.at(rows[i], rows[j]) - row.iter().zip(before).map(product).sum::<f64>();
            if i != j {
                lower[i * m + j] = sum / lower[j * m + j];
            } else if sum > 0.0 {
                lower[i * m + i] = sum.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(())
}

/// Solves L Lᵀ x = x.
#[inline(never)]
fn substitute(lower: &[f64], x: &mut [f64]) {
    let m = x.len();
    for i in 0..m {
        for k in 0..i {
            x[i] -= lower[i * m + k] * x[k];
        }
        x[i] /= lower[i * m + i];
    }
    for i in (0..m).rev() {
        for k in i + 1..m {
            x[i] -= lower[k * m + i] * x[k];
        }
        x[i] /= lower[i * m + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost(a: &[f64], b: &[f64], w: &[f64]) -> f64 {
        let n = w.len();
        let row = |k: usize| w[k] * ((0..n).map(|l| a[k * n + l] * w[l]).sum::<f64>() - 2.0 * b[k]);
        (0..n).map(row).sum()
    }

    #[test]
    fn no_neighbour_on_the_simplex_is_cheaper() {
        let mut seed = 7u32;
        let mut next = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        for round in 0..200 {
            let n = 1 + round % 12;
            let g: Vec<f64> = (0..n * n).map(|_| next()).collect();
            let mut a = vec![0.0; n * n];
            // The same without ridge, in longer rows.
            let mut plain = vec![f64::NAN; n * (n + 3)];
            for (k, cell) in a.iter_mut().enumerate() {
                let (i, j) = (k / n, k % n);
                *cell = (0..n).map(|l| g[i * n + l] * g[j * n + l]).sum();
                plain[i * (n + 3) + j] = *cell;
                *cell += if i == j { 1e-4 } else { 0.0 };
            }
            let b: Vec<f64> = (0..n).map(|_| next()).collect();
            let mut w = vec![1.0 / n as f64; n];
            minimise(&plain, n + 3, 1e-4, &b, &mut w);
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-9, "{w:?}");
            assert!(w.iter().all(|x| *x >= 0.0), "{w:?}");
            let best = cost(&a, &b, &w);
            for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
                let mut other = w.clone();
                let step = (1e-3f64).min(other[i]);
                other[i] -= step;
                other[j] += step;
                assert!(cost(&a, &b, &other) >= best - 1e-12, "round {round}: {w:?}");
            }
        }
    }
}
